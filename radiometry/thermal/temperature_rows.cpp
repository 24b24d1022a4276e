// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/temperature_rows.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"

namespace radiometry::thermal {
namespace {

double between(float a, float b, double share) {
  return (1.0 - share) * static_cast<double>(a) + share * static_cast<double>(b);
}

}  // namespace

void TemperatureRows::append(double at_utc_s, std::span<const double> fronts_k, std::span<const double> backs_k) {
  facets = fronts_k.size();
  utc_s.push_back(at_utc_s);
  for (const double kelvin : fronts_k) front_k.push_back(static_cast<float>(kelvin));
  for (const double kelvin : backs_k) back_k.push_back(static_cast<float>(kelvin));
}

std::optional<std::array<double, 2>> TemperatureRows::span_utc_s() const {
  if (utc_s.empty()) return std::nullopt;
  return std::array{utc_s.front(), utc_s.back()};
}

std::string TemperatureRows::span_text() const {
  return utc_s.empty()
             ? "which hold at all times"
             : "which go from " + heat::instant_text(utc_s.front()) + " to " + heat::instant_text(utc_s.back());
}

bool TemperatureRows::covers(double begin_utc_s, double end_utc_s) const {
  return utc_s.empty() || (begin_utc_s >= utc_s.front() && end_utc_s <= utc_s.back());
}

void TemperatureRows::require(double at_utc_s) const {
  if (!covers(at_utc_s, at_utc_s))
    throw mtf::UsageError(heat::instant_text(at_utc_s) + " is outside of the temperatures of " + mtf::one_line(source) +
                          ", " + span_text() + "; choose a time between them, or give temperatures until then");
}

TemperatureRows::Place TemperatureRows::place_of(double at_utc_s) const {
  if (utc_s.empty()) return {0, 0, 0.0};
  const auto above = std::upper_bound(utc_s.begin() + 1, utc_s.end(), at_utc_s);
  const auto row = static_cast<std::size_t>(above - utc_s.begin()) - 1;
  if (above == utc_s.end()) return {row, row, 0.0};
  return {row, row + 1, std::max((at_utc_s - utc_s[row]) / (utc_s[row + 1] - utc_s[row]), 0.0)};
}

bool TemperatureRows::has(const Place& place) const {
  return place.row >= first && (place.next - first + 1) * facets <= front_k.size();
}

double TemperatureRows::front_at(std::uint32_t facet, double at_utc_s) const {
  require(at_utc_s);
  const Place at = place_of(at_utc_s);
  return between(front_k[(at.row - first) * facets + facet], front_k[(at.next - first) * facets + facet], at.share);
}

void TemperatureRows::sides_at(double at_utc_s, std::vector<float>& kelvin) const {
  require(at_utc_s);
  const Place at = place_of(at_utc_s);
  const std::size_t row = (at.row - first) * facets, next = (at.next - first) * facets;
  kelvin.resize(2 * facets);
  for (std::size_t f = 0; f < facets; ++f)
    kelvin[2 * f] = kelvin[2 * f + 1] = static_cast<float>(between(front_k[row + f], front_k[next + f], at.share));
  for (std::size_t f = 0; !back_k.empty() && f < facets; ++f)
    if (const double back = between(back_k[row + f], back_k[next + f], at.share); back > 0.0)
      kelvin[2 * f + 1] = static_cast<float>(back);
}

void require_valid(const TemperatureRows& rows, std::size_t facets, const std::string& where) {
  const std::size_t count = std::max<std::size_t>(rows.utc_s.size(), 1), all = count * facets;
  const auto rises = [](double a, double b) { return !(a < b); };  // so that neither NaN nor a time that repeats passes
  if (rows.facets != facets || rows.first != 0 || rows.front_k.size() != all ||
      (!rows.back_k.empty() && rows.back_k.size() != all) ||
      std::ranges::adjacent_find(rows.utc_s, rises) != rows.utc_s.end() ||
      !std::ranges::all_of(rows.utc_s, [](double t) { return std::isfinite(t); }))
    throw mtf::UsageError(where + ": its table has " + std::to_string(rows.front_k.size()) + " temperatures, where " +
                          std::to_string(count) + " rising times of " + std::to_string(facets) + " facets are needed");
}

}  // namespace radiometry::thermal
