// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/photon_transfer.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "calib/characterize/components.h"
#include "calib/characterize/rounding.h"
#include "calib/dense.h"
#include "mtf/error.h"

namespace calib {
namespace {

constexpr int kLogGain = 0, kRead2 = 1, kOffset = 2, kRate = 3, kFirst = 4;

/// Mean and variance of a level with their derivatives.
struct Model {
  double electrons = 0.0, slope = 1.0, mean = 0.0, variance = 0.0;
  Eigen::VectorXd by_mean, by_variance;
};

class Problem {
 public:
  Problem(const std::vector<TransferLevel>& levels, const TransferOptions& options)
      : levels_(levels),
        options_(options),
        parameters_(kFirst + options.nonlinearity + (options.dark_current ? 1 : 0)) {
    for (const TransferLevel& level : levels)
      light_.push_back(level.light_sd > 0.0 && level.light > 0.0 ? parameters_ + errors_++ : -1);
  }

  int parameters() const { return parameters_; }  ///< without the errors of the light
  int unknowns() const { return parameters_ + errors_; }
  int light_error(std::size_t i) const { return light_[i]; }

  Model at(const Eigen::VectorXd& x, std::size_t i) const {
    const TransferLevel& level = levels_[i];
    const double gain = std::exp(x[kLogGain]), d = light_[i] < 0 ? 0.0 : x[light_[i]];
    const int terms = options_.nonlinearity, dark = kFirst + terms;
    Model m;
    const double e = x[kRate] * level.light * (1.0 + d) + (options_.dark_current ? x[dark] * level.time_s : 0.0);
    const double u = terms > 0 ? e / options_.full_well_e : 0.0;
    double g = e, g1 = 1.0, g2 = 0.0;  // the response, its slope and the slope of that
    for (int k = 0; k < terms; ++k) {
      const double a = x[kFirst + k], power = std::pow(u, k);
      g += a * e * u * power;
      g1 += (k + 2) * a * u * power;
      g2 += (k + 2) * (k + 1) * a * power / options_.full_well_e;
    }
    m.electrons = e;
    m.slope = g1;
    m.mean = x[kOffset] + gain * g;
    const double before = gain * gain * (g1 * g1 * e + x[kRead2]), step2 = options_.step * options_.step;
    double by_before = 1.0;
    if (options_.step > 0.0) {
      // Below, the noise is next to none in a count: the likelihood falls without bound, and the step is not taken.
      const RoundedVariance q = rounded_variance(std::max(1e-8, (before + level.shared) / step2));
      m.variance = std::max(1e-300, step2 * q.value - level.shared);
      by_before = q.slope;
    } else {
      m.variance = std::max(before, 1e-300);
    }
    m.by_mean = m.by_variance = Eigen::VectorXd::Zero(unknowns());
    const auto by_electrons = [&](int k, double by) {
      m.by_mean[k] = gain * g1 * by;
      m.by_variance[k] = by_before * gain * gain * (g1 * g1 + 2.0 * g1 * g2 * e) * by;
    };
    m.by_mean[kLogGain] = gain * g;
    m.by_variance[kLogGain] = by_before * 2.0 * before;
    m.by_variance[kRead2] = by_before * gain * gain;
    m.by_mean[kOffset] = 1.0;
    by_electrons(kRate, level.light * (1.0 + d));
    for (int k = 0; k < terms; ++k) {
      m.by_mean[kFirst + k] = gain * e * std::pow(u, k + 1);
      m.by_variance[kFirst + k] = by_before * gain * gain * 2.0 * g1 * e * (k + 2) * std::pow(u, k + 1);
    }
    if (options_.dark_current) by_electrons(dark, level.time_s);
    if (light_[i] >= 0) by_electrons(light_[i], x[kRate] * level.light);
    return m;
  }

  /// Where the pixels scatter more than chi-square, their variance is taken for normal.
  bool is_normal(std::size_t i) const {
    const TransferLevel& level = levels_[i];
    return level.variance_sd > level.variance * std::sqrt(2.0 / level.dof);
  }
  double variance_sd(std::size_t i, const Model& m) const {
    return is_normal(i) ? levels_[i].variance_sd : m.variance * std::sqrt(2.0 / levels_[i].dof);
  }

