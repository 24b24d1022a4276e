// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/band_mean.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mtf/math/clones.h"

namespace mtf {
namespace {

using std::numbers::pi;

constexpr std::size_t kPoints = 16;  // on a panel, along the angle
constexpr std::size_t kFewWavelengths = 16, kMostWavelengths = 64;
constexpr double kNarrowest = pi / 1024.0;  // width of a panel
constexpr double kDerivativeError = 1e-5;   // relative size of the last terms; those left out are smaller
constexpr double kRounding = 1e-11;         // a derivative below this is taken as 0
constexpr int kFewestNodes = 8, kMostNodes = 256;
constexpr double kConverged = 0.1;  // share of the error that was asked for

/// Chebyshev coefficient of n values at the points, `stride` numbers apart.
double coefficient(const double* values, std::size_t stride, std::size_t n, std::size_t order) {
  double sum = 0.0;
  for (std::size_t j = 0; j < n; ++j)
    sum += values[j * stride] * std::cos(pi * static_cast<double>(order) * (2.0 * static_cast<double>(j) + 1.0) /
                                         (2.0 * static_cast<double>(n)));
  return (order == 0 ? 1.0 : 2.0) / static_cast<double>(n) * sum;
}

MTFKIT_CLONES void add_product(std::size_t n, std::size_t width, const double* weight, const double* values,
                               double* sum) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < width; ++k) sum[k] += weight[i] * values[i * width + k];
}

}  // namespace

BandMean::BandMean(Function p, std::size_t width, const Band& band, std::vector<double> breaks, bool ends,
                   double most_t, const Options& options)
    : p_(std::move(p)),
      width_(width),
      options_(options),
      band_(band),
      breaks_(std::move(breaks)),
      ends_(ends),
      across_panel_(Barycentric::inside(kPoints)) {
  if (!(most_t > 0.0)) return;
  for (int n = kFewestNodes; n <= kMostNodes; n *= 2) whole_.push_back(part_nodes(band_, band_.lo_um, band_.hi_um, n));
  tabulate(ends_ ? std::min(most_t, breaks_.back()) : most_t);
}

double BandMean::wavelength_at(std::size_t l) const {
  const double turn = 0.5 * (1.0 + across_band_.x[l]);
  return 1.0 / ((1.0 - turn) / band_.hi_um + turn / band_.lo_um);
}

BandMean::Panel BandMean::sampled(double u_begin, double u_end, double angle_begin, double angle_end) const {
  const auto u_at = [&](double angle) { return u_begin + 0.5 * (u_end - u_begin) * (1.0 - std::cos(angle)); };
  Panel panel{u_begin, u_end, angle_begin, angle_end, u_at(angle_begin), {}};
  panel.values.resize(kPoints * wavelengths_ * width_);
  std::array<double, kPoints> u{}, t{};
  for (std::size_t i = 0; i < kPoints; ++i)
    u[i] = u_at(angle_begin + 0.5 * (angle_end - angle_begin) * (1.0 + across_panel_.x[i]));
  std::vector<double> values(kPoints * width_);
  for (std::size_t l = 0; l < wavelengths_; ++l) {
    const double wavelength = wavelength_at(l);
    for (std::size_t i = 0; i < kPoints; ++i) t[i] = u[i] * band_.hi_um / wavelength;
    p_(wavelength, t, values);
    for (std::size_t i = 0; i < kPoints; ++i)
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i * width_), width_,
                  panel.values.begin() + static_cast<std::ptrdiff_t>((i * wavelengths_ + l) * width_));
  }
  return panel;
}

// The number of wavelengths that resolves P at a few u, and the size of what it leaves out.
std::vector<double> BandMean::choose_wavelengths(double most_u) {
  constexpr std::array kShares{0.15, 0.35, 0.6, 0.85};
  std::vector<double> allowed(width_);
  for (const std::size_t trial : {kFewWavelengths, kMostWavelengths}) {
    across_band_ = Barycentric::inside(trial);
    std::vector<double> values(kShares.size() * trial * width_);
    for (std::size_t i = 0; i < kShares.size() * trial; ++i) {
      const double wavelength = wavelength_at(i % trial), t = kShares[i / trial] * most_u * band_.hi_um / wavelength;
      p_(wavelength, {&t, 1}, std::span(values).subspan(i * width_, width_));
    }
    wavelengths_ = 2;
    for (std::size_t k = 0; k < width_; ++k) {
      double largest = 0.0;
      for (std::size_t i = k; i < values.size(); i += width_) largest = std::max(largest, std::abs(values[i]));
      allowed[k] = k < options_.exact ? options_.error : std::max(kDerivativeError * largest, kRounding);
      for (std::size_t share = 0; share < kShares.size(); ++share) {
        double left_out = 0.0;
        for (std::size_t order = trial; order > wavelengths_; --order) {
          left_out += std::abs(coefficient(&values[share * trial * width_ + k], width_, trial, order - 1));
          if (left_out > allowed[k]) wavelengths_ = order;
        }
      }
    }
    if (wavelengths_ + 2 < trial) break;
  }
  across_band_ = Barycentric::inside(wavelengths_);
  return allowed;
}

// True when the last terms along the angle are within the allowed error at every wavelength.
bool BandMean::resolved(const Panel& panel, std::span<const double> allowed) const {
  const std::size_t line = wavelengths_ * width_;
  for (std::size_t i = 0; i < line; ++i)
    for (const std::size_t order : {kPoints - 2, kPoints - 1})
      if (std::abs(coefficient(&panel.values[i], line, kPoints, order)) > allowed[i % width_]) return false;
  return true;
}

