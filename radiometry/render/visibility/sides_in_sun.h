// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the sun reaches the visible sides, in place of shadow rays.
//
// In the picture that the sun sees (sun_picture.h) a place on a side is in the shadow if triangles cover it that are
// above the plane of the side there. How many do is a winding number (Edelsbrunner, "Geometry and Topology for Mesh
// Generation", 2001, section 1.1): once it is known at one place c of the side, it is known at every other place p from
// the lines that the way from c to p crosses. These lines are the outlines of what is above the plane, and where
// triangles go through the plane. They are found in double precision from the triangles whose boxes meet that of the
// side, when the side is first seen, and kept in single precision from c: they are off by some 1e-7 of the distance.
//
// Most sides have no such line: they are in the sun, or in the shadow, as a whole. The others keep theirs, a few dozen
// as a rule; a place then takes some tens of nanoseconds, where a ray takes some hundreds. What lies within the lift of
// shadow rays above the plane throws no shadow on it.

#include <memory>
#include <span>

#include "radiometry/render/visibility/sun_picture.h"
#include "radiometry/render/visible_sides.h"

namespace radiometry::render {

/// `unknown`: too many lines, too thin for them, or no place c that is clear of them; rays tell.
enum class InSun : std::uint8_t { partly, wholly, nowhere, unknown };

/// A place on a side that is partly in the sun.
struct SunQuestion {
  std::uint32_t number = 0;  ///< of the side, in VisibleSides
  SunPicture::Place place{};
};

class SidesInSun {
 public:
  /// `lift_m`: as scene::Beam has it. `facets` outlives it.
  SidesInSun(const scene::Facets& facets, const Vector& to_sun, double lift_m, int threads);
  /// Works out the sides that were added to `sides` since it was last called.
  void add(const VisibleSides& sides, int threads);
  /// Of a side by its number in VisibleSides. Sides that face away are nowhere in the sun.
  InSun of(std::size_t number) const { return known_[number].in_sun; }
  /// Whether the sun reaches these places, which are on sides that it partly reaches.
  void reaches(std::span<const SunQuestion> places, std::span<std::uint8_t> lit) const;
  const SunPicture& picture() const { return *picture_; }

  /// Lines in single precision from a place c of a side; what they enclose is on their left.
  struct Lines {
    InSun in_sun = InSun::unknown;
    SunPicture::Place c{};
    int covers = 0;  ///< triangles that are over c
    /// Blocks of kBlock lines: x of their beginnings, y of them, x and y of their ends. Empty lines fill the last.
    std::vector<float> ends{};
    static constexpr std::size_t kBlock = 16;
  };
  /// Of a side that faces the sun.
  Lines find(scene::Side side) const;

 private:
  struct Known {
    InSun in_sun = InSun::nowhere;
    std::int32_t covers = 0;
    SunPicture::Place c{};
    std::size_t first = 0, blocks = 0;  ///< in ends_
  };

  const scene::Facets* facets_;
  double lift_m_;
  std::shared_ptr<const SunPicture> picture_;  ///< copies share it
  std::vector<Known> known_{};                 ///< by number
  std::vector<float> ends_{};
};

/// Which parts of samples the sun reaches: fills `lit` of all parts and runs, and returns the number of shadow rays.
/// Sides that are in the sun as a whole, or in the shadow, take no work; runs on sides in part are divided. Where a
/// side is `unknown`, each part has a ray. With a null `in_sun` every part that faces the sun has. The sides of the
/// parts are among `sides`.
std::size_t find_shadows(const RenderScene& scene, const VisibleSides& sides, const SidesInSun* in_sun,
                         VisibleParts& parts, int threads);

}  // namespace radiometry::render