  /// -2 ln L, but for a constant.
  double cost(const Eigen::VectorXd& x) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      const TransferLevel& level = levels_[i];
      const Model m = at(x, i);
      sum += (level.mean - m.mean) * (level.mean - m.mean) / level.mean_variance;
      if (light_[i] >= 0) sum += x[light_[i]] * x[light_[i]] / (level.light_sd * level.light_sd);
      if (!level.variance_counts) continue;
      const double z = (level.variance - m.variance) / variance_sd(i, m), ratio = level.variance / m.variance;
      sum += is_normal(i) ? z * z : level.dof * (ratio - 1.0 - std::log(std::max(ratio, 1e-300)));
    }
    return sum;
  }

  /// Fisher's information, and the gradient of ln L.
  std::pair<Eigen::MatrixXd, Eigen::VectorXd> score(const Eigen::VectorXd& x) const {
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns(), unknowns());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns());
    const auto add = [&](const Eigen::VectorXd& by, double residual, double weight) {
      information += weight * by * by.transpose();
      gradient += weight * residual * by;
    };
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      const TransferLevel& level = levels_[i];
      const Model m = at(x, i);
      const double sd = variance_sd(i, m);
      add(m.by_mean, level.mean - m.mean, 1.0 / level.mean_variance);
      if (level.variance_counts) add(m.by_variance, level.variance - m.variance, 1.0 / (sd * sd));
      if (light_[i] < 0) continue;
      const double weight = 1.0 / (level.light_sd * level.light_sd);
      information(light_[i], light_[i]) += weight;
      gradient[light_[i]] -= weight * x[light_[i]];
    }
    return {information, gradient};
  }

 private:
  const std::vector<TransferLevel>& levels_;
  const TransferOptions& options_;
  int parameters_, errors_ = 0;
  std::vector<int> light_;  ///< the unknown that is the error of a level's light, -1 for none
};

/// A^-1 of a positive matrix whose rows differ in size by many decades.
Eigen::MatrixXd scaled_inverse(const Eigen::MatrixXd& a) {
  const Eigen::VectorXd scale = a.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * inverse_of(scale.asDiagonal() * a * scale.asDiagonal()) * scale.asDiagonal();
}

void require_levels(const std::vector<TransferLevel>& levels, const TransferOptions& options) {
  std::set<double> lights;
  int variances = 0;
  for (const TransferLevel& level : levels) {
    lights.insert(level.light);
    variances += level.variance_counts ? 1 : 0;
  }
  const std::string few = too_few_levels(lights.size(), options.nonlinearity);
  if (few.empty() && variances < 2)
    throw mtf::UsageError("rounding hides the noise of all levels but " + std::to_string(variances) + ": " +
                          hidden_words() + "; raise the gain of the camera");
  if (!few.empty()) throw mtf::UsageError(few);
}

Eigen::VectorXd start_of(const std::vector<TransferLevel>& levels, const TransferOptions& options, int unknowns) {
  const auto lighter = [](const TransferLevel& a, const TransferLevel& b) { return a.light < b.light; };
  const TransferLevel &dark = *std::min_element(levels.begin(), levels.end(), lighter),
                      &bright = *std::max_element(levels.begin(), levels.end(), lighter);
  double sum = 0.0, by_mean = 0.0, by_variance = 0.0, squares = 0.0, products = 0.0;
  for (const TransferLevel& level : levels) {
    if (!level.variance_counts) continue;
    const double v = std::max(level.variance, 1e-6), w = 1.0 / (v * v);
    sum += w;
    by_mean += w * level.mean;
    by_variance += w * v;
    squares += w * level.mean * level.mean;
    products += w * level.mean * v;
  }
  const double gain = (products - by_mean * by_variance / sum) / (squares - by_mean * by_mean / sum);
  if (!(gain > 0.0 && (bright.variance > dark.variance || !bright.variance_counts)))
    throw mtf::UsageError(
        "the temporal variance does not rise with the mean, as the shot noise of light does: these are no frames of "
        "the "
        "sensor itself but processed ones (denoised, or with a curve); give the camera's raw frames");
  if (!(bright.mean > dark.mean))
    throw mtf::UsageError("the mean does not rise with the light: stacks and exposures are paired wrongly");
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  x[kLogGain] = std::log(gain);
  x[kRate] = (bright.mean - dark.mean) / gain / (bright.light - dark.light);
  x[kOffset] = dark.mean - gain * x[kRate] * dark.light;
  const double step2 = options.step * options.step;
  const double read =
      step2 > 0.0 ? std::max(0.0, step2 * unrounded_variance((dark.variance + dark.shared) / step2) - dark.shared)
                  : dark.variance;
  x[kRead2] = std::max(read / (gain * gain) - x[kRate] * dark.light, 0.1 * read / (gain * gain));
  return x;
}

