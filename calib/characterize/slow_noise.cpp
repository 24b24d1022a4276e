// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/slow_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calib/characterize/components.h"
#include "calib/edge/median.h"

namespace calib {
namespace {

constexpr double kModel = 0.03;      // of the 1/f part: the chain's own noise
constexpr double kStrange_p = 1e-6;  // that a pixel like the others is left out
constexpr double kMisfit_p = 1e-3;
constexpr std::size_t kMostScales = 12;

double square(double x) { return x * x; }

/// V(n) of K = 1, by steps in which the phase changes by less than 0.2.
double kept_by_mean(double lowest, double n) {
  const auto steps = static_cast<int>(std::ceil(8.0 * n * std::log(0.5 / lowest)));
  const double step = std::log(0.5 / lowest) / steps;
  double sum = 0.0;
  for (int i = 0; i <= steps; ++i) {
    const double x = std::numbers::pi * lowest * std::exp(step * i), one = square(std::sin(n * x) / (n * std::sin(x)));
    sum += i == 0 || i == steps ? 0.5 * one : one;
  }
  return sum * step;
}

/// Of differences at a scale, of K = 1.
double of_scale(double lowest, std::size_t scale) {
  const double n = std::ldexp(1.0, static_cast<int>(scale));
  return 2.0 * n * (kept_by_mean(lowest, n) - kept_by_mean(lowest, 2.0 * n));
}

double median_of(std::vector<double> values) { return median(values); }

class Scales {
 public:
  explicit Scales(const NoiseScales& noise, double lowest) : noise_(noise) {
    for (std::size_t j = 0; j < std::min(noise.pixels.size(), kMostScales); ++j) unit_.push_back(of_scale(lowest, j));
  }

  /// Marks the pixels that are slower, or noisier, than the others are by chance: by the power at each scale over that
  /// of the median pixel, whose sums are chi-square.
  std::vector<char> strange() const {
    const std::size_t pixels = noise_.pixel_count();
    std::vector<double> fast, slow(pixels, 0.0), power(pixels);
    double n = 0.0;
    for (std::size_t j = 0; j < unit_.size(); ++j) {
      const double differences = noise_.differences(j);
      std::copy(noise_.pixels[j].begin(), noise_.pixels[j].end(), power.begin());
      const double typical = median_of(power) / (differences * chi_square_median(differences));
      for (double& one : power) one /= typical;
      if (j == 0) {
        fast = power;
        continue;
      }
      n += differences;
      for (std::size_t i = 0; i < pixels; ++i) slow[i] += power[i];
    }
    const double n0 = noise_.differences(0), ratio = n / n0 * f_quantile(1.0 - kStrange_p, n, n0),
                 most = (n0 + n) * f_quantile(1.0 - kStrange_p, n0 + n, 1e9);
    std::vector<char> out(pixels);
    for (std::size_t i = 0; i < pixels; ++i) out[i] = slow[i] > ratio * fast[i] ? 2 : slow[i] + fast[i] > most ? 1 : 0;
    return out;
  }

  void fit(double lines, SlowNoise& result) const {
    const std::size_t pixels = noise_.pixel_count();
    double used = 0.0, sum = 0.0, squares = 0.0, n = 0.0;
    std::vector<double> mean(unit_.size()), own(unit_.size());  // own: of all pixels, in the means of frames
    for (std::size_t i = 0; i < pixels; ++i) {
      if (result.left_out[i] != 0) continue;
      used += 1.0;
      sum += noise_.variance(i);
      squares += square(noise_.variance(i));
      for (std::size_t j = 0; j < unit_.size(); ++j) mean[j] += static_cast<double>(noise_.pixels[j][i]);
    }
    for (std::size_t j = 0; j < unit_.size(); ++j) {
      n += noise_.differences(j);
      own[j] = noise_.mean[j] / static_cast<double>(pixels * static_cast<std::size_t>(noise_.rows_apart));
      mean[j] = (mean[j] / used - noise_.frame[j]) / noise_.differences(j) + own[j];
    }
    // Pixels of unequal noise: fewer count.
    const double unequal = std::max(1.0, used * squares / (square(sum) * (1.0 + 2.0 / n)));
    double white = mean[0], strength = 0.0, chi2 = 0.0;
    for (int pass = 0; pass < 20; ++pass) {
      double a = 0.0, b = 0.0, c = 0.0, d = 0.0, e = 0.0;
      std::vector<double> weight(unit_.size());
      for (std::size_t j = 0; j < unit_.size(); ++j) {
        const double x = unit_[j], part = std::max(0.0, strength) * x, power = std::max(0.1 * mean[0], white + part);
        weight[j] = 1.0 / (2.0 * (power * power * unequal / used + lines + square(own[j])) / noise_.differences(j) +
                           square(kModel * part));
        a += weight[j];
        b += weight[j] * x;
        c += weight[j] * x * x;
        d += weight[j] * mean[j];
        e += weight[j] * mean[j] * x;
      }
      const double determinant = a * c - b * b;
      white = (c * d - b * e) / determinant;
      strength = (a * e - b * d) / determinant;
      result.strength = {strength, std::sqrt(a / determinant)};
      const double relative = b / (a * white) + 1.0 / strength;  // of the ratio, by that of the strength
      result.corner = {0.5 * strength / white,
                       0.5 * strength / white *
                           std::sqrt(std::max(0.0, a / determinant * relative * relative + 1.0 / (a * white * white)))};
      chi2 = 0.0;
      for (std::size_t j = 0; j < unit_.size(); ++j) chi2 += weight[j] * square(mean[j] - white - strength * unit_[j]);
    }
    result.p = chi_square_tail(chi2, static_cast<double>(unit_.size()) - 2.0);
    result.found = strength > 3.0 * result.strength.sd && white > 0.0 && result.p > kMisfit_p;
  }

 private:
  const NoiseScales& noise_;
  std::vector<double> unit_;  ///< of each scale, of K = 1
};

}  // namespace

double SlowNoise::of_mean(double n) const {
  return found ? strength.value * kept_by_mean(lowest, n) - within(n) / n : 0.0;
}

double SlowNoise::within(double n) const {
  return found ? strength.value * (std::log(0.5 / lowest) - kept_by_mean(lowest, n)) * n / (n - 1.0) : 0.0;
}

double SlowNoise::freedom(double variance, double n) const {
  if (!found) return 1.0;
  const double rest = variance - within(n);
  double count = 0.0, sum = 0.0, squares = 0.0;
  for (std::size_t j = 0; std::ldexp(1.0, static_cast<int>(j) + 1) <= n; ++j) {
    const double differences = std::floor(std::ldexp(n, -static_cast<int>(j) - 1)),
                 power = std::max(0.0, rest) + strength.value * of_scale(lowest, j);
    count += differences;
    sum += differences * power;
    squares += differences * power * power;
  }
  return sum * sum / (count * squares);
}

SlowNoise estimate_slow_noise(const NoiseScales& noise, double lines) {
  SlowNoise result{.frames = noise.frames};
  if (noise.frames < kSlowFrames) return result;
  result.lowest = 0.1 / static_cast<double>(noise.frames);
  const Scales scales(noise, result.lowest);
  result.left_out = scales.strange();
  scales.fit(lines, result);
  return result;
}

}  // namespace calib
