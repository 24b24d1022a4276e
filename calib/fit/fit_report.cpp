// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/fit_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/dense.h"
#include "mtf/words.h"

namespace calib {
namespace {

constexpr double kRadian_deg = 180.0 / std::numbers::pi;
constexpr double kUnseen = 1e18;  // variance of an x that nothing in the data depends on

/// The size against which an error of x counts as large, see identifiability.h.
double reference_of(const Variable& v, double x, const FitParameter& parameter) {
  if (v.period > 0.0) return kRadian_deg / v.step;
  double reference = std::max(std::abs(x), 1.0);
  // A size that is known to a fraction of itself; one near zero by what it does.
  if (parameter.min || parameter.max) reference = std::min(reference, v.hi - v.lo);
  return reference;
}

// Weak directions in words: which parameters they combine, what is known of these, and what would separate them.

/// The largest edge of the fit; nullptr without edges.
const EdgeBlock* largest_edge(const FitProblem& problem, std::size_t& index) {
  const EdgeBlock* most = nullptr;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b)
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]))
      if (most == nullptr || edge->pixels() > most->pixels()) most = edge, index = b;
  return most;
}

/// Information of one more edge as good as the largest one, turned by an angle: what its pixels determine after offset
/// and plateaus are projected out.
Eigen::MatrixXd one_more(const Solved& solved, double turn_rad) {
  const FitProblem& problem = *solved.problem;
  const std::size_t n = problem.variables.size();
  Eigen::MatrixXd none = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  std::size_t b = 0;
  const EdgeBlock* const edge = largest_edge(problem, b);
  if (edge == nullptr) return none;
  constexpr double kRange_px = 24.0, kStep_px = 0.125;
  const double angle = edge->curve(problem.own[b]).angle_rad + turn_rad;
  const SliceNodes nodes = problem.sensors->slice(edge->condition(), angle, kRange_px);
  const StepResponse step(nodes, problem.sensors->otf(edge->condition(), along(angle, nodes.f_cy_px)));
  const double cnr = std::abs(problem.own[b][edge->contrast_index()]) / edge->middle_sd();
  const double length = std::max(1.0, edge->data().start.length_px);
  const double noise = trusted_noise(solved.noise_factor[b]) * std::max(1.0, solved.tests[b].noise.sum());
  const double weight = cnr * std::sqrt(length * kStep_px / noise);
  NormalMatrix normal(3 + n);
  std::vector<double> e(step.count());
  for (double d = -kRange_px; d <= kRange_px; d += kStep_px) {
    const double spread = step.at(d, e);
    const std::span<double> row = normal.next();
    row[0] = weight * spread;
    row[1] = weight;
    row[2] = weight * e[0];
    for (std::size_t i = 0; i < n; ++i) row[3 + i] = weight * e[1 + i] * problem.variables[i].slope(problem.x[i]);
    row[3 + n] = 0.0;
    normal.add();
  }
  return project_out(normal.matrix(), 3, n);
}

bool one_direction(std::span<const double> normals_rad) {
  for (const double a : normals_rad)
    if (std::abs(std::sin(a - normals_rad.front())) > std::sin(20.0 * std::numbers::pi / 180.0)) return false;
  return true;
}

/// Second moment that the members add together, with its sd: known where each acts by its square.
std::optional<Estimate> combined_moment(FitProblem& problem, const Solved& solved,
                                        std::span<const std::size_t> members) {
  for (const std::size_t i : members)
    if (!problem.variables[i].squared || problem.variables[i].lo > 0.0) return std::nullopt;
  Functional moment = equivalent_variance(solved);
  const std::vector<double> x = problem.x;
  for (const std::size_t i : members) problem.x[i] = 0.0;
  const bool allowed = problem.apply();
  if (allowed) moment.value -= equivalent_variance(solved).value;
  problem.x = x;
  problem.apply();
  for (Eigen::Index i = 0; i < moment.gradient.size(); ++i)
    if (std::ranges::find(members, static_cast<std::size_t>(i)) == members.end()) moment.gradient[i] = 0.0;
  const Estimate estimate{moment.value, sd_of(solved, moment)};
  return allowed && estimate.sd < 0.3 * std::abs(estimate.value) ? std::optional(estimate) : std::nullopt;
}

}  // namespace