// Each piece begins as one panel; panels are halved until all are resolved.
void BandMean::tabulate(double most_u) {
  std::vector<double> ends{0.0};
  for (const double u : breaks_)
    if (u > ends.back() && u < most_u) ends.push_back(u);
  // The angle of the last piece is that of all of it, so that the kink at its end is its own.
  const auto beyond = std::find_if(breaks_.begin(), breaks_.end(), [&](double u) { return u >= most_u; });
  ends.push_back(beyond != breaks_.end() ? *beyond : most_u);

  const std::vector<double> allowed = choose_wavelengths(most_u);
  std::vector<Panel> waiting;
  for (std::size_t piece = ends.size() - 1; piece > 0; --piece)
    waiting.push_back(sampled(ends[piece - 1], ends[piece], 0.0, pi));
  while (!waiting.empty()) {
    Panel panel = std::move(waiting.back());
    waiting.pop_back();
    const double middle = 0.5 * (panel.angle_begin + panel.angle_end);
    if (middle - panel.angle_begin < kNarrowest || panels_.size() + waiting.size() >= options_.panels ||
        resolved(panel, allowed)) {
      panels_.push_back(std::move(panel));
      continue;
    }
    waiting.push_back(sampled(panel.u_begin, panel.u_end, middle, panel.angle_end));
    waiting.push_back(sampled(panel.u_begin, panel.u_end, panel.angle_begin, middle));
  }
}

void BandMean::look_up(double u, double wavelength_um, double weight, std::span<double> sum) const {
  const auto after = std::upper_bound(panels_.begin() + 1, panels_.end(), u,
                                      [](double value, const Panel& panel) { return value < panel.from_u; });
  const Panel& panel = *(after - 1);
  const double cosine = 1.0 - 2.0 * (u - panel.u_begin) / (panel.u_end - panel.u_begin);
  const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
  std::array<double, kPoints> along{};
  across_panel_.weights_at(2.0 * (angle - panel.angle_begin) / (panel.angle_end - panel.angle_begin) - 1.0,
                           along.data());
  std::array<double, kMostWavelengths> across{};
  const double turn = (1.0 / wavelength_um - 1.0 / band_.hi_um) / (1.0 / band_.lo_um - 1.0 / band_.hi_um);
  across_band_.weights_at(2.0 * turn - 1.0, across.data());
  std::array<double, kPoints * kMostWavelengths> both;
  for (std::size_t i = 0; i < kPoints; ++i)
    for (std::size_t l = 0; l < wavelengths_; ++l) both[i * wavelengths_ + l] = weight * along[i] * across[l];
  add_product(kPoints * wavelengths_, width_, both.data(), panel.values.data(), sum.data());
}

// Adds the integral over a part of the band.
void BandMean::add_rule(double t, const WavelengthNodes& rule, std::span<double> sum) const {
  std::vector<double> values(width_);
  for (std::size_t i = 0; i < rule.weight.size(); ++i) {
    if (wavelengths_ > 0 && t > 0.0) {
      look_up(t * rule.wavelength_um[i] / band_.hi_um, rule.wavelength_um[i], rule.weight[i], sum);
    } else {
      p_(rule.wavelength_um[i], {&t, 1}, values);
      for (std::size_t k = 0; k < width_; ++k) sum[k] += rule.weight[i] * values[k];
    }
  }
}

void BandMean::at(double t, std::span<double> mean) const {
  std::vector<double> ends{band_.lo_um};
  for (auto u = breaks_.rbegin(); u != breaks_.rend() && t > 0.0; ++u)
    if (const double wavelength = *u * band_.hi_um / t; wavelength > band_.lo_um && wavelength < band_.hi_um)
      ends.push_back(wavelength);
  if (ends_ && t * band_.lo_um >= breaks_.back() * band_.hi_um) {  // all beyond the cutoff
    std::fill(mean.begin(), mean.end(), 0.0);
    return;
  }
  const bool cut = ends_ && t > breaks_.back();
  if (!cut) ends.push_back(band_.hi_um);
  std::sort(ends.begin(), ends.end());

  std::vector<double> finer(width_);
  std::fill(mean.begin(), mean.end(), 0.0);
  for (std::size_t piece = 1; piece < ends.size(); ++piece) {
    std::vector<double> part(width_);
    const bool whole = ends[piece - 1] == band_.lo_um && ends[piece] == band_.hi_um;
    const auto add = [&](int nodes, std::size_t doublings, std::vector<double>& sum) {
      if (whole && !whole_.empty())
        add_rule(t, whole_[doublings], sum);
      else
        add_rule(t, part_nodes(band_, ends[piece - 1], ends[piece], nodes), sum);
    };
    add(kFewestNodes, 0, part);
    std::size_t doublings = 0;
    for (int nodes = 2 * kFewestNodes; nodes <= kMostNodes; nodes *= 2) {
      std::fill(finer.begin(), finer.end(), 0.0);
      add(nodes, ++doublings, finer);
      double change = 0.0;
      for (std::size_t k = 0; k < options_.exact; ++k) change = std::max(change, std::abs(finer[k] - part[k]));
      part.swap(finer);
      if (change < kConverged * options_.error) break;
    }
    for (std::size_t k = 0; k < width_; ++k) mean[k] += part[k];
  }
}

}  // namespace mtf
