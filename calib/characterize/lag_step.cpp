// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/lag_step.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "calib/characterize/components.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace calib {
namespace {

// Noise that lasts longer is not told from lag by few frames. What is left of a sum over frames less a part that is
// only estimated is taken as this share of it at the least.
constexpr double kMisfit = 0.999, kMostLasting = 0.9, kLeastRest = 0.25;

/// Variance of numbers from the differences of neighbours, which a slow change hardly raises.
double variance_of_steps(std::span<const double> values) {
  double sum = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) sum += (values[i] - values[i - 1]) * (values[i] - values[i - 1]);
  return 0.5 * sum / static_cast<double>(values.size() - 1);
}

/// Sums of the products of the derivatives of the model by A, B and r, and with the residuals.
struct NormalSums {
  double bb = 0.0, br = 0.0, rr = 0.0, ba = 0.0, ra = 0.0, gb = 0.0, gr = 0.0, residuals = 0.0;
  double determinant() const { return bb * rr - br * br; }
};
NormalSums sums_of(std::span<const double> after, double A, double B, double r) {
  NormalSums s;
  double before = 1.0, k = 1.0;  // r^(k - 1)
  for (const double value : after) {
    const double of_a = before * r, of_b = 1.0 - of_a, of_r = (A - B) * k * before, left = value - B - (A - B) * of_a;
    s.bb += of_b * of_b;
    s.br += of_b * of_r;
    s.rr += of_r * of_r;
    s.ba += of_b * of_a;
    s.ra += of_r * of_a;
    s.gb += of_b * left;
    s.gr += of_r * left;
    s.residuals += left * left;
    before *= r;
    k += 1.0;
  }
  return s;
}

}  // namespace

LagStep fit_lag_step(const std::vector<double>& means) {
  std::size_t first = 0;  // after the step
  double largest = 0.0;
  for (std::size_t t = 1; t < means.size(); ++t)
    if (const double size = std::abs(means[t] - means[t - 1]); size > largest) largest = size, first = t;
  const auto start = static_cast<std::ptrdiff_t>(first), count = std::ssize(means) - start;
  if (start < kBeforeStep || count < kAfterStep)
    throw mtf::UsageError("the light steps after " + std::to_string(start) + " of " + std::to_string(means.size()) +
                          " frames; give " + std::to_string(kBeforeStep) + " or more before the step and " +
                          std::to_string(kAfterStep) + " or more after it");
  const std::span all(means), after = all.subspan(first), late = after.subspan(after.size() / 2);
  const double noise_before = variance_of_steps(all.first(first));
  if (!(largest * largest > 100.0 * (noise_before + variance_of_steps(late))))
    throw mtf::UsageError("no step: successive frames differ by their noise; let the light step between two of them");
  LagStep step;
  for (const double one : all.first(first)) step.before += one / static_cast<double>(first);
  double B = after.back(), r = std::clamp((after.front() - B) / (step.before - B), -0.5, 0.9);
  for (int pass = 0; pass < 100; ++pass) {  // Gauss and Newton
    const NormalSums s = sums_of(after, step.before, B, r);
    const double next = std::clamp(r + (s.bb * s.gr - s.br * s.gb) / s.determinant(), -0.9, 0.5 * (1.0 + r));
    B += (s.rr * s.gb - s.br * s.gr) / s.determinant();
    const bool done = std::abs(next - r) < 1e-13;
    r = next;
    if (done) break;
  }
  const NormalSums s = sums_of(after, step.before, B, r);
  const double D = s.determinant(), n = static_cast<double>(count);
  const double noise = s.residuals / (n - 2.0);
  const double b_by_a = (s.rr * s.ba - s.br * s.ra) / D, r_by_a = (s.bb * s.ra - s.br * s.ba) / D;
  // What each frame makes of B and r, and the noise of successive ones as it is correlated.
  std::vector<double> of_b, of_r, by_b, by_r, left;
  for (double power = r, before = 1.0, k = 1.0; by_b.size() < after.size(); before = power, power *= r, k += 1.0) {
    of_b.push_back(1.0 - power);
    of_r.push_back((step.before - B) * k * before);
    by_b.push_back((s.rr * of_b.back() - s.br * of_r.back()) / D);
    by_r.push_back((s.bb * of_r.back() - s.br * of_b.back()) / D);
    left.push_back(after[left.size()] - B - (step.before - B) * power);
  }
  // Light has noise of its own, of which the first frames after a step to less of it have a part.
  const double noise_late = variance_of_steps(std::span(left).subspan(left.size() / 2)),
               of_light = std::max(0.0, noise_before - noise_late);
  // The correlation r of n numbers about their mean is low by (1 + 4 r)/n (F. H. C. Marriott and J. A. Pope, Biometrika
  // 41, 390 (1954)), of white ones about a fit of B and r by up to 2/n: with 3 it is hardly too low.
  double products = 0.0, light = of_light, light_b = 0.0, light_r = 0.0, light_sum = 0.0;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (i > 0) products += left[i] * left[i - 1];
    light *= std::abs(r);
    light_b += light * by_b[i] * by_b[i];
    light_r += light * by_r[i] * by_r[i];
    light_sum += light;
  }
  const double rest = std::max(kLeastRest * s.residuals, s.residuals - light_sum),
               seen = rest > 0.0 ? products / rest : 0.0,
               lasts = std::clamp(seen + (3.0 + 4.0 * std::max(0.0, seen)) / n, 0.0, kMostLasting);
  const auto correlated = [&](const std::vector<double>& x, const std::vector<double>& y) {
    double sum = 0.0, before_x = 0.0, before_y = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += x[i] * y[i] + x[i] * before_y + y[i] * before_x;
      before_x = lasts * (before_x + x[i]);
      before_y = lasts * (before_y + y[i]);
    }
    return sum;
  };
  // The fit takes more of noise that lasts than two numbers of it.
  const double lasting = rest / std::max(kLeastRest * n, n - correlated(by_b, of_b) - correlated(by_r, of_r)),
               of_before = (of_light + std::min(noise_before, noise_late) * (1.0 + lasts) / std::pow(1.0 - lasts, 2)) /
                           static_cast<double>(first);
  step.after = {B, std::sqrt(lasting * correlated(by_b, by_b) + light_b + b_by_a * b_by_a * of_before)};
  step.kept = {r, std::sqrt(lasting * correlated(by_r, by_r) + light_r + r_by_a * r_by_a * of_before)};
  // Squares of noise that lasts are correlated by the square of its correlation; differences of n numbers have two
  // thirds of n degrees of freedom.
  step.dof = (n - 2.0) * (1.0 - lasts * lasts) / (1.0 + lasts * lasts);
  step.is_exponential = std::isfinite(r) && std::isfinite(step.kept.sd) &&
                        noise <= (noise_late / (1.0 - lasts) + light_sum / (n - 2.0)) *
                                         f_quantile(kMisfit, step.dof, 2.0 / 3.0 * static_cast<double>(late.size())) +
                                     1e-13 * (step.before - B) * (step.before - B);
  return step;
}