Information information_of(const FitProblem& problem, std::span<const Eigen::MatrixXd> normals,
                           std::span<const Eigen::MatrixXd> scores, std::span<const double> noise_factor) {
  const std::size_t n = problem.variables.size();
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd independent = Eigen::MatrixXd::Zero(size, size), more = independent;
  bool shared = false;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    const std::size_t own = problem.own[b].size();
    const Eigen::MatrixXd one = project_out(normals[b], own, n);
    independent += one / trusted_noise(noise_factor[b]);
    if (scores[b].size() == 0) continue;
    shared = true;
    more += (project_scores(normals[b], scores[b], own, n) - one) / trusted_noise(noise_factor[b]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!problem.priors[i]) continue;
    const double weight = problem.variables[i].slope(problem.x[i]) / (*problem.priors[i])[1];
    independent(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) += weight * weight;
  }
  return {shared ? sandwich_information(independent, independent + more) : independent, independent};
}

void identify(Solved& solved) {
  solved.identified = identify(solved.information.matrix, solved.reference);
  solved.variance_ratio.assign(solved.reference.size(), 1.0);
  const auto white = [](const Eigen::MatrixXd& scores) { return scores.size() == 0; };
  if (std::ranges::all_of(solved.scores, white)) return;
  const Eigen::MatrixXd &here = solved.identified.covariance,
                        least = identify(solved.information.independent, solved.reference).covariance;
  for (std::size_t i = 0; i < solved.variance_ratio.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    solved.variance_ratio[i] = std::max(1.0, here(index, index) / least(index, index));
  }
}

void judge(Solved& solved, std::span<const FitParameter> parameters) {
  const FitProblem& problem = *solved.problem;
  solved.tests = test_residuals(problem, solved.noise_factor);
  solved.scores = problem.score_covariances(noise_of(solved.tests));
  solved.information = information_of(problem, solved.normals, solved.scores, solved.noise_factor);
  solved.reference.clear();
  for (std::size_t i = 0; i < problem.variables.size(); ++i)
    solved.reference.push_back(reference_of(problem.variables[i], problem.x[i], parameters[i]));
  identify(solved);
}

double sd_of(const Solved& solved, const Functional& functional) {
  const double variance = functional.gradient.dot(solved.identified.covariance * functional.gradient);
  return std::sqrt(std::max(0.0, variance));
}

std::vector<Functional> mtf_of(const Solved& solved, std::span<const double> f_cy_px) {
  const FitProblem& problem = *solved.problem;
  const OtfTable h = problem.sensors->otf(solved.condition, along(solved.angle_rad, f_cy_px));
  std::vector<Functional> all;
  for (std::size_t k = 0; k < f_cy_px.size(); ++k) {
    const auto [re, im] = h[0][k];
    const double size = std::hypot(re, im);
    Functional m{size, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.variables.size()))};
    for (std::size_t i = 0; i < problem.variables.size(); ++i) {
      const auto [d_re, d_im] = h[1 + i][k];
      const double slope = size > 1e-12 ? (re * d_re + im * d_im) / size : std::hypot(d_re, d_im);
      m.gradient[static_cast<Eigen::Index>(i)] = slope * problem.variables[i].slope(problem.x[i]);
    }
    all.push_back(std::move(m));
  }
  return all;
}

