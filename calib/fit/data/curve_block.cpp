// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/data/curve_block.h"

#include <algorithm>
#include <numbers>

#include "mtf/error.h"

namespace calib {
namespace {

void check(const CurveData& data) {
  const auto fail = [&](const std::string& why) { throw mtf::UsageError(data.name + ": " + why); };
  const std::size_t n = data.frequency.size();
  if (n == 0) fail("the curve has no samples");
  if (data.unit == nullptr || data.unit->dimension != mtf::Dimension::frequency)
    fail("the frequencies of a curve are in cy/mm, cy/mrad or cy/px");
  if (data.mtf.size() != n) fail("frequency and MTF differ in length");
  if (data.sd.size() != 1 && data.sd.size() != n) fail("give one sd, or one a sample");
  for (std::size_t i = 0; i < n; ++i) {
    const std::string where = "sample " + std::to_string(i + 1);
    if (!std::isfinite(data.frequency[i]) || !std::isfinite(data.mtf[i])) fail(where + " is not finite");
    if (data.frequency[i] < 0.0) fail(where + ": negative frequency");
  }
  for (const double sd : data.sd)
    if (!(sd > 0.0 && std::isfinite(sd))) fail("the standard deviation of an MTF is above 0");
  if (!std::isfinite(data.angle_deg)) fail("the direction is not finite");
}

}  // namespace

CurveBlock::CurveBlock(const CurveData& data) : data_(&data) {
  check(data);
  signed_ = std::any_of(data.mtf.begin(), data.mtf.end(), [](double m) { return m < 0.0; });
  const double angle = data.angle_deg * std::numbers::pi / 180.0;
  for (const double f : data.frequency) f_.push_back({f * std::cos(angle), f * std::sin(angle), 0.0, 0.0});
}

NormalMatrix CurveBlock::normal(const Sensors& sensors, std::span<const double>) const {
  const OtfTable h = sensors.otf(place(), f_, data_->unit);
  const std::size_t n = sensors.parameters();
  NormalMatrix all(n);
  for (std::size_t i = 0; i < f_.size(); ++i) {
    const auto [re, im] = h[0][i];
    const double size = std::hypot(re, im);
    const BentResidual r = bent((data_->mtf[i] - (signed_ ? re : size)) / sd(i), robust_);
    const std::span<double> row = all.next();
    for (std::size_t k = 0; k < n; ++k) {
      const auto [d_re, d_im] = h[1 + k][i];
      const double slope = signed_ ? d_re : size > 0.0 ? (re * d_re + im * d_im) / size : 0.0;
      row[k] = -r.slope * slope / sd(i);
    }
    row[n] = r.value;
    all.add();
  }
  return all;
}

std::vector<Residual> CurveBlock::residuals(const Sensors& sensors, std::span<const double>) const {
  const OtfTable h = sensors.otf(place(), f_, data_->unit);
  std::vector<Residual> all;
  for (std::size_t i = 0; i < f_.size(); ++i) {
    const double model = signed_ ? h[0][i].re : std::hypot(h[0][i].re, h[0][i].im);
    all.push_back({.x = static_cast<std::int64_t>(i), .value = (data_->mtf[i] - model) / sd(i), .sd = sd(i)});
  }
  return all;
}

}  // namespace calib