void add_lag(const LagStep& step, double frame_time_s, const std::string& from, Characterization& camera) {
  const double r = step.kept.value, t = std::sqrt(f_quantile(0.95, 1.0, step.dof)), half = t * step.kept.sd;
  Finding share{.name = "lag_share",
                .unit = "",
                .value = r,
                .sd = step.kept.sd,
                .low95 = r - half,
                .high95 = r + half,
                .from = from + ", of a step, missing in the next frame"};
  const bool found = step.is_exponential && r > std::max(3.0, t) * step.kept.sd;
  if (!step.is_exponential) {
    share.verdict = Verdict::not_determined;
    share.why =
        "the frames after the step do not follow one exponential: let the light step between two exposures, and "
        "fit the response where it bends (nonlinearity)";
  } else if (!found) {
    share.verdict = Verdict::upper_limit;
    share.low95 = 0.0;
    share.high95 = std::max(half, share.high95);
  }
  camera.findings.push_back(share);
  if (!found) return;
  const auto constant = [&](double kept) { return -frame_time_s / std::log(kept); };
  Finding time{.name = "lag_time_constant",
               .unit = "s",
               .value = constant(r),
               .sd = constant(r) * step.kept.sd / (r * std::abs(std::log(r))),
               .low95 = constant(share.low95),
               .high95 = share.high95 < 1.0 ? constant(share.high95) : 0.0,
               .from = from + ", frames " + mtf::significant(frame_time_s, 6) + " s apart"};
  if (!(share.high95 < 1.0)) {
    time.verdict = Verdict::not_determined;
    time.why = "the frames after the step are too few to show where it ends; give more";
  }
  camera.findings.push_back(time);
}

}  // namespace calib
