// SPDX-License-Identifier: Apache-2.0
#include "mtf/tiles/tiles_refusal.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "mtf/error.h"

namespace mtf {
namespace {

std::string mib(double bytes) {
  return std::to_string(static_cast<std::int64_t>(std::ceil(bytes / 1048576.0))) + "MiB";
}

// The least memory, within a quarter, with which the scene goes through: in tiles, else whole.
std::int64_t least_memory(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                          const TileOptions& tiles, double whole) {
  std::string reason;
  for (double memory = 1.25 * static_cast<double>(tiles.memory); memory < whole; memory *= 1.25) {
    TileOptions larger = tiles;
    larger.memory = static_cast<std::int64_t>(memory);
    for (const std::int64_t every : {std::int64_t{0}, coarse_every(scene, options.border, larger.memory)}) try {
        if (cut_into_tiles(system, scene, options, larger, every, reason)) return larger.memory;
      } catch (const UnreachableTolerance&) {  // nor will more memory help
        return static_cast<std::int64_t>(whole);
      }
  }
  return static_cast<std::int64_t>(whole);
}

// The least tolerance of 1, 2, 5, 10 ... with which the scene goes through this memory in tiles; nothing where none up
// to a tenth does.
std::optional<double> least_tolerance(const System<double>& system, const SampleGrid& scene, PlanOptions options,
                                      const TileOptions& tiles) {
  const double asked = options.tolerance;
  std::string reason;
  for (double decade = std::pow(10.0, std::floor(std::log10(asked))); decade < 0.1; decade *= 10.0)
    for (const double step : {2.0, 5.0, 10.0}) {
      options.tolerance = step * decade;
      for (const std::int64_t every : {std::int64_t{0}, coarse_every(scene, options.border, tiles.memory)}) try {
          if (options.tolerance > asked && cut_into_tiles(system, scene, options, tiles, every, reason))
            return options.tolerance;
        } catch (const UnreachableTolerance&) {  // a larger one may do
        }
    }
  return std::nullopt;
}

// The least tolerance of one plan for all of the scene where that is above the one asked for. It follows from the
// scene's summary, so a plan for a corner of it says it without the memory; transforms of the whole round a little
// more.
std::optional<double> least_tolerance_of_whole(const System<double>& system, const SampleGrid& scene,
                                               PlanOptions options) {
  constexpr std::int64_t kCorner = 1024;
  constexpr double kLonger = 1.2;
  SampleGrid corner = scene;
  corner.width = std::min(corner.width, kCorner);
  corner.height = std::min(corner.height, kCorner);
  options.spectrum = nullptr;
  try {
    static_cast<void>(compile_sensor(system, corner, options));
  } catch (const UnreachableTolerance& refusal) {
    return kLonger * refusal.reachable();
  } catch (const UsageError&) {  // a corner without a whole pixel says nothing
  }
  return std::nullopt;
}

}  // namespace

void refuse_memory(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                   const TileOptions& tiles, const std::string& reason, double whole) {
  const auto text = [](double tolerance) {
    std::array<char, 32> digits{};
    static_cast<void>(std::snprintf(digits.data(), digits.size(), "%.2g", tolerance));
    return "a tolerance of " + std::string(digits.data()) + " or more";
  };
  const std::string limit = mib(static_cast<double>(tiles.memory));
  const std::optional<double> in_tiles = least_tolerance(system, scene, options, tiles);
  const std::optional<double> at_once = least_tolerance_of_whole(system, scene, options);
  const double memory = at_once ? whole : static_cast<double>(least_memory(system, scene, options, tiles, whole));
  throw UsageError("the scene does not go through " + limit + " of memory in tiles at tolerance " +
                   format_double(options.tolerance) + ": " + reason + "; all of it at once needs " + mib(whole) +
                   (at_once ? ", with " + text(*at_once) + " as its samples are float32" : "") + "; allow " +
                   mib(memory) + " or more" + (at_once ? " and that tolerance" : "") +
                   (in_tiles ? ", or " + text(*in_tiles) : ""));
}

}  // namespace mtf
