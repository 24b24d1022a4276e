// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/split_mean.h"

#include <limits>
#include <numeric>

#include "mtf/math/quadrature.h"
#include "mtf/otf/otf_series.h"

namespace mtf {
namespace {

constexpr std::size_t kPoints = kMostBandDegree + 1;

/// What turns values at the points of one degree into weights, made once: [value][coefficient].
using Transform = std::vector<double>;

const Transform& transform(int degree) {
  static const auto made = [] {
    std::array<Transform, 6> all;  // of 2^i
    for (std::size_t i = 1; i < all.size(); ++i) all[i] = chebyshev_transform(1 << i);
    return all;
  }();
  std::size_t i = 0;
  while (1 << i < degree) ++i;
  return made[i];
}

/// Weights for the integral over a piece of unit width at an even rate, made once.
const std::vector<double>& even_weights(int degree) {
  static const auto made = [] {
    std::array<double, kPoints> moment{};  // of T_k
    const GaussRule& rule = gauss_legendre(48);
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double t = rule.node[i], weight = rule.weight[i] * PanelMap{0.0, 1.0}.slope(t);
      double last = t, now = 1.0;
      for (double& m : moment) {
        m += weight * now;
        const double next = 2.0 * t * now - last;
        last = now;
        now = next;
      }
    }
    std::array<std::vector<double>, 6> all;  // of degree 2^i
    for (std::size_t i = 1; i < all.size(); ++i) {
      const std::size_t count = (std::size_t{1} << i) + 1;
      const double* row = transform(1 << i).data();
      for (std::size_t j = 0; j < count; ++j, row += count)
        all[i].push_back(std::inner_product(row, row + count, moment.begin(), 0.0));
    }
    return all;
  }();
  std::size_t i = 0;
  while (1 << i < degree) ++i;
  return made[i];
}

}  // namespace

const std::array<double, kPoints>& band_shares() {
  static const auto made = [] {
    std::array<double, kPoints> shares{};
    for (std::size_t j = 0; j < kPoints; ++j)
      shares[j] = PanelMap{0.0, 1.0}.f(cos_pi(static_cast<double>(j) / kMostBandDegree));
    return shares;
  }();
  return made;
}

double BandWeights::RateSeries::at(double wavelength_um) const {
  const double t = (2.0 * wavelength_um - lo_um - hi_um) / (hi_um - lo_um);
  double b1 = 0.0, b2 = 0.0;
  for (std::size_t k = kRateTerms; k-- > 1;) {
    const double b = 2.0 * t * b1 + (coefficient[k] - b2);
    b2 = b1;
    b1 = b;
  }
  return t * b1 + (coefficient[0] - b2);
}

/// The part is halved until the last terms are rounding errors: a source of 3 K in the visible changes by hundreds of
/// powers of ten. On a part of width w that a curve fills with a straight line, the place between its ends is rounded
/// to 2^-52 lambda / w of it, and so is the rate, however finely the part is halved: `rounding`, which is where halving
/// ends too.
void BandWeights::add_series(double lo_um, double hi_um, double rounding, int depth) {
  constexpr int kDegree = static_cast<int>(kRateTerms) - 1, kDeepest = 30;
  std::vector<double> value;
  for (int j = 0; j <= kDegree; ++j)
    value.push_back(rate_->density(std::clamp(
        0.5 * (lo_um + hi_um) + 0.5 * (hi_um - lo_um) * cos_pi(static_cast<double>(j) / kDegree), lo_um, hi_um)));
  RateSeries series{.lo_um = lo_um, .hi_um = hi_um};
  const auto [least, most] = std::minmax_element(value.begin(), value.end());
  series.flat = *least > 0.7 * *most;
  if (depth == 0) rounding = 8.0 * std::numeric_limits<double>::epsilon() * hi_um / (hi_um - lo_um) * *most;
  const Transform& turn = transform(kDegree);
  for (std::size_t j = 0; j < kRateTerms; ++j)
    for (std::size_t k = 0; k < kRateTerms; ++k) series.coefficient[k] += value[j] * turn[j * kRateTerms + k];
  const double left = std::abs(series.coefficient[kRateTerms - 1]) + std::abs(series.coefficient[kRateTerms - 2]);
  // The largest of Planck's law counts 1.
  if (left > std::max({1e-14 * *most, 1e-17, rounding}) && depth < kDeepest) {
    const double middle = 0.5 * (lo_um + hi_um);
    add_series(lo_um, middle, rounding, depth + 1);
    add_series(middle, hi_um, rounding, depth + 1);
    return;
  }
  series_.push_back(series);
}

