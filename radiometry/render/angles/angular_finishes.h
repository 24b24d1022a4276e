// SPDX-License-Identifier: Apache-2.0
#pragma once

// What surfaces add to the tables of a band whose emissivity depends on the angle, or that are glossy. With eps that
// along the normal, g the factor at this angle, s the gloss, L the diffuse light of the side and L' what a mirror
// shows,
//   (1 - eps g) = g (1 - eps) + (1 - g)
//   radiance = g [eps B + (1 - s)(1 - eps) L + s (1 - eps) L'] + (1 - g) [(1 - s) L + s L'],
// sums of the tables of the finish and of a white one (eps = 0) at every wavelength: in an isothermal scene all is B,
// whatever g and s. The sun is part of L (a point, which no mirror ray meets). A mirror shows a side j as
//   L' = J of its patch + eps_h (B(T_j) - B(T_patch)) + (1 - eps_h) E_sun cos V / pi,   eps_h its mean by hemisphere,
// so that tables of the products (1 - eps) eps_h and (1 - eps)(1 - eps_h) are made for each glossy finish with each
// other, and for white; and sky and ground as they are seen from the ground, without the air between.

#include <span>

#include "radiometry/render/band_tables.h"
#include "radiometry/render/render_scene.h"

namespace radiometry::render {

struct AngularFinishes {
  std::vector<MadeFinish> made{};     ///< white; then, of glossy finishes and last of white, one for each finish
  std::vector<std::uint32_t> like{};  ///< of each: the finish whose temperatures it has; kNone for white
  std::vector<std::size_t> row{};     ///< of each finish: which of the glossy ones, made.size() for others
  std::size_t finishes = 0;

  bool any() const { return !made.empty(); }
  std::size_t white() const { return finishes; }
  /// The table of `seen` in a mirror of `finish`, or a white one.
  std::size_t mirrored(std::size_t finish, std::size_t seen) const {
    return finishes + 1 + row[finish] * finishes + seen;
  }
  std::size_t mirrored_in_white(std::size_t seen) const { return finishes + (made.size() - finishes) + seen; }
};

/// Emissivities of each finish at the nodes: along the normal, and means over the hemisphere. Nothing where no finish
/// depends on the angle or is glossy; white alone unless mirrors show sides (`with_sides`).
AngularFinishes angular_finishes(const RenderScene& scene, std::span<const std::vector<double>> emissivity,
                                 std::span<const std::vector<double>> hemispherical, bool with_sides);

/// What finishes give off to all sides, at the nodes.
std::vector<std::vector<double>> hemispherical_emissivity(const RenderScene& scene,
                                                          std::span<const std::vector<double>> emissivity);

}  // namespace radiometry::render
