// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a camera sees where no facet is: the sky above the horizon, with all the air before it, and below it the ground,
// a level plane that goes on as far as the horizon, through the air between. Radiance in the band by the sine of the
// elevation: cubics of the zenith angle, whose steps are the smaller the nearer they are to the horizon.

#include <optional>

#include "radiometry/render/band_tables.h"

namespace radiometry::render {

/// Elevations that the sky is known at, from the horizon to the zenith, and the weights of a cubic between them.
inline constexpr std::size_t kSkyElevations = 33;
double sky_elevation(std::size_t k);
CubicPlace elevation_place(double elevation_rad);

class Backdrop {
 public:
  /// `view`: null without air. `ground_m`: the height of the plane. `nearest_m`: the range that the table of the ground
  /// begins at, else the height of the camera above it.
  Backdrop(const RenderScene& scene, const BandNodes& nodes, const LightSources& sources, const AirView* view,
           double camera_height_m, double ground_m, std::optional<double> nearest_m = std::nullopt);

  /// What a camera between those of two backdrops sees, over the same ground and from one nearest range: means of the
  /// sky in the same direction and of the ground at the same range.
  static Backdrop between(const Backdrop& low, const Backdrop& high, double share);

  double radiance(double sine_of_elevation) const;
  /// To the plane; infinite above the horizon.
  double range_m(double sine_of_elevation) const;
  /// What the air adds on the way to the plane; 0 without air.
  double path_radiance(double sine_of_elevation) const;

 private:
  /// Of the ground, from one height: cubics of the logarithm of the range, from nearest_m_ to 300 km.
  struct Below {
    std::vector<double> radiance, path;  ///< `path`: what the air adds
  };
  double below(std::vector<double> Below::*what, double sine_of_depression) const;

  double camera_above_m_, nearest_m_;
  std::vector<double> above_;  ///< at the elevations of sky_elevation
  std::vector<Below> below_;   ///< one, or two that the camera is between
  double share_ = 0.0;         ///< of the second one
};

}  // namespace radiometry::render