void BandWeights::set(const Band& band) {
  if (band.lo_um == lo_um_ && band.hi_um == hi_um_ && band.rate == rate_) return;
  lo_um_ = band.lo_um, hi_um_ = band.hi_um, rate_ = band.rate;
  whole_ = {.a_um = lo_um_, .b_um = hi_um_};
  series_.clear();
  if (!rate_) return;
  const std::vector<double>& ends = rate_->breaks_um();
  for (std::size_t i = 1; i < ends.size(); ++i) add_series(ends[i - 1], ends[i], 0.0, 0);
  double total = 0.0;
  for (const RateSeries& series : series_)  // the integral of T_k is 2 / (1 - k^2) for even k, else 0
    for (std::size_t k = 0; k < kRateTerms; k += 2)
      total += (series.hi_um - series.lo_um) * series.coefficient[k] / (1.0 - static_cast<double>(k * k));
  for (RateSeries& series : series_)
    for (double& coefficient : series.coefficient) coefficient /= total;
}

double BandWeights::rate_at(double wavelength_um) const {
  const auto after = std::upper_bound(series_.begin(), series_.end(), wavelength_um,
                                      [](double w, const RateSeries& series) { return w < series.hi_um; });
  const RateSeries& series = after == series_.end() ? series_.back() : *after;
  return wavelength_um < series_.front().lo_um || wavelength_um > series_.back().hi_um ? 0.0 : series.at(wavelength_um);
}

/// True when no end of a smooth part lies inside.
bool BandWeights::smooth(double a_um, double b_um) const {
  const std::vector<double>& ends = rate_->breaks_um();
  const auto next = std::upper_bound(ends.begin(), ends.end(), a_um);
  return next != ends.begin() && next != ends.end() && *next >= b_um;
}

/// Part by part of those on which the rate is a series, by as many nodes as it and T_k need there (quadrature.h).
void BandWeights::moments(Piece& piece, int degree) const {
  const auto count = static_cast<std::size_t>(degree) + 1;
  piece.known = degree;
  piece.moment.fill(0.0);
  const PanelMap map{piece.a_um, piece.b_um};
  auto series = std::upper_bound(series_.begin(), series_.end(), piece.a_um,
                                 [](double w, const RateSeries& s) { return w < s.hi_um; });
  for (; series != series_.end() && series->lo_um < piece.b_um; ++series) {
    const double lo = std::max(series->lo_um, piece.a_um), hi = std::min(series->hi_um, piece.b_um);
    const double t_lo = map.t(lo), t_hi = map.t(hi), half = 0.5 * (t_hi - t_lo);
    if (!(half > 0.0)) continue;
    const double turns = 0.5 * (degree + 1) * (std::acos(t_lo) - std::acos(t_hi));
    const GaussRule& rule =
        gauss_legendre(static_cast<int>(std::ceil(0.5 * turns + 2.0 * std::cbrt(turns))) + (series->flat ? 4 : 12));
    for (std::size_t n = 0; n < rule.node.size(); ++n) {
      const double t = 0.5 * (t_lo + t_hi) + half * rule.node[n];
      const PanelPlace place = map.at(t);
      const double weight = half * rule.weight[n] * place.slope * series->at(std::clamp(place.f, lo, hi));
      double last = t, now = 1.0;
      for (std::size_t k = 0; k < count; ++k) {
        piece.moment[k] += weight * now;
        const double next = 2.0 * t * now - last;
        last = now;
        now = next;
      }
    }
  }
}

std::span<const double> BandWeights::weights(Piece& piece, int degree) {
  const auto count = static_cast<std::size_t>(degree) + 1;
  const std::span<double> weight = std::span(weight_).first(count);
  const double width = piece.b_um - piece.a_um;
  if (!rate_ || smooth(piece.a_um, piece.b_um)) {
    const std::vector<double>& even = even_weights(degree);
    const auto step = static_cast<std::size_t>(kMostBandDegree / degree);
    for (std::size_t j = 0; j < count; ++j)
      weight[j] =
          width * even[j] * (rate_ ? rate_at(piece.a_um + width * band_shares()[j * step]) : 1.0 / (hi_um_ - lo_um_));
    return weight;
  }
  if (piece.known < degree) {
    const bool whole = piece.a_um == whole_.a_um && piece.b_um == whole_.b_um;
    constexpr int kFew = 8;
    if (whole && whole_.known < kMostBandDegree) moments(whole_, kMostBandDegree);
    if (whole)
      piece.moment = whole_.moment, piece.known = kMostBandDegree;
    else
      moments(piece, degree <= kFew ? kFew : kMostBandDegree);
  }
  const double* row = transform(degree).data();
  for (std::size_t j = 0; j < count; ++j, row += count)
    weight[j] = std::inner_product(row, row + count, piece.moment.begin(), 0.0);
  return weight;
}

}  // namespace mtf