// |H| at a few small frequencies, and the second coefficient of the polynomial through them and 1 at f = 0.
Functional equivalent_variance(const Solved& solved, int nodes) {
  // As far as the modulus has fallen to 0.9.
  const Sensors& sensors = *solved.problem->sensors;
  double top = 0.25 * sensors.top_cy_px(solved.condition, solved.angle_rad);
  const auto modulus = [&](double f) {
    return sensors.modulus(solved.condition, along(solved.angle_rad, {&f, 1})).front();
  };
  while (top > 1e-6 && modulus(top) < 0.9) top *= 0.8;
  std::vector<double> f;
  Eigen::MatrixXd powers(nodes, nodes);
  for (int k = 0; k < nodes; ++k) {
    f.push_back(top * 0.5 * (1.0 - std::cos(std::numbers::pi * (k + 1.0) / nodes)));
    for (int p = 0; p < nodes; ++p) powers(k, p) = std::pow(f.back() / top, p + 1);
  }
  const Eigen::VectorXd weight = solution_of(powers.transpose(), Eigen::VectorXd::Unit(nodes, 1));
  const std::vector<Functional> h = mtf_of(solved, f);
  const double scale = -2.0 / (4.0 * std::numbers::pi * std::numbers::pi * top * top);
  Functional v{0.0, Eigen::VectorXd::Zero(h[0].gradient.size())};
  for (int k = 0; k < nodes; ++k) {
    v.value += scale * weight[k] * (h[static_cast<std::size_t>(k)].value - 1.0);
    v.gradient += scale * weight[k] * h[static_cast<std::size_t>(k)].gradient;
  }
  return v;
}

std::vector<FittedParameter> fitted_parameters(const Solved& solved, std::span<const FitParameter> parameters,
                                               std::span<const double> start) {
  const FitProblem& problem = *solved.problem;
  std::vector<FittedParameter> all;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Variable& v = problem.variables[i];
    const auto index = static_cast<Eigen::Index>(i);
    const double x = problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
    FittedParameter p{.parameter = parameters[i], .start = start[i]};
    double gradient = 0.0;
    for (std::size_t b = 0; b < solved.normals.size(); ++b) {
      const Eigen::MatrixXd& normal = solved.normals[b];
      gradient += normal(static_cast<Eigen::Index>(problem.own[b].size()) + index, normal.cols() - 1) /
                  trusted_noise(solved.noise_factor[b]);
    }
    if (problem.priors[i]) {
      const auto [mean, width] = *problem.priors[i];
      gradient += (v.value(x) - mean) / (width * width) * v.slope(x);
    }
    // Shared noise makes the profile lower by the ratio of the variances (J. T. Kent, Biometrika 69, 19 (1982)).
    set_knowledge(p, v, x, sd, solved.identified.determined[i], problem.priors[i], gradient / solved.variance_ratio[i]);
    all.push_back(std::move(p));
  }
  return all;
}

double allowed_rise(double z, double from_bound_sd) {
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  if (from_bound_sd >= z) return z;
  const double wanted = 2.0 * below(z) - 1.0, mu = std::max(from_bound_sd, 1e-9);
  double lo = 0.0, hi = z;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (lo + hi);
    // Estimates of mu beyond the bound are at it: the rise from there is mu^2 - 2 mu x.
    (below(t) - below(-0.5 * (mu + t * t / mu)) < wanted ? lo : hi) = t;
  }
  return 0.5 * (lo + hi);
}

