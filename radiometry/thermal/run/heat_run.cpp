// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/run/heat_run.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "mtf/words.h"
#include "mtf/work/stopwatch.h"

namespace radiometry::thermal {
namespace {

constexpr double kFiner = 0.1;
constexpr double kKeptAbove_k = 300.0;
constexpr int kMoreSun = 4, kLeastDirections = 144;  // in 12 h of daylight: every 5 minutes

/// Largest errors of facets and the sum of squares, output by output.
class Comparison {
 public:
  Comparison(const KeptOutputs& kept, std::size_t facets) : kept_(kept), worst_(facets, -1.0F) {}

  void add(const HeatOutput& truth) {
    add_side(truth, truth.front_k, kept_.front);
    if (!truth.back_k.empty()) add_side(truth, truth.back_k, kept_.back);
    ++outputs_;
  }

  std::size_t outputs() const { return outputs_; }

  RealisedError result(double promised_k) {
    error_.rms_k = std::sqrt(squares_ / static_cast<double>(std::max<std::size_t>(count_, 1)));
    error_.promised_k = promised_k;
    std::erase_if(worst_, [](float error) { return error < 0.0F; });
    error_.count = worst_.size();
    std::sort(worst_.begin(), worst_.end());
    const auto at = [&](std::size_t per_mille) {
      return static_cast<double>(worst_[((worst_.size() - 1) * per_mille + 999) / 1000]);
    };
    error_.percentile_95_k = at(950);
    error_.percentile_999_k = at(999);
    return error_;
  }

 private:
  void add_side(const HeatOutput& truth, std::span<const double> kelvin, const std::vector<float>& kept) {
    const float* ours = kept.data() + outputs_ * worst_.size();
    for (std::size_t f = 0; f < worst_.size(); ++f) {
      if (std::isnan(kelvin[f]) || std::isnan(ours[f])) continue;  // no sheet; not asked for
      const double error = std::abs(static_cast<double>(ours[f]) + kKeptAbove_k - kelvin[f]);
      squares_ += error * error;
      ++count_;
      worst_[f] = std::max(worst_[f], static_cast<float>(error));
      if (error <= error_.largest_k) continue;
      error_.largest_k = error;
      error_.facet = static_cast<std::uint32_t>(f);
      error_.time_s = truth.time_s;
    }
  }

  const KeptOutputs& kept_;
  std::vector<float> worst_;  ///< of each facet; below 0 where there is nothing to compare
  std::size_t outputs_ = 0, count_ = 0;
  double squares_ = 0.0;
  RealisedError error_;
};

struct SunTable {
  const scene::SunVisibility* sun;
  const std::vector<scene::Vector>* to_sun;
};

/// Nothing when the run was ended before its last output.
std::optional<RealisedError> realised(const HeatScene& scene, const Units& units, const HeatOptions& options,
                                      const KeptOutputs& kept, const std::string& step, const HeatProgress& progress) {
  Comparison comparison(kept, scene.facets().size());
  const UnitsRun truth = solve_units(
      scene, units, options, [&](const HeatOutput& output) { comparison.add(output); },
      [&](const std::string&, double share) { progress(step, share); });
  if (comparison.outputs() < scene.surroundings.outputs.size()) return std::nullopt;
  return comparison.result(truth.promised.total_k());
}

/// Whether a side ever is in the sun, and nothing shades it then.
bool is_open(const SunTable& table, std::size_t row, const scene::Vector& normal) {
  bool faces = false;
  for (std::size_t d = 0; d < table.to_sun->size(); ++d) {
    if (scene::dot(normal, (*table.to_sun)[d]) <= 0.0) continue;
    faces = true;
    if (table.sun->lit[row * table.sun->directions + d] < table.sun->points) return false;
  }
  return faces;
}

/// Units whose sides that nothing shades need no table.
Units with_open_sides(const HeatScene& scene, const Units& units, const HeatScene& apart, const Units& traced) {
  Units open = units;
  const SunTable table{&units.sun, &scene.surroundings.shadow_to_sun},
      own{&traced.sun, &apart.surroundings.shadow_to_sun};
  const std::vector<scene::Side> sides = sides_of(scene).sides;
  for (std::size_t row = 0; row < sides.size(); ++row) {
    scene::Vector normal = scene.facets().facet[sides[row].facet].normal;
    if (sides[row].back)
      for (double& component : normal) component = -component;
    if (is_open(table, row, normal) && is_open(own, row, normal))
      std::fill_n(open.sun.lit.begin() + static_cast<std::ptrdiff_t>(row * units.sun.directions), units.sun.directions,
                  static_cast<std::uint8_t>(units.sun.points));
  }
  return open;
}

/// Wet surfaces that are colder or hotter than the formula of saturation, output by output: each region is said once.
class SurfaceLimits {
 public:
  explicit SurfaceLimits(const HeatScene& scene) : scene_(scene) {
    for (std::uint32_t f = 0; f < scene.facets().size(); ++f)
      if (const Region& region = scene.region_of(f);
          region.is_solved() && scene.material[scene.material_of(f)].construction.is_wet())
        wet_.push_back(f);
  }