PhotonTransfer::Level level_of(const Model& m) {
  return {.electrons = m.electrons, .slope = m.slope, .mean = m.mean, .variance = m.variance};
}

}  // namespace

std::string too_few_levels(std::size_t levels, int nonlinearity) {
  const std::size_t needed = 3 + static_cast<std::size_t>(nonlinearity);
  if (levels >= needed) return "";
  return "the photon transfer has " + std::to_string(levels) + " usable levels of light; " + std::to_string(needed) +
         " are needed" + (nonlinearity > 0 ? " with nonlinearity = " + std::to_string(nonlinearity) : "") +
         ": give stacks at more exposures";
}

PhotonTransfer fit_photon_transfer(const std::vector<TransferLevel>& levels, const TransferOptions& options) {
  require_levels(levels, options);
  const Problem problem(levels, options);
  Eigen::VectorXd x = start_of(levels, options, problem.unknowns());
  PhotonTransfer fit;
  fit.options = options;
  double cost = problem.cost(x);
  constexpr int kMost = 200;
  for (fit.iterations = 1; fit.iterations <= kMost && !fit.converged; ++fit.iterations) {
    const auto [information, gradient] = problem.score(x);
    const Eigen::MatrixXd inverse = scaled_inverse(information);
    Eigen::VectorXd step = inverse * gradient;
    // In standard deviations: what is below a millionth of one changes nothing that is stated.
    const double size = (step.cwiseQuotient(inverse.diagonal().cwiseMax(1e-300).cwiseSqrt())).cwiseAbs().maxCoeff();
    double next = problem.cost(x + step);
    for (int halvings = 0; halvings < 40 && !(next <= cost + 1e-9 * (1.0 + std::abs(cost))); ++halvings) {
      step *= 0.5;
      next = problem.cost(x + step);
    }
    if (!std::isfinite(next)) break;
    x += step;
    cost = next;
    fit.converged = size < 1e-9;
  }

  const Eigen::MatrixXd all = scaled_inverse(problem.score(x).first);
  const int n = problem.parameters();
  Eigen::VectorXd to_gain = Eigen::VectorXd::Ones(n);
  to_gain[kLogGain] = std::exp(x[kLogGain]);
  fit.covariance = to_gain.asDiagonal() * all.topLeftCorner(n, n) * to_gain.asDiagonal();
  const auto estimate = [&](int k) {
    return Estimate{k == kLogGain ? to_gain[kLogGain] : x[k], std::sqrt(fit.covariance(k, k))};
  };
  fit.gain = estimate(kLogGain);
  fit.read2 = estimate(kRead2);
  fit.offset = estimate(kOffset);
  fit.rate = estimate(kRate);
  fit.names = {"gain", "read2", "offset", "rate"};
  for (int k = 0; k < options.nonlinearity; ++k) {
    fit.a.push_back(estimate(kFirst + k));
    fit.names.push_back("a" + std::to_string(k + 2));
  }
  if (options.dark_current) {
    fit.dark = estimate(kFirst + options.nonlinearity);
    fit.names.push_back("dark");
  }
  fit.dof = -n;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const Model m = problem.at(x, i);
    PhotonTransfer::Level level = level_of(m);
    level.mean_z = (levels[i].mean - m.mean) / std::sqrt(levels[i].mean_variance);
    if (levels[i].variance_counts) level.variance_z = (levels[i].variance - m.variance) / problem.variance_sd(i, m);
    fit.chi2 += level.mean_z * level.mean_z + level.variance_z * level.variance_z;
    fit.dof += levels[i].variance_counts ? 2 : 1;
    if (const int d = problem.light_error(i); d >= 0) {
      level.light_error = x[d];
      fit.chi2 += x[d] * x[d] / (levels[i].light_sd * levels[i].light_sd);
    }
    fit.levels.push_back(level);
  }
  fit.p = chi_square_tail(fit.chi2, fit.dof);
  return fit;
}

PhotonTransfer::Level level_at(const PhotonTransfer& fit, double light, double time_s) {
  const std::vector<TransferLevel> levels{{.light = light, .time_s = time_s}};
  const Problem problem(levels, fit.options);
  Eigen::VectorXd x(problem.parameters());
  x.head(kFirst) << std::log(fit.gain.value), fit.read2.value, fit.offset.value, fit.rate.value;
  Eigen::Index k = kFirst;
  for (const Estimate& term : fit.a) x[k++] = term.value;
  if (fit.dark) x[k] = fit.dark->value;
  return level_of(problem.at(x, 0));
}

}  // namespace calib
