// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/pattern_planes.h"

#include <algorithm>
#include <cmath>

#include "apps/terminal/text_table.h"
#include "mtf/error.h"

namespace apps {
namespace {

using calib::Characterization, calib::Stack;

/// (a - b) scale without its shading; without b: a scale.
PatternPlane scaled_plane(std::string name, std::string unit, const Stack& a, const Stack* b, double scale, int trend) {
  PatternPlane p{.name = std::move(name),
                 .unit = std::move(unit),
                 .plane = b != nullptr ? calib::pattern_difference(a, *b) : a.sums.pattern.clone()};
  for (std::int64_t i = 0; i < p.plane.size(); ++i) p.plane.data()[i] *= static_cast<float>(scale);
  for (const Stack* const stack : {&a, b}) {
    if (stack == nullptr) continue;
    const radiometry::MeanSquares& squares = stack->sums.squares;
    p.temporal2 += scale * scale *
                   ((squares.value[radiometry::kTvh] - stack->sums.apart.value) / squares.frames +
                    calib::rounding_of(*stack) + stack->sums.lasting);
  }
  p.squares = calib::plane_squares(p.plane.view(), calib::remove_trend(p.plane.view(), trend).degree);
  return p;
}

calib::PatternRms rms_of(const Characterization& camera, std::array<const char*, 3> names, double unit) {
  const auto value = [&](const char* name) {
    const calib::Finding* const f = camera.find(name);
    return f != nullptr ? unit * f->value : 0.0;
  };
  return {value(names[0]), value(names[1]), value(names[2])};
}

}  // namespace

double PatternPlane::rms() const { return std::sqrt(std::max(0.0, squares.pixel - temporal2)); }

NoiseUnit noise_unit(const Characterization& camera) {
  return camera.reference_k > 0.0 ? NoiseUnit{"mK", 1e3 / camera.find("sitf")->value}
                                  : NoiseUnit{"e-", camera.find("electrons_per_count")->value};
}

FitEnds fit_ends(const Characterization& camera) {
  const auto& levels = camera.level_of;
  const auto is_used = [](int level) { return level >= 0; };
  return {
      camera.stacks[static_cast<std::size_t>(std::ranges::find_if(levels, is_used) - levels.begin())],
      camera
          .stacks[static_cast<std::size_t>(levels.rend() - std::find_if(levels.rbegin(), levels.rend(), is_used) - 1)]};
}

std::vector<PatternPlane> pattern_planes(const Characterization& camera) {
  std::vector<PatternPlane> planes;
  if (camera.dark < 0) return planes;
  const NoiseUnit unit = noise_unit(camera);
  const Stack& dark = camera.stacks[static_cast<std::size_t>(camera.dark)];
  const bool kelvin = camera.reference_k > 0.0;
  planes.push_back(scaled_plane(kelvin ? "fixed pattern" : "dark signal", unit.name, dark, nullptr, unit.per_count, 0));
  if (kelvin) {
    const auto [cold, hot] = fit_ends(camera);
    const auto& levels = camera.transfer.levels;
    planes.push_back(scaled_plane("response", "%", hot, &cold, 100.0 / (levels.back().mean - levels.front().mean), 0));
  } else if (camera.bright >= 0 && camera.bright_signal > 0.0)
    planes.push_back(scaled_plane("response", "%", camera.stacks[static_cast<std::size_t>(camera.bright)], &dark,
                                  100.0 / camera.bright_signal, camera.trend));
  return planes;
}

PatternMaps pattern_maps(const Characterization& camera, const std::vector<PatternPlane>& planes) {
  if (planes.size() < 2)
    throw mtf::UsageError(
        "--maps: the maps are of a dark stack that is not clipped, and of one with light; give a stack with light = "
        "false whose values stay above the lower end");
  PatternMaps maps;
  const PatternPlane &dark = planes[0], &bright = planes[1];
  maps.offset =
      calib::pattern_map(dark.plane.view(), dark.squares, rms_of(camera, {"dsnu", "fixed_row", "fixed_column"}, 1.0));
  mtf::Image plane = bright.plane.clone();
  const calib::CrosstalkEstimate& c = camera.crosstalk;
  if (c.found) calib::undo_crosstalk(plane, c.side.value, c.corner_found ? c.corner.value : 0.0);
  maps.responsivity = calib::pattern_map(plane.view(), calib::plane_squares(plane.view(), camera.trend),
                                         rms_of(camera, {"prnu", "prnu_row", "prnu_column"}, 100.0));
  for (std::int64_t i = 0; i < plane.size(); ++i)
    maps.responsivity.data()[i] = std::max(0.0F, 1.0F + 0.01F * maps.responsivity.data()[i]);
  return maps;
}

std::string defects_csv(const Characterization& camera, const std::vector<PatternPlane>& planes) {
  TextTable table({"plane", "x", "y", "excess", "unit"});
  for (const PatternPlane& p : planes)
    for (const calib::Defect& d : p.squares.defects)
      table.add({p.name, std::to_string(d.x), std::to_string(d.y), csv_number(d.excess), p.unit});
  if (camera.dark < 0) return table.csv();
  const calib::StackSummary& dark = camera.stacks[static_cast<std::size_t>(camera.dark)].sums;
  const NoiseUnit unit = noise_unit(camera);
  const auto columns = static_cast<std::int64_t>(dark.squares.columns);
  for (const std::int64_t place : calib::noisy_places(dark))
    table.add({"temporal noise", std::to_string(place % columns), std::to_string(place / columns),
               csv_number(unit.per_count * std::sqrt(calib::variance_at(dark, place))), unit.name});
  return table.csv();
}

}  // namespace apps
