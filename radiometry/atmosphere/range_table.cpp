// SPDX-License-Identifier: Apache-2.0
#include "radiometry/atmosphere/range_table.h"

#include <map>

#include "mtf/error.h"
#include "radiometry/atmosphere/spectral_impl.h"

namespace radiometry::atmosphere {

using mtf::format_double;
using mtf::UsageError;

void require_ranges(std::span<const double> ranges_m) {
  if (ranges_m.empty()) throw UsageError("atmosphere: no ranges; give one or more");
  for (std::size_t i = 0; i < ranges_m.size(); ++i)
    if (!(ranges_m[i] > (i > 0 ? ranges_m[i - 1] : 0.0)) || !std::isfinite(ranges_m[i]))
      throw UsageError("atmosphere: range " + std::to_string(i + 1) + " is " + format_double(ranges_m[i]) +
                       " m; ranges have to rise from above 0");
}

void refuse_beyond(double range_m, double end_m) {
  throw UsageError("atmosphere: a range of " + format_double(range_m) + " m on a line that ends after " +
                   format_double(end_m) + " m");
}

RangeTableResult path_table(const Air<double>& air, const Sight<double>& sight, std::span<const double> ranges_m,
                            const SpectralOptions& options) {
  SpectralOptions own = options;
  own.components = false;
  const auto paths = spectral_paths(air, sight, ranges_m, own);
  std::vector<double> um;
  std::vector<std::vector<double>> transmission, radiance;
  for (const SpectralPath<double>& one : paths) {
    WavelengthCurves curves = curves_of(one);
    um = std::move(curves.wavelength_um);
    transmission.push_back(std::move(curves.transmission));
    radiance.push_back(std::move(curves.radiance));
  }
  return {PathTable("built-in atmosphere", {ranges_m.begin(), ranges_m.end()}, std::move(um), std::move(transmission),
                    std::move(radiance)),
          paths.back().left_out};
}

namespace {

/// How far PathTable is off at `middle` between two of its ranges.
double interpolation_error(const SpectralPath<double>& a, const SpectralPath<double>& middle,
                           const SpectralPath<double>& b, double share, double air_k) {
  double worst = 0.0;
  for (std::size_t i = 0; i < middle.transmission.size(); ++i) {
    const double lo = a.transmission[i], hi = b.transmission[i];
    const double tau = lo > 0.0 && hi > 0.0 ? lo * std::pow(hi / lo, share) : lo + share * (hi - lo);
    worst = std::max(worst, std::abs(tau - middle.transmission[i]));
    if (i < middle.radiance.size()) {
      const double radiance = a.radiance[i] + share * (b.radiance[i] - a.radiance[i]);
      worst = std::max(worst,
                       std::abs(radiance - middle.radiance[i]) / planck_per_cm(middle.wavenumber_cm[i], air_k).value);
    }
  }
  return worst;
}

/// The worst place of an interval lies beside its middle, where the difference is a little larger.
constexpr double kMiddle = 1.2;

}  // namespace

TableRanges ranges_for(const Air<double>& air, const Sight<double>& sight, double nearest_m, double longest_m,
                       double tolerance, const Interval& band, std::size_t most) {
  if (nearest_m > 0.0 && nearest_m == longest_m) return {{nearest_m}, 0.0};
  if (!(nearest_m > 0.0 && nearest_m < longest_m))
    throw UsageError("atmosphere: ranges from " + format_double(nearest_m) + " to " + format_double(longest_m) +
                     " m; they have to rise from above 0");
  if (!(tolerance > 0.0))
    throw UsageError("atmosphere: a tolerance of " + format_double(tolerance) + " for a table; it has to be above 0");
  const SpectralOptions options{.band = band, .components = false, .tolerance = 0.0};
  const double air_k = std::visit(
      [&](const auto& one) {
        if constexpr (requires { one.sensor_altitude_m; })
          return level_at(air.profile, one.sensor_altitude_m).temperature_k;
        else
          return level_at(air.profile, one.altitude_m).temperature_k;
      },
      sight);
  std::map<double, SpectralPath<double>> known;
  const auto compute = [&](const std::vector<double>& ranges) {
    auto paths = spectral_paths(air, sight, std::span<const double>(ranges), options);
    for (std::size_t i = 0; i < ranges.size(); ++i) known.emplace(ranges[i], std::move(paths[i]));
  };
  compute({nearest_m, longest_m});
  // Every round halves (geometrically) all intervals that are off; the halves are part of the table from then on.
  std::vector<double> open{nearest_m};  // lower ends
  double error = 0.0, finished = 0.0;   // of the last round, and of the intervals that earlier rounds left as they are
  while (!open.empty()) {
    std::vector<double> middles;
    for (const double lo : open) {
      const double middle = std::sqrt(lo * known.upper_bound(lo)->first);
      middles.push_back(middle);
    }
    std::vector<std::pair<double, double>> ends;
    for (const double lo : open) ends.emplace_back(lo, known.upper_bound(lo)->first);
    compute(middles);
    std::vector<double> next;
    error = 0.0;
    for (std::size_t i = 0; i < open.size(); ++i) {
      const auto [lo, hi] = ends[i];
      const double off =
          interpolation_error(known.at(lo), known.at(middles[i]), known.at(hi), (middles[i] - lo) / (hi - lo), air_k);
      // Halves are four times better than their interval.
      if (off > 4.0 * tolerance)
        next.insert(next.end(), {lo, middles[i]});
      else
        finished = std::max(finished, 0.25 * off);
      error = std::max(error, 0.25 * off);
    }
    if (known.size() + next.size() > most) break;
    if (next.empty()) break;
    open = std::move(next);
  }
  TableRanges out{{}, kMiddle * std::max(error, finished)};
  for (const auto& [range, path] : known) out.ranges_m.push_back(range);
  return out;
}

template std::vector<SpectralPath<double>> spectral_paths(const Air<double>&, const Sight<double>&,
                                                          std::span<const double>, const SpectralOptions&);

}  // namespace radiometry::atmosphere
