// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where on the focal plane a sample lies, for effects that depend on the place in the field of view. The grid is the
// whole detector, or the whole scene on its finer grid; the images that are worked on may be regions of it. r is the
// distance from the optical axis in half diagonals of the grid: 1 in the corners when the axis is in the middle.

#include <cmath>
#include <cstdint>

#include "radiometry/fields.h"
#include "radiometry/stages/noise/noise.h"

namespace radiometry {

/// Where the optical axis meets the detector, from its middle, +x right, +y down.
struct OpticalAxis {
  double x_px = 0.0, y_px = 0.0;

  static constexpr auto fields() {
    return std::tuple{optional(&OpticalAxis::x_px, "x", "px", -1e6, 1e6, "\"12 px\"",
                               "place of the optical axis, to the right of the detector's middle"),
                      optional(&OpticalAxis::y_px, "y", "px", -1e6, 1e6, "\"12 px\"",
                               "place of the optical axis, below the detector's middle")};
  }
};

/// A whole grid of samples on the focal plane.
struct FocalPlane {
  std::int64_t columns = 0, rows = 0;
  double step_x_um = 0.0, step_y_um = 0.0;
  double axis_x_um = 0.0, axis_y_um = 0.0;  ///< of the optical axis, from the middle of the grid
  double field_um = 0.0;  ///< r = 1, where it is not the grid's own corner: half the diagonal of the detector

  double half_diagonal_um() const {
    if (field_um > 0.0) return field_um;
    return 0.5 * std::hypot(static_cast<double>(columns) * step_x_um, static_cast<double>(rows) * step_y_um);
  }
  /// Distances of the centres of a column and of a row from the axis.
  double x_um(std::int64_t column) const {
    return (static_cast<double>(column) + 0.5 - 0.5 * static_cast<double>(columns)) * step_x_um - axis_x_um;
  }
  double y_um(std::int64_t row) const {
    return (static_cast<double>(row) + 0.5 - 0.5 * static_cast<double>(rows)) * step_y_um - axis_y_um;
  }

  bool operator==(const FocalPlane&) const = default;
};

/// The grid of a detector.
FocalPlane focal_plane(std::int64_t columns, std::int64_t rows, double pitch_x_um, double pitch_y_um,
                       const OpticalAxis& axis = {});

/// The same field on another grid of samples whose corner is that of the detector's pixel `origin`.
FocalPlane on_grid(const FocalPlane& detector, Origin origin, std::int64_t columns, std::int64_t rows, double step_x_um,
                   double step_y_um);

/// Throws UsageError for a grid without samples, steps that are not from 1e-9 to 1e12 um, a region outside of it.
void require_region(const FocalPlane& plane, Origin origin, std::int64_t width, std::int64_t height);

}  // namespace radiometry
