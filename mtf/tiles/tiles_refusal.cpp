// SPDX-License-Identifier: Apache-2.0
#include "mtf/tiles/tiles_refusal.h"

#include <cmath>

#include "mtf/error.h"
#include "mtf/words.h"

namespace mtf {
namespace {

// Whether the scene goes through in tiles. Throws UnreachableTolerance where no plan keeps the tolerance.
bool goes_through(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                  const TileOptions& tiles) {
  std::string reason;
  for (const std::int64_t every : {std::int64_t{0}, coarse_every(scene, options.border, tiles.memory)})
    if (cut_into_tiles(system, scene, options, tiles, every, reason)) return true;
  return false;
}

// The least memory, within a quarter, with which the scene goes through: in tiles, else whole.
std::int64_t least_memory(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                          const TileOptions& tiles, double whole) {
  for (double memory = 1.25 * static_cast<double>(tiles.memory); memory < whole; memory *= 1.25) try {
      TileOptions larger = tiles;
      larger.memory = static_cast<std::int64_t>(memory);
      if (goes_through(system, scene, options, larger)) return larger.memory;
    } catch (const UnreachableTolerance&) {  // nor will more memory help
      break;
    }
  return static_cast<std::int64_t>(whole);
}

// The least tolerance from `least` on, within a half, with which it goes through in tiles; nothing below 1.
std::optional<double> least_tolerance(const System<double>& system, const SampleGrid& scene, PlanOptions options,
                                      const TileOptions& tiles, double least) {
  for (options.tolerance = least; options.tolerance < 1.0; options.tolerance *= 1.5) try {
      if (goes_through(system, scene, options, tiles)) return options.tolerance;
    } catch (const UnreachableTolerance&) {  // a larger one may be reached
    }
  return std::nullopt;
}

// The rounding of float32 samples, 2^-24 of the largest value, relative to the standard deviation of the scene; nothing
// where that is not known, or where filters after the sampling raise it by what only their plan tells.
std::optional<double> rounding_of(const System<double>& system, const PlanOptions& options) {
  if (!options.scene || !system.list(Stage::readout).empty() || !system.list(Stage::postsample).empty())
    return std::nullopt;
  return 0x1p-24 * options.scene->largest / options.scene->std;
}

}  // namespace

std::string mebibytes(double bytes) {
  return std::to_string(static_cast<std::int64_t>(std::ceil(bytes / 1048576.0))) + "MiB";
}

void refuse_memory(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                   const TileOptions& tiles, const std::string& reason, std::optional<double> share, double whole) {
  const auto text = [](double tolerance) {
    constexpr double kUp = 1.06;  // so that its two digits are not below it
    return "a tolerance of " + significant(kUp * tolerance, 2) + " or more";
  };
  const std::string limit = mebibytes(static_cast<double>(tiles.memory));
  constexpr double kLeast = 1.1, kEnough = 1.25;  // a plan rounds a little more than its samples
  const std::optional<double> rounding = rounding_of(system, options);
  std::optional<double> at_once, in_tiles;
  if (rounding && options.tolerance < kLeast * *rounding) at_once = kEnough * *rounding;
  if (rounding && share) in_tiles = least_tolerance(system, scene, options, tiles, kEnough * *rounding / *share);
  const double memory = at_once ? whole : static_cast<double>(least_memory(system, scene, options, tiles, whole));
  throw UsageError("the scene does not go through " + limit + " of memory in tiles at tolerance " +
                   format_double(options.tolerance) + ": " + reason + "; all of it at once needs " + mebibytes(whole) +
                   (at_once ? ", with " + text(*at_once) + " as its samples are float32" : "") + "; allow " +
                   mebibytes(memory) + " or more" + (at_once ? " and that tolerance" : "") +
                   (in_tiles ? ", or " + text(*in_tiles) : ", or a larger tolerance"));
}

}  // namespace mtf