  void see(const HeatOutput& output) {
    for (const std::uint32_t f : wet_)
      for (const auto& side : {output.front_k, output.back_k})
        if (!side.empty() && !std::isnan(side[f]))
          of_region_[scene_.input.region_of[f]].see(heat::kSaturationValidity, side[f], output.time_s, f);
  }

  std::vector<std::string> texts() const {
    std::vector<std::string> texts;
    for (const auto& [region, beyond] : of_region_)
      if (beyond.values > 0)
        texts.push_back(text_of(heat::kSaturationValidity, beyond, scene_.input.start_s,
                                "region '" + mtf::one_line(scene_.input.regions[region].name) + "', facet " +
                                    std::to_string(beyond.first_place) + ": "));
    return texts;
  }

 private:
  const HeatScene& scene_;
  std::vector<std::uint32_t> wet_;  ///< facets
  std::map<std::uint32_t, heat::Beyond> of_region_;
};

}  // namespace

void KeptOutputs::keep(const HeatOutput& output) {
  for (const double kelvin : output.front_k) front.push_back(static_cast<float>(kelvin - kKeptAbove_k));
  for (const double kelvin : output.back_k) back.push_back(static_cast<float>(kelvin - kKeptAbove_k));
}

std::optional<Verification> verify_heat(const HeatScene& scene, const Units& units, const HeatOptions& options,
                                        const KeptOutputs& kept, const HeatProgress& progress) {
  const mtf::Stopwatch watch;
  HeatOptions finer = options;
  finer.tolerance_k *= kFiner;
  finer.keep = {};
  finer.seen = false;  // what is left out of the run is solved here
  const auto again = [&](const HeatOptions& with) {
    ThermalScene input = scene.input;
    input.facets = scene.facets();
    return prepare_heat(std::move(input), with);
  };
  const HeatScene fine = again(finer);  // the same facets, more nodes
  HeatOptions own = finer;
  own.directions = std::max(kMoreSun * options.directions, kLeastDirections);
  own.sun_points = std::min(kMoreSun * options.sun_points, 255);
  own.sun_seed = options.sun_seed + 1;
  own.every_facet = true;
  const HeatScene apart = again(own);
  progress("verification: rays", 0.0);
  const Units single = units_of(apart, own, 0.0, &units);
  const auto as_units =
      realised(fine, with_open_sides(fine, units, apart, single), finer, kept, "verification: classes", progress);
  if (!as_units) return std::nullopt;
  const auto by_itself = realised(apart, single, own, kept, "verification: facets", progress);
  if (!by_itself) return std::nullopt;
  return Verification{*as_units, *by_itself, watch.ms()};
}

HeatReport run_heat(const HeatScene& scene, const HeatOptions& options, const HeatOutputs& output,
                    const HeatProgress& progress) {
  progress("rays", 0.0);
  const Units units =
      units_of(scene, options, options.every_facet ? 0.0 : units_tolerance_w_m2(scene, options.tolerance_k));
  KeptOutputs kept;
  SurfaceLimits limits(scene);
  HeatReport report{solve_units(
      scene, units, options,
      [&](const HeatOutput& at) {
        if (options.verify) kept.keep(at);
        limits.see(at);
        output(at);
      },
      progress)};
  report.warnings = scene.warnings;
  for (std::string& text : limits.texts()) report.warnings.push_back(std::move(text));
  report.timing_ms = scene.timing_ms;
  for (const auto& [name, ms] : {std::pair{"rays", units.rays_ms},
                                 {"classes", units.classes_ms},
                                 {"table errors", units.error_ms},
                                 {"heat", report.ms}})
    report.timing_ms.emplace_back(name, ms);
  report.facets = scene.facets().size();
  report.units = units.unit.size();
  report.patches = units.exchange.patches();
  report.covered = units.covered;
  report.view_error = units.view_error;
  report.sun_error = units.sun_error;
  // A run that is continued has not all outputs at hand.
  if (options.verify && options.from == nullptr && report.outputs == scene.surroundings.outputs.size())
    report.verified = verify_heat(scene, units, options, kept, progress);
  if (report.verified) report.timing_ms.emplace_back("verification", report.verified->ms);
  return report;
}

}  // namespace radiometry::thermal
