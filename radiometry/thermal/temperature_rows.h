// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of all facets of a scene at some times, as a heat balance, a measurement or another program has them.
//
// Between two times they are straight lines. What they are before the first time and after the last one is not known,
// and asking for it is refused: nothing would stand behind a temperature that is held. A table of one row without a
// time holds at all times; whoever wants that says it so.
//
//   made from            by
//   a heat balance       append, output by output of run_heat (run/heat_run.h)
//   given temperatures   given_rows, of the regions of a scene at one time (thermal_scene.h)
//   files                read_temperatures (apps/scene/heat/read_temperatures.h)

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace radiometry::thermal {

/// Whether a surface can have it.
constexpr bool is_temperature(double kelvin) {
  constexpr double kHottest_k = 3000.0;
  return kelvin > 0.0 && kelvin <= kHottest_k;
}

struct TemperatureRows {
  std::string source{};         ///< for messages
  std::size_t facets = 0;       ///< of the scene
  std::vector<double> utc_s{};  ///< of all rows, strictly rising; empty: one row, which holds at all times
  /// K, [(row - first) * facets + facet], NaN where it is not known. Without `back_k`, and where that is NaN, a back
  /// has the temperature of its front.
  std::vector<float> front_k{}, back_k{};
  std::size_t first = 0;  ///< row that the values begin with: of a long file only those about a time are in memory

  /// A row: the temperatures of an output of run_heat.
  void append(double at_utc_s, std::span<const double> fronts_k, std::span<const double> backs_k);

  bool change() const { return utc_s.size() > 1; }
  /// The first and the last time; nothing where they hold at all times.
  std::optional<std::array<double, 2>> span_utc_s() const;
  /// "which go from 2026-06-21T00:00:00Z to ..."
  std::string span_text() const;
  bool covers(double begin_utc_s, double end_utc_s) const;
  /// Throws UsageError, with the source, for a time that they do not cover.
  void require(double at_utc_s) const;

  /// The rows about a time, or those nearest to it, and the share of the second one.
  struct Place {
    std::size_t row, next;
    double share;
  };
  Place place_of(double at_utc_s) const;
  /// Whether the values of those rows are in memory.
  bool has(const Place& place) const;

  /// The front of a facet, K. Throws as `require`.
  double front_at(std::uint32_t facet, double at_utc_s) const;
  /// Fills `kelvin` of scene::index(side). Throws as `require`.
  void sides_at(double at_utc_s, std::vector<float>& kelvin) const;
};

/// Throws UsageError "where: ..." for what does not have all values of that many facets, at rising times.
void require_valid(const TemperatureRows& rows, std::size_t facets, const std::string& where);

}  // namespace radiometry::thermal
