// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/spectrum.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "mtf/error.h"
#include "mtf/units.h"

namespace radiometry {
namespace {

using mtf::format_double;
using mtf::UsageError;

constexpr double kShortest_um = 1e-6, kLongest_um = 1e12;

void require_rising(const std::string& source, std::span<const double> wavelength_um) {
  for (std::size_t i = 0; i < wavelength_um.size(); ++i) {
    const std::string where = source + ": sample " + std::to_string(i + 1) + ": ";
    if (!(wavelength_um[i] >= kShortest_um && wavelength_um[i] <= kLongest_um))
      throw UsageError(where + "wavelength " + format_double(wavelength_um[i]) + " um; it has to be above 0, from " +
                       format_double(kShortest_um) + " um to " + format_double(kLongest_um) + " um");
    if (i > 0 && wavelength_um[i] <= wavelength_um[i - 1])
      throw UsageError(where + "wavelength " + format_double(wavelength_um[i]) + " um after " +
                       format_double(wavelength_um[i - 1]) + " um; sort the samples so that wavelengths increase");
  }
}

}  // namespace

std::string describe(const Interval& interval) {
  if (interval.lo_um == 0.0 && std::isinf(interval.hi_um)) return "all wavelengths";
  return format_double(interval.lo_um) + " um to " + format_double(interval.hi_um) + " um";
}

Spectrum make_spectrum(std::string source, std::vector<double> wavelength_um, std::vector<double> value, double most) {
  if (wavelength_um.size() != value.size())
    throw UsageError(source + ": " + std::to_string(wavelength_um.size()) + " wavelengths and " +
                     std::to_string(value.size()) + " values; give a value for each");
  if (wavelength_um.empty()) throw UsageError(source + ": no samples; a curve needs at least one");
  require_rising(source, wavelength_um);
  for (std::size_t i = 0; i < value.size(); ++i) {
    const std::string where = source + ": sample " + std::to_string(i + 1) + ": value " + format_double(value[i]);
    if (!std::isfinite(value[i])) throw UsageError(where + " is not finite");
    if (value[i] < 0.0) throw UsageError(where + " is negative");
    if (value[i] > most) throw UsageError(where + " is above " + format_double(most) + "; is it in percent?");
  }
  return {std::move(source), std::move(wavelength_um), std::move(value)};
}

Spectrum constant_spectrum(std::string source, double value, double most) {
  return make_spectrum(std::move(source), {1.0}, {value}, most);
}

Interval range_of(const Spectrum& spectrum) {
  if (spectrum.value.size() == 1) return {};
  return {spectrum.wavelength_um.front(), spectrum.wavelength_um.back()};
}

double evaluate(const Spectrum& spectrum, double wavelength_um) {
  const std::vector<double>&w = spectrum.wavelength_um, &v = spectrum.value;
  if (v.size() == 1) return v[0];
  if (!(wavelength_um >= w.front() && wavelength_um <= w.back())) return 0.0;
  const std::size_t i =
      std::min(static_cast<std::size_t>(std::ranges::upper_bound(w, wavelength_um) - w.begin()), w.size() - 1);
  const double t = (wavelength_um - w[i - 1]) / (w[i] - w[i - 1]);
  return v[i - 1] * (1.0 - t) + v[i] * t;
}

Interval common_range(const Interval& band, std::span<const Spectrum> factors) {
  if (!(band.lo_um >= kShortest_um) || !(band.hi_um > band.lo_um) || !(band.hi_um <= kLongest_um))
    throw UsageError("band " + describe(band) + ": it has to go from above 0 to a longer wavelength");
  Interval common = band;
  for (const Spectrum& factor : factors) {
    if (factor.value.empty() || factor.value.size() != factor.wavelength_um.size())
      throw UsageError(factor.source + ": not a curve: " + std::to_string(factor.wavelength_um.size()) +
                       " wavelengths and " + std::to_string(factor.value.size()) + " values; use make_spectrum");
    const Interval own = range_of(factor);
    const Interval next{std::max(common.lo_um, own.lo_um), std::min(common.hi_um, own.hi_um)};
    if (!(next.hi_um > next.lo_um))
      throw UsageError(factor.source + ": covers " + describe(own) + ", the band and the curves before it " +
                       describe(common) + "; they have no wavelengths in common");
    common = next;
  }
  return common;
}

std::vector<double> union_grid(const Interval& interval, std::span<const Spectrum> factors) {
  std::vector<double> grid{interval.lo_um, interval.hi_um};
  for (const Spectrum& factor : factors) {
    if (factor.value.size() == 1) continue;
    for (const double w : factor.wavelength_um)
      if (w > interval.lo_um && w < interval.hi_um) grid.push_back(w);
  }
  std::ranges::sort(grid);
  grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
  return grid;
}

Spectrum product(std::string source, std::span<const Spectrum> factors) {
  const auto value_at = [&](double w) {
    double value = 1.0;
    for (const Spectrum& factor : factors) value *= evaluate(factor, w);
    return value;
  };
  const bool constant = std::ranges::all_of(factors, [](const Spectrum& factor) { return factor.value.size() == 1; });
  if (constant) return constant_spectrum(std::move(source), value_at(1.0));
  std::vector<double> grid = union_grid(common_range({kShortest_um, kLongest_um}, factors), factors), value;
  for (const double w : grid) value.push_back(value_at(w));
  return make_spectrum(std::move(source), std::move(grid), std::move(value));
}

}  // namespace radiometry
