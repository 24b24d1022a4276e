// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/sample_ranges.h"

#include <algorithm>
#include <cmath>

#include "mtf/components/defocus.h"
#include "mtf/error.h"
#include "mtf/field/field_modes.h"
#include "mtf/words.h"

namespace mtf {
namespace {

Defocus<double> defocus_by_range(const System<double>& system) {
  return *system.list(Stage::presample).at(*entry_by_range(system)).component.get_if<Defocus<double>>();
}

}  // namespace

std::optional<std::size_t> entry_by_range(const System<double>& system) {
  const auto& list = system.list(Stage::presample);
  for (std::size_t i = 0; i < list.size(); ++i)
    if (const auto* defocus = list[i].component.get_if<Defocus<double>>(); defocus != nullptr && defocus->focus_m)
      return i;
  return std::nullopt;
}

void refuse_range(const System<double>& system, std::string_view what) {
  if (const auto entry = entry_by_range(system))
    throw UsageError(std::string(what) + " takes one focus; presample[" + std::to_string(*entry) +
                     "].focus makes the defocus that of the range of each sample of a scene: give waves or distance in "
                     "its place");
}

SampleRanges sample_ranges(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
                           ImageView<const float> range_m) {
  if (range_m.width != in.width || range_m.height != in.height)
    throw UsageError("the ranges (channel Z) are " + size_text(range_m.width, range_m.height) + ", the scene is " +
                     size_text(in.width, in.height) + "; give each sample its own");
  const Frame<double>& frame = system.frame;
  const auto [width_um, height_um] = detector_um(frame, out);
  const double axis_x_um = 0.5 * width_um + system.field.axis_x_px * frame.pitch_x_um,
               axis_y_um = 0.5 * height_um + system.field.axis_y_px * frame.pitch_y_um;
  const double focal_um = 1e3 * frame.focal_length_mm, focal_m = 1e-6 * focal_um;
  SampleRanges ranges;
  ranges.per_m.reserve(static_cast<std::size_t>(in.width * in.height));
  std::int64_t bad = 0, first_x = 0, first_y = 0;
  double sum = 0.0;
  for (std::int64_t y = 0; y < in.height; ++y)
    for (std::int64_t x = 0; x < in.width; ++x) {
      const auto z = static_cast<double>(range_m.at(x, y));
      const double dx = (static_cast<double>(x) + 0.5) * in.step_x_um - axis_x_um,
                   dy = (static_cast<double>(y) + 0.5) * in.step_y_um - axis_y_um;
      const double per_m = std::sqrt(1.0 + (dx * dx + dy * dy) / (focal_um * focal_um)) / z;
      if (!(z > 0.0 && per_m * focal_m < 1.0)) {  // of what is nearer there is no image
        if (bad++ == 0) first_x = x, first_y = y;
        continue;
      }
      ranges.per_m.push_back(per_m);
      sum += per_m;
    }
  if (bad > 0)
    throw UsageError("the ranges (channel Z): " + plural(bad, "sample") +
                     " without a range beyond the focal length of " + significant(focal_m, 6) +
                     " m, the first at column " + std::to_string(first_x) + ", row " + std::to_string(first_y) +
                     "; give every sample its distance in metres along the ray, of sky infinity, and check "
                     "focal_length");
  const auto [least, most] = std::ranges::minmax(ranges.per_m);
  ranges.least = least, ranges.most = most;
  ranges.mean = std::clamp(sum / static_cast<double>(ranges.per_m.size()), least, most);
  return ranges;
}

double distance_at_um(const System<double>& system, double per_m) {
  return std::pow(system.frame.focal_length_mm, 2) * (per_m - 1.0 / *defocus_by_range(system).focus_m);  // mm^2/m = um
}

System<double> with_distance(System<double> system, double distance_um) {
  Defocus<double> defocus = defocus_by_range(system);
  defocus.focus_m.reset();
  defocus.distance_um = micrometres(distance_um);
  system.list(Stage::presample).at(*entry_by_range(system)).component = defocus;
  return system;
}

}  // namespace mtf
