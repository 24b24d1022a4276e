// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/components.h"

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

#include "calib/fit/fit_report.h"

namespace calib {
namespace {

constexpr double kTail = 0.025;  // on each side of an interval

double chi_square_quantile(double p, double dof) { return 2.0 * boost::math::gamma_p_inv(0.5 * dof, p); }

double below(double dof) { return 1.0 - dof / chi_square_quantile(1.0 - kTail, dof); }
double above(double dof) { return dof / chi_square_quantile(kTail, dof) - 1.0; }
double square(double x) { return x * x; }

}  // namespace

double VarianceComponent::most() const { return high95 > 0.0 ? high95 : k95_sd * sd; }

VarianceComponent variance_component(std::span<const MeanSquareTerm> terms) {
  VarianceComponent result;
  if (terms.empty()) return result;
  const auto dof_where_positive = [](const MeanSquareTerm& term) {
    return term.coefficient > 0.0 ? term.dof : HUGE_VAL;
  };
  const MeanSquareTerm& own = *std::ranges::min_element(terms, {}, dof_where_positive);
  double others = 0.0, low = 0.0, high = 0.0;
  for (const MeanSquareTerm& term : terms) {
    const double value = term.coefficient * term.mean_square;
    result.variance += value;
    if (&term != &own) others += 2.0 * value * value / term.dof;
    const double g = below(term.dof) * value, h = above(term.dof) * value;
    low += value > 0.0 ? g * g : h * h;
    high += value > 0.0 ? h * h : g * g;
  }
  for (const MeanSquareTerm& p : terms)
    for (const MeanSquareTerm& r : terms) {
      const double positive = p.coefficient * p.mean_square, negative = -r.coefficient * r.mean_square;
      if (!(positive > 0.0 && negative > 0.0)) continue;
      const double far = f_quantile(1.0 - kTail, p.dof, r.dof), near = f_quantile(kTail, p.dof, r.dof);
      low += (square(far - 1.0) - square(below(p.dof) * far) - square(above(r.dof))) / far * positive * negative;
      high += (square(1.0 - near) - square(above(p.dof) * near) - square(below(r.dof))) / near * positive * negative;
    }
  const double own_value = own.coefficient * own.mean_square;
  result.sd = std::sqrt(others + 2.0 * square(own_value) / own.dof);
  result.sd_of_zero = std::sqrt(others + 2.0 * square(own_value - result.variance) / own.dof);
  result.low95 = result.variance - std::sqrt(std::max(0.0, low));
  result.high95 = result.variance + std::sqrt(std::max(0.0, high));
  return result;
}

std::vector<MeanSquareTerm> terms_of(const radiometry::MeanSquares& squares, radiometry::CubePart part, double factor) {
  std::vector<MeanSquareTerm> terms;
  for (std::size_t q = 0; q < radiometry::kCubeParts; ++q)
    if (const int sign = radiometry::kCubeSigns[part][q]; sign != 0)
      terms.push_back({factor * sign / squares.divisor(part), squares.value[q], squares.dof(q)});
  return terms;
}

VarianceComponent variance_component(const radiometry::MeanSquares& squares, radiometry::CubePart part) {
  return variance_component(terms_of(squares, part));
}

void widen(VarianceComponent& c, double sd) {
  c.low95 = c.variance - std::hypot(c.variance - c.low95, k95_sd * sd);
  c.high95 = c.variance + std::hypot(c.high95 - c.variance, k95_sd * sd);
  c.sd = std::hypot(c.sd, sd);
}

double chi_square_tail(double chi2, double dof) {
  return dof > 0.0 ? boost::math::gamma_q(0.5 * dof, 0.5 * std::max(0.0, chi2)) : 1.0;
}

double chi_square_median(double dof) { return std::pow(1.0 - 2.0 / (9.0 * dof), 3.0); }

double poisson_tail(double count, double mean) {
  return count > 0.0 ? 1.0 - chi_square_tail(2.0 * mean, 2.0 * count) : 1.0;
}

std::array<double, 2> poisson_limits(double count) {
  constexpr double kMany = 1e9;  // degrees of freedom: chi-square by F
  return {count > 0.0 ? count * f_quantile(0.025, 2.0 * count, kMany) : 0.0,
          (count + 1.0) * f_quantile(0.975, 2.0 * count + 2.0, kMany)};
}

double f_quantile(double p, double dof1, double dof2) {
  double rest = 0.0;  // 1 - y, which is not the difference near y = 1
  const double y = boost::math::ibeta_inv(0.5 * dof1, 0.5 * dof2, p, &rest);
  return y * dof2 / (dof1 * rest);
}

}  // namespace calib
