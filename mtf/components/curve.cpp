// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "mtf/component.h"
#include "mtf/error.h"

namespace mtf {
namespace {

// Fritsch-Carlson slopes by the Brodlie mean (SIAM J. Numer. Anal. 17, 238 (1980)): no overshoot between samples.
std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> secant(n - 1), slope(n);
  for (std::size_t i = 0; i + 1 < n; ++i) secant[i] = (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
  slope.front() = secant.front();
  slope.back() = secant.back();
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (secant[i - 1] * secant[i] <= 0.0) continue;
    const double left = x[i] - x[i - 1], right = x[i + 1] - x[i];
    const double w = (left + 2.0 * right) / (3.0 * (left + right));
    slope[i] = 1.0 / (w / secant[i - 1] + (1.0 - w) / secant[i]);
  }
  return slope;
}

// Towards zero along the last slope, at least as steep as the mean fall from 0: a flat end must not go on for ever.
double last_fall(const Curve& curve) { return std::max(std::abs(curve.slope.back()), 1.0 / curve.frequency.back()); }

}  // namespace

Curve make_curve(std::string source, const Unit& unit, std::vector<double> frequency, std::vector<double> value) {
  const auto fail = [&](const std::string& why) { return UsageError(source + ": " + why); };
  if (frequency.size() != value.size()) throw fail("frequency and value differ in length");
  if (unit.dimension != Dimension::frequency) throw fail("the unit of a curve is cy/mm, cy/mrad or cy/px");
  for (std::size_t i = 0; i < frequency.size(); ++i) {
    const std::string where = "sample " + std::to_string(i + 1);
    if (!std::isfinite(frequency[i]) || !std::isfinite(value[i])) throw fail(where + " is not finite");
    if (frequency[i] < 0.0) throw fail(where + ": negative frequency");
    if (i > 0 && frequency[i] <= frequency[i - 1]) throw fail(where + ": frequencies have to increase");
    if (std::abs(value[i]) > 1.05) throw fail(where + ": |MTF| above 1.05; is it in percent?");
  }
  if (!frequency.empty() && frequency.front() > 0.0) {
    frequency.insert(frequency.begin(), 0.0);
    value.insert(value.begin(), 1.0);
  }
  if (frequency.size() < 2) throw fail("a curve needs at least two samples");
  if (std::abs(value.front() - 1.0) > 1e-3)
    throw fail("MTF at frequency 0 is " + format_double(value.front()) + "; it has to be 1, divide the column by it");
  value.front() = 1.0;
  Curve curve{std::move(source), &unit, std::move(frequency), std::move(value), {}};
  curve.slope = monotone_slopes(curve.frequency, curve.value);
  for (std::size_t i = 0; i < curve.slope.size(); ++i)
    if (!std::isfinite(curve.slope[i]) || curve.frequency[i] > 1e12)
      throw UsageError(curve.source + ": the frequencies near " + format_double(curve.frequency[i]) +
                       " are too close together or too large");
  return curve;
}

ValueSlope evaluate(const Curve& curve, double f) {
  const double x = std::abs(f), sign = f < 0.0 ? -1.0 : f > 0.0 ? 1.0 : 0.0;
  const auto& fs = curve.frequency;
  if (x >= fs.back()) {
    const double last = curve.value.back(), steepness = last_fall(curve);
    const double left = std::abs(last) - steepness * (x - fs.back());
    if (!(left > 0.0)) return {0.0, 0.0};
    return {std::copysign(left, last), -std::copysign(steepness, last) * sign};
  }
  const std::size_t i = static_cast<std::size_t>(std::upper_bound(fs.begin(), fs.end(), x) - fs.begin()) - 1;
  const double h = fs[i + 1] - fs[i], t = (x - fs[i]) / h, u = 1.0 - t;
  const double y0 = curve.value[i], y1 = curve.value[i + 1], m0 = h * curve.slope[i], m1 = h * curve.slope[i + 1];
  const double value = u * u * (1.0 + 2.0 * t) * y0 + t * t * (3.0 - 2.0 * t) * y1 + t * u * (u * m0 - t * m1);
  const double slope = (6.0 * t * u * (y1 - y0) + u * (u - 2.0 * t) * m0 + t * (t - 2.0 * u) * m1) / h;
  return {value, slope * sign};
}

double end_of(const Curve& curve) {
  std::size_t last = curve.value.size() - 1;
  if (curve.value[last] != 0.0) return curve.frequency[last] + std::abs(curve.value[last]) / last_fall(curve);
  while (curve.value[last - 1] == 0.0) --last;
  return curve.frequency[last];
}

}  // namespace mtf
