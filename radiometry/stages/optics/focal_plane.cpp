// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/optics/focal_plane.h"

namespace radiometry {

FocalPlane focal_plane(std::int64_t columns, std::int64_t rows, double pitch_x_um, double pitch_y_um,
                       const OpticalAxis& axis) {
  require_valid("optical_axis", axis);
  const FocalPlane plane{.columns = columns,
                         .rows = rows,
                         .step_x_um = pitch_x_um,
                         .step_y_um = pitch_y_um,
                         .axis_x_um = axis.x_px * pitch_x_um,
                         .axis_y_um = axis.y_px * pitch_y_um};
  require_region(plane, {}, 0, 0);
  return plane;
}

FocalPlane on_grid(const FocalPlane& detector, Origin origin, std::int64_t columns, std::int64_t rows, double step_x_um,
                   double step_y_um) {
  // The axis from the shared corner, then from the middle of the new grid.
  const auto from_corner = [](std::int64_t pixels, double pitch_um, double axis_um, std::int64_t first) {
    return (0.5 * static_cast<double>(pixels) - static_cast<double>(first)) * pitch_um + axis_um;
  };
  const double x_um = from_corner(detector.columns, detector.step_x_um, detector.axis_x_um, origin.x);
  const double y_um = from_corner(detector.rows, detector.step_y_um, detector.axis_y_um, origin.y);
  return {.columns = columns,
          .rows = rows,
          .step_x_um = step_x_um,
          .step_y_um = step_y_um,
          .axis_x_um = x_um - 0.5 * static_cast<double>(columns) * step_x_um,
          .axis_y_um = y_um - 0.5 * static_cast<double>(rows) * step_y_um,
          .field_um = detector.half_diagonal_um()};
}

void require_region(const FocalPlane& plane, Origin origin, std::int64_t width, std::int64_t height) {
  const auto is_step = [](double step_um) { return step_um >= 1e-9 && step_um <= 1e12; };
  if (plane.columns < 1 || plane.rows < 1 || !is_step(plane.step_x_um) || !is_step(plane.step_y_um) ||
      !std::isfinite(plane.axis_x_um) || !std::isfinite(plane.axis_y_um))
    throw mtf::UsageError(
        "focal plane of " + size_of(plane.columns, plane.rows) + " samples, " + mtf::format_double(plane.step_x_um) +
        " x " + mtf::format_double(plane.step_y_um) +
        " um apart; it needs a sample at least, steps from 1e-9 to 1e12 um and an axis at a finite place");
  if (origin.x < 0 || origin.y < 0 || width > plane.columns || height > plane.rows ||
      origin.x > plane.columns - width || origin.y > plane.rows - height)
    throw mtf::UsageError("a region of " + size_of(width, height) + " samples from column " + std::to_string(origin.x) +
                          ", row " + std::to_string(origin.y) + " is outside a focal plane of " +
                          size_of(plane.columns, plane.rows));
}

}  // namespace radiometry
