// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/step_profile.h"

#include <algorithm>
#include <cmath>

#include "mtf/math/clones.h"

namespace calib {
namespace {

// 1 / width of the bins of a side.
constexpr std::array<double, kSideBins> widths_inverse() {
  std::array<double, kSideBins> inverse{};
  std::size_t i = 0;
  double from = 0.0;
  for (const DistanceZone& zone : kDistanceZones)
    for (; from < zone.end_px; from += zone.step_px) inverse[i++] = 1.0 / zone.step_px;
  return inverse;
}

// The cubics through values and slopes at both ends of the bins, about the middle.
MTFKIT_CLONES void fit_cubics(const ReferenceTable& table, BinRow* cubic) {
  static constexpr std::array<double, kSideBins> kPerWidth = widths_inverse();
  for (std::size_t i = 0; i < kSideBins; ++i) {
    const double per_h = kPerWidth[i], h = 1.0 / per_h;
    const double mean = 0.5 * (table.odd[i] + table.odd[i + 1]), rise = (table.odd[i + 1] - table.odd[i]) * per_h;
    const double bend = (table.lsf[i + 1] - table.lsf[i]) * per_h, slope = 0.5 * (table.lsf[i] + table.lsf[i + 1]);
    const double c0 = mean - h * h * bend / 8.0, c1 = 1.5 * rise - 0.5 * slope;
    const double c2 = 0.5 * bend, c3 = 2.0 * per_h * per_h * (slope - rise);
    const std::size_t bright = kSideBins + i, dark = kSideBins - 1 - i;
    cubic[0][bright] = 0.5 + c0;
    cubic[0][dark] = 0.5 - c0;
    cubic[1][bright] = cubic[1][dark] = c1;
    cubic[2][bright] = c2;
    cubic[2][dark] = -c2;
    cubic[3][bright] = cubic[3][dark] = c3;
  }
}

// The weight of the second difference in the value halfway between knots: that of the cubic through four where
// they are evenly spaced, of the straight line elsewhere.
constexpr std::array<double, kSideBins> bulges() {
  std::array<double, kSideBins> bulge{};
  std::size_t i = 0;
  double from = 0.0;
  for (const DistanceZone& zone : kDistanceZones) {
    const auto count = static_cast<std::size_t>((zone.end_px - from) / zone.step_px);
    for (std::size_t k = 0; k < count; ++k) bulge[i + k] = (k > 0 || i == 0) && k + 1 < count ? 0.0625 : 0.0;
    i += count;
    from = zone.end_px;
  }
  return bulge;
}

// An odd function halfway between knots, on both sides.
MTFKIT_CLONES void halfway(const std::array<double, kSideBins + 1>& values, BinRow& out) {
  static constexpr std::array<double, kSideBins> kBulge = bulges();
  const auto put = [&](std::size_t i, double before, double after) {
    const double sum = values[i] + values[i + 1], value = 0.5 * sum + kBulge[i] * (sum - before - after);
    out[kSideBins + i] = value;
    out[kSideBins - 1 - i] = -value;
  };
  put(0, -values[1], values[2]);
  for (std::size_t i = 1; i + 1 < kSideBins; ++i) put(i, values[i - 1], values[i + 2]);
  put(kSideBins - 1, values[kSideBins - 2], values[kSideBins]);
}

}  // namespace

StepProfile::StepProfile(const ReferenceTable& table) : rows_(kReference + 2) {
  fit_cubics(table, rows_.data());
  for (std::size_t k = 0; k < kShapes; ++k) halfway(table.slope[k], rows_[kCubic + k]);
  rows_[kReference] = esf();
  rows_[kReference + 1] = lsf();
  find_bend_bins();
}

void StepProfile::correct(const BinRow& esf, const BinRow& lsf, const BinRow& c2) {
  for (std::size_t i = 0; i < kBins; ++i) {
    rows_[0][i] += esf[i];
    rows_[1][i] += lsf[i];
    rows_[2][i] += c2[i];
  }
  find_bend_bins();
}

void StepProfile::add_per_s(const BinRow& per_s, double s_px) {
  const DistanceBins& bins = DistanceBins::get();
  for (std::size_t i = 0; i < kBins; ++i) {
    const std::size_t before = i - (i > 0), after = i + (i + 1 < kBins);
    const double apart = bins.centre(static_cast<int>(after)) - bins.centre(static_cast<int>(before));
    rows_[0][i] += s_px * per_s[i];
    rows_[1][i] += s_px * (per_s[after] - per_s[before]) / apart;
    rows_[kCubic][i] += per_s[i];
  }
  rows_[kReference] = esf();
  rows_[kReference + 1] = lsf();
}

void StepProfile::set_reference(const StepProfile& other) {
  std::copy(other.rows_.begin() + kCubic, other.rows_.end(), rows_.begin() + kCubic);
}

void StepProfile::find_bend_bins() {
  const double least = 1e-3 * std::abs(lsf()[kSideBins]);
  const auto seen = [least](double value) { return std::abs(value) > least; };
  const auto first = std::find_if(lsf().begin(), lsf().end(), seen);
  const auto last = std::find_if(lsf().rbegin(), lsf().rend(), seen);
  bend_first = static_cast<int>(first - lsf().begin()) / kLot * kLot;
  bend_end = std::max(bend_first, (static_cast<int>(lsf().rend() - last) + kLot - 1) / kLot * kLot);
}

}  // namespace calib
