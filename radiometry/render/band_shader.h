// SPDX-License-Identifier: Apache-2.0
#pragma once

// One band of a frame: the radiance of every visible side at the six nodes of the cell of the path grid that the side's
// centre lies in, worked out once for a frame or for as long as nothing changes; a pixel is then six weights times six
// values, and the sun where it shines. Where a facet reaches into another cell, the values of that cell are worked out
// for it too and kept for the rays that follow.

#include <memory>
#include <optional>
#include <string>

#include "mtf/image.h"
#include "radiometry/render/backdrop.h"
#include "radiometry/render/band_surfaces.h"
#include "radiometry/render/mirror_rays.h"
#include "radiometry/render/visible_sides.h"

namespace radiometry::render {

inline constexpr double kBetweenHeights = 1e-4;

struct RenderBand {
  std::string name{};
  SpectralCamera curves{};
  double noise_k = 0.05;  ///< NETD of the camera at 300 K: what reflected light may err by follows from it
};

class BandShader {
 public:
  /// `views`: of patches; without rows where nothing reflects. All arguments but the band outlive it. Throws
  /// mtf::UsageError as band_nodes and AirView do.
  BandShader(RenderBand band, const RenderScene& scene, const Patches& patches, const scene::Views& views,
             double tolerance, bool with_air);

  /// Temperatures of the scene are others: nothing that depends on them is kept.
  void temperatures_changed();
  /// Sees to it that tables hold for a camera at that height and what it sees; returns whether they are others than
  /// before. They may also hold for what earlier frames saw. The tables of the first height are its own. A camera that
  /// leaves it gets those of two heights about it, as far apart as keeps the promise below kBetweenHeights, at least 12
  /// m, and straight lines between them.
  bool prepare(double camera_height_m, const PathExtent& extent, int threads = 0);
  /// The values of the sides that are shown, for this camera; only of those whose cell or tables changed. Returns how
  /// many.
  std::size_t shade(const VisibleSides& sides, const Point& camera, int threads);
  /// The radiance of each sample. Unless shadows were found (`lit` of parts and runs) sides are lit by the share of
  /// them that is in the sun. `mirrors`: of the parts whose radiance depends on the angle (mirror_rays.h), where there
  /// are any; all sides that they show are among `sides`.
  void radiance(const VisibleParts& parts, const VisibleSides& sides, const MirrorRays& mirrors, bool shadows,
                mtf::Image& out, int threads) const;

  /// The rms error of the light that sides reflect, by rays, in K of a blackbody of 300 K, from a second set of them
  /// (scene/table_error.h, with the variance of independent rays).
  double reflected_error_k(const VisibleSides& sides, const VisibleSides::OtherViews& other, const Point& camera) const;

  const RenderBand& band() const { return band_; }
  const BandNodes& nodes() const { return surfaces_.nodes; }
  const Backdrop& backdrop() const { return *backdrop_; }
  double promised() const { return promised_; }
  const PathGrid& grid() const { return grid_; }
  /// What the sun adds at most, of a blackbody at the temperature of the air: whether its shadows are worth rays.
  double sunlight() const { return sunlight_; }
  /// The mean of a finish's emissivity over the band, weighted by response and blackbody.
  double emissivity(std::size_t finish, double temperature_k) const;
  /// What a surface of that finish gives off itself and the air before it, from the tables: without reflected light.
  double own_radiance(std::size_t finish, double temperature_k, double range_m, double height_m) const;
  /// The air that tables were made for; null without air.
  const AirView* air_view() const { return view_.get(); }
  /// Radiance that the air adds on the way.
  double path_radiance(double range_m, double height_m) const;

 private:
  struct Shaded {
    std::array<float, 6> value{};
    PathGrid::Cell cell{};
    std::uint32_t finish = scene::kNone;  ///< kNone: not yet shaded
  };
  Shaded shaded(const VisibleSides& sides, std::size_t number, PathGrid::Cell cell) const;
  class Pixels;
  InMirror in_mirror(const MirrorRays& mirrors, std::size_t k, const VisibleSides& sides) const;
  void add_angles(const MirrorRays& mirrors, const VisibleParts& parts, const VisibleSides& sides, bool shadows,
                  mtf::Image& out, int threads) const;

  RenderBand band_;
  const RenderScene& scene_;
  double tolerance_;
  bool with_air_;
  const Patches* patches_;
  BandSurfaces surfaces_;
  /// What one height sees.
  struct FromHeight {
    double height_m;
    BandTables tables;
    Backdrop backdrop;
  };
  FromHeight from_height(double height_m, const AirView* view, const PathGrid& grid,
                         std::optional<double> nearest_m) const;
  bool take_between(double height_m);
  void make_ends(double height_m, const PathExtent& extent, int threads);
  void use(FromHeight from);

  std::unique_ptr<AirView> view_;
  PathGrid grid_;
  std::optional<FromHeight> low_, high_;  ///< ends that cameras are between; empty: tables are those of one height
  std::unique_ptr<BandTables> tables_;
  std::unique_ptr<Backdrop> backdrop_;
  double camera_height_m_ = 0.0, promised_ = 0.0, sunlight_ = 0.0;
  std::vector<Shaded> shaded_;  ///< of each visible side
};

}  // namespace radiometry::render