void set_knowledge(FittedParameter& p, const Variable& v, double x, double sd, bool determined,
                   const std::optional<std::array<double, 2>>& prior, double gradient) {
  const bool near_lo = x - v.lo < sd, near_hi = v.hi - x < sd;
  const auto value = [&](double at) { return v.squared && at <= 1e-8 ? 0.0 : v.value(at); };
  p.value = value(x);
  p.linear_sd = std::abs(sd * v.slope(x));
  if (!determined) {
    p.knowledge = Knowledge::not_determined;
  } else if (prior && p.linear_sd > 0.9 * (*prior)[1]) {
    p.knowledge = Knowledge::prior_only;
    p.stderr_value = p.linear_sd;
  } else if (near_lo || near_hi) {
    p.knowledge = Knowledge::at_bound;
    p.pressed_sd = std::max(0.0, near_lo ? gradient : -gradient) * sd;  // the minimum may press against the bound
    double lo = 0.0, hi = k95_sd;
    for (int i = 0; i < 60; ++i) {
      const double t = 0.5 * (lo + hi);
      (std::sqrt(t * (t + 2.0 * p.pressed_sd)) < allowed_rise(k95_sd, t) ? lo : hi) = t;
    }
    const double distance = 0.5 * (lo + hi) * sd;
    p.value = value(near_lo ? v.lo : v.hi);
    p.limit95 = v.value(near_lo ? std::min(v.hi, x + distance) : std::max(v.lo, x - distance));
    p.limit_is_upper = *p.limit95 > p.value;
  } else {
    p.knowledge = Knowledge::determined;
    p.stderr_value = p.linear_sd;
  }
}

std::vector<std::vector<double>> correlations_of(const Eigen::MatrixXd& c) {
  const auto n = static_cast<std::size_t>(c.rows());
  std::vector<std::vector<double>> all(n, std::vector<double>(n, std::numeric_limits<double>::quiet_NaN()));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      if (!(c(a, a) < kUnseen && c(b, b) < kUnseen)) continue;
      all[i][j] = i == j ? 1.0 : c(a, b) / std::sqrt(c(a, a) * c(b, b));
    }
  return all;
}

std::vector<std::vector<double>> correlations(const Solved& solved) {
  std::vector<std::vector<double>> all = correlations_of(solved.identified.covariance);
  const std::vector<Variable>& v = solved.problem->variables;
  // A value may fall as its variable rises.
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < all.size(); ++j)
      if (i != j) all[i][j] *= v[i].sign * v[j].sign;
  return all;
}

std::string weak_direction_text(std::span<const std::string> names, const WeakWords& words) {
  if (names.size() == 1)
    return names.front() + " is not determined: the data hardly depend on it; " + words.single_advice;
  return mtf::listed(names) + " are not separable from " + words.from + ": only " + words.known + "; " + words.advice;
}

std::vector<NullDirection> null_directions(FitProblem& problem, const Solved& solved,
                                           std::span<const FitParameter> parameters) {
  std::vector<NullDirection> all;
  if (solved.identified.weak.empty()) return all;
  // More of the same helps a little; an edge across is worth advising only where it does what that does not.
  const Identified with_across =
      identify(solved.information.matrix + one_more(solved, 0.5 * std::numbers::pi), solved.reference);
  const Identified with_same = identify(solved.information.matrix + one_more(solved, 0.0), solved.reference);
  const bool single = one_direction(solved.normals_rad);
  for (const WeakDirection& weak : solved.identified.weak) {
    const auto lead = static_cast<Eigen::Index>(weak.members.front());
    const bool helped = single && !solved.normals_rad.empty() &&
                        std::ranges::all_of(weak.members, [&](std::size_t i) { return with_across.determined[i]; }) &&
                        with_across.covariance(lead, lead) < 0.25 * with_same.covariance(lead, lead);
    std::vector<std::string> names;
    for (const std::size_t i : weak.members)
      names.push_back(parameters[i].name.empty() ? parameters[i].path : parameters[i].name);
    WeakWords words{.from = solved.normals_rad.empty()       ? "these data"
                            : solved.normals_rad.size() == 1 ? "one edge"
                            : single                         ? "edges of one direction"
                                                             : "these edges"};
    if (helped) words.advice = words.single_advice = "add an edge across";
    if (names.size() > 1)
      if (const auto moment = combined_moment(problem, solved, weak.members))
        words.known = "their combined second moment is known (" + mtf::significant(moment->value, 3) + " +- " +
                      mtf::significant(moment->sd, 2) + " px^2)";
    std::string text = weak_direction_text(names, words);
    all.push_back({weak.members, weak.weight, std::move(text)});
  }
  return all;
}

}  // namespace calib
