// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/fit_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>

#include "calib/dense.h"
#include "mtf/units.h"
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
  const SliceNodes nodes = problem.sensors->slice(edge->place(), angle, kRange_px);
  const StepResponse step(nodes, problem.sensors->otf(edge->place(), along(angle, nodes.f_cy_px)));
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

// Terms over the field need data all over it: the even ones of a wavefront grow with the distance from the optical axis
// and turn with the direction.

constexpr std::size_t kFewPlaces = 3;  // directions, distances

std::vector<mtf::FieldPoint<double>> places_of(const FitProblem& problem) {
  std::vector<mtf::FieldPoint<double>> all;
  for (const Block& block : problem.blocks)
    if (const auto q = problem.sensors->field_point(std::visit([](const auto& b) { return b.place(); }, block)))
      all.push_back(*q);
  return all;
}

/// Fitted terms of one number that at the places of the data are the same, or add up to nothing, as tilts along x and y
/// on a diagonal. What is seen there tells their sum; what else it seems to tell comes from the length of the edges.
std::vector<WeakDirection> confounded_terms(const FitProblem& problem, std::span<const FitParameter> parameters) {
  constexpr double kAlike = 1e-5, kPart = 0.1;
  const std::vector<mtf::FieldPoint<double>> places = places_of(problem);
  std::map<std::string, std::vector<std::pair<std::size_t, std::string>>> terms;  // by number: parameter, term
  for (std::size_t i = 0; i < parameters.size() && !places.empty(); ++i) {
    const std::string& path = parameters[i].path;
    const std::size_t dot = path.rfind('.');
    if (path.find('.') < dot && !parameters[i].prior) terms[path.substr(0, dot)].emplace_back(i, path.substr(dot + 1));
  }
  std::vector<WeakDirection> all;
  for (const auto& [number, members] : terms) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Ones(std::ssize(places), std::ssize(members));
    for (Eigen::Index k = 0; k < a.cols(); ++k) {
      const auto term = std::ranges::find(mtf::kFieldTerms, members[static_cast<std::size_t>(k)].second);
      for (Eigen::Index p = 0; p < a.rows() && term != mtf::kFieldTerms.end(); ++p)
        a(p, k) = mtf::field_terms(
            places[static_cast<std::size_t>(p)])[static_cast<std::size_t>(term - mtf::kFieldTerms.begin())];
      a.col(k) /= std::max(a.col(k).norm(), 1e-300);
    }
    const Eigenpairs pairs = eigenpairs(a.transpose() * a);
    for (Eigen::Index d = 0; d < pairs.values.size() && pairs.values[d] < kAlike; ++d) {
      WeakDirection weak;
      for (Eigen::Index k = 0; k < a.cols(); ++k)
        if (std::abs(pairs.vectors(k, d)) > kPart) {
          weak.members.push_back(members[static_cast<std::size_t>(k)].first);
          weak.weight.push_back(pairs.vectors(k, d));
        }
      all.push_back(std::move(weak));
    }
  }
  return all;
}

/// How many of the numbers lie as far apart from one another, round a period.
std::size_t number_apart(std::vector<double> numbers, double apart, double period) {
  std::ranges::sort(numbers);
  std::vector<double> kept;
  for (const double one : numbers)
    if (kept.empty() || (one - kept.back() >= apart && kept.front() + period - one >= apart)) kept.push_back(one);
  return kept.size();
}

/// Sets what a weak direction says where the data lie in too few directions from the axis, or at too few distances.
void say_where_data_lie(const FitProblem& problem, WeakWords& words) {
  constexpr double kApart_deg = 20.0, kApart = 0.15, kNear = 0.05;
  std::vector<double> direction_deg, distance;
  for (const auto& q : places_of(problem)) {
    distance.push_back(std::hypot(q.x, q.y));
    if (distance.back() > kNear) direction_deg.push_back(std::atan2(q.y, q.x) * kRadian_deg);
  }
  if (distance.empty()) return;
  const std::size_t directions = number_apart(std::move(direction_deg), kApart_deg, 360.0),
                    distances = number_apart(std::move(distance), kApart, std::numeric_limits<double>::infinity());
  if (directions >= kFewPlaces && distances >= kFewPlaces) return;
  words.from = "edges in " + std::to_string(directions) + " directions from the optical axis and at " +
               std::to_string(distances) + " distances from it";
  words.advice = words.single_advice = "take edges in 3 directions and at 3 distances at least";
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

mtf::Image residual_image(const Roi& roi, std::span<const Residual> residuals) {
  mtf::Image image(roi.width, roi.height);
  std::fill_n(image.data(), image.size(), std::numeric_limits<float>::quiet_NaN());
  for (const Residual& r : residuals) image.at(r.x - roi.x, r.y - roi.y) = static_cast<float>(r.value);
  return image;
}

void test_edge(const FitProblem& problem, std::size_t b, std::span<const Residual> residuals, double noise_factor,
               ResidualTests& tests) {
  constexpr double kTables = 0.1;  // chi-square per degree of freedom: residuals below are those of tables and rounding
  constexpr double kFlatWidths = 2.0, kFlat_px = 6.0;
  const EdgeBlock& edge = std::get<EdgeBlock>(problem.blocks[b]);
  const std::optional<Estimate>& fwhm_px = edge.data().start.fwhm_px;
  const double flat_px = fwhm_px ? kFlatWidths * fwhm_px->value : kFlat_px;
  const auto judge = [&](std::span<const Residual> some) {
    // The unknowns that change E: offset, plateaus and parameters.
    return judge_edge(some, 3 + problem.variables.size(), std::abs(problem.own[b][edge.contrast_index()]),
                      edge.data().quantum);
  };
  tests.image = residual_image(edge.data().roi, residuals);
  tests.adequacy = judge(residuals);
  IndependentResiduals some =
      independent({residuals.begin(), residuals.end()}, edge.curve(problem.own[b]).normal(), flat_px);
  if (some.spacing_px == 1) return;
  const double chi2 = tests.adequacy.chi2, outlier_share = tests.adequacy.outlier_share;
  tests.adequacy = judge(some.residuals);
  tests.adequacy.chi2 = chi2;
  tests.adequacy.outlier_share = outlier_share;
  const bool noise = noise_factor >= kTables && !edge.rounding_hides_noise();
  (noise ? tests.noise : tests.left_out) = std::move(some.noise);
}

/// One for each block. `noise_factor`: chi-square per degree of freedom of each.
std::vector<ResidualTests> test_residuals(const FitProblem& problem, std::span<const double> noise_factor) {
  std::vector<ResidualTests> all(problem.blocks.size());
  for (std::size_t b = 0; b < all.size(); ++b) {
    const Block& block = problem.blocks[b];
    const std::vector<Residual> residuals = problem.residuals(b);
    all[b].count = residuals.size();
    if (std::holds_alternative<EdgeBlock>(block))
      test_edge(problem, b, residuals, noise_factor[b], all[b]);
    else
      all[b].adequacy = judge_sequence(residuals);
    if (const auto* spot = std::get_if<SpotBlock>(&block)) all[b].image = residual_image(spot->roi(), residuals);
  }
  return all;
}

// Residuals set by set, and the verdict on the model.

constexpr double kNoiseDoubt = 1.5;  // residuals / noise
/// Residuals of curves and spots far below the noise that was given are those of tables and rounding.
constexpr double kBelowNoiseChi2 = 0.04;
/// Residuals this many times the noise are no noise, whatever their structure: the sd of a curve may be known to a
/// factor of two; the noise of a spot's own photons is estimated from few pixels.
constexpr double kCurveChi2 = 6.0, kSpotChi2 = 30.0;

/// Chi-square a degree of freedom that noise cannot explain.
bool beyond_noise(const Block& block, double chi2_per_dof, std::size_t count) {
  const double chance = 1.0 + 5.0 * std::sqrt(2.0 / static_cast<double>(std::max<std::size_t>(1, count)));
  if (std::holds_alternative<CurveBlock>(block)) return chi2_per_dof > std::max(kCurveChi2, chance);
  return std::holds_alternative<SpotBlock>(block) && chi2_per_dof > kSpotChi2;
}

/// sd of an edge's contrast, the shared variables as fitted.
double contrast_sd(const Solved& solved, std::size_t b, const EdgeBlock& edge) {
  const auto k = static_cast<Eigen::Index>(edge.contrast_index());
  const auto own = static_cast<Eigen::Index>(solved.problem->own[b].size());
  const Eigen::MatrixXd inverse = inverse_of(solved.normals[b].topLeftCorner(own, own));
  double variance = inverse(k, k);
  if (solved.scores[b].size() > 0) {
    const Eigen::MatrixXd sandwich = inverse * solved.scores[b].topLeftCorner(own, own) * inverse;
    variance = std::max(variance, sandwich(k, k));
  }
  return std::sqrt(std::max(0.0, variance * trusted_noise(solved.noise_factor[b])));
}

}  // namespace

std::string name_of(const FitParameter& parameter) { return parameter.name.empty() ? parameter.path : parameter.name; }

std::string rounded(double value) { return mtf::format_double(std::round(10.0 * value) / 10.0); }

std::vector<NoiseCorrelation> noise_of(std::span<const ResidualTests> tests) {
  std::vector<NoiseCorrelation> all;
  for (const ResidualTests& one : tests) all.push_back(one.noise);
  return all;
}

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
  for (const WeakDirection& weak : solved.confounded) {
    solved.identified.weak.push_back(weak);
    for (const std::size_t i : weak.members) solved.identified.determined[i] = false;
  }
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
  solved.confounded = confounded_terms(problem, parameters);
  identify(solved);
}

double sd_of(const Solved& solved, const Functional& functional) {
  const double variance = functional.gradient.dot(solved.identified.covariance * functional.gradient);
  return std::sqrt(std::max(0.0, variance));
}

std::vector<Functional> mtf_of(const Solved& solved, std::span<const double> f_cy_px) {
  const FitProblem& problem = *solved.problem;
  const OtfTable h = problem.sensors->otf(solved.place, along(solved.angle_rad, f_cy_px));
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
  double top = 0.25 * sensors.top_cy_px(solved.place, solved.angle_rad);
  const auto modulus = [&](double f) {
    return sensors.modulus(solved.place, along(solved.angle_rad, {&f, 1})).front();
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
    for (const std::size_t i : weak.members) names.push_back(name_of(parameters[i]));
    WeakWords words{.from = solved.normals_rad.empty()       ? "these data"
                            : solved.normals_rad.size() == 1 ? "one edge"
                            : single                         ? "edges of one direction"
                                                             : "these edges"};
    say_where_data_lie(problem, words);
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

void report_data(const FitData& data, std::span<const std::optional<std::size_t>> block_of, Solved& solved,
                 FitResult& result) {
  const FitProblem& problem = *solved.problem;
  double chi2 = 0.0, dof = -static_cast<double>(problem.variables.size());
  double least_p = 1.0;
  int tests = 0;
  std::optional<std::size_t> worst, far;
  for (std::size_t i = 0; i < block_of.size(); ++i) {
    FitResiduals& out = result.data.emplace_back();
    const std::size_t edges = data.edges.size(), curves = data.curves.size();
    out.name = i < edges            ? data.edges[i].name
               : i < edges + curves ? data.curves[i - edges].name
                                    : data.spots[i - edges - curves].name;
    if (!block_of[i]) continue;
    const std::size_t b = *block_of[i];
    ResidualTests& tested = solved.tests[b];
    const Adequacy& adequacy = tested.adequacy;
    if (!tested.noise.white())
      result.warnings.push_back(out.name +
                                ": noise is correlated between neighbouring pixels, as after demosaicing, denoising or "
                                "JPEG; the errors and intervals given include it");
    if (const double ratio = tested.left_out.sum(); ratio > 1.0)
      result.warnings.push_back(
          out.name +
          ": residuals are correlated between neighbouring pixels, but too small against rounding or the noise that is "
          "assumed to tell what noise they share; the errors given are those of independent pixels, and may be up to " +
          rounded(std::sqrt(ratio)) + " times too small");
    out.count = tested.count;
    const double scale = std::visit([](const auto& block) { return block.noise_scale(); }, problem.blocks[b]);
    out.chi2_per_dof = solved.noise_factor[b] * scale;
    out.outlier_share = adequacy.outlier_share;
    out.whiteness_p = adequacy.whiteness_p;
    chi2 += adequacy.chi2 * scale;
    dof += static_cast<double>(out.count - problem.own[b].size());
    double matters = 0.0;
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b])) {
      out.curve = edge->curve(problem.own[b]);
      out.gradients = edge->gradients();
      out.contrast = {problem.own[b][edge->contrast_index()], contrast_sd(solved, b, *edge)};
      matters = kStructureMatters * std::abs(out.contrast.value) / edge->middle_sd();
      if (!result.residual_otf.empty() && b == 0)
        result.residual_otf =
            residual_otf(adequacy, std::abs(out.contrast.value) / edge->middle_sd(), result.frequency_cy_px);
    }
    out.residual = std::move(tested.image);
    if (beyond_noise(problem.blocks[b], out.chi2_per_dof, out.count) &&
        (!far || out.chi2_per_dof > result.data[*far].chi2_per_dof))
      far = i;
    // What is given of each is what counts.
    const bool edge = std::holds_alternative<EdgeBlock>(problem.blocks[b]);
    if (out.whiteness_p < kWrongModel_p && (edge ? adequacy.structure < matters : out.chi2_per_dof < kBelowNoiseChi2))
      out.whiteness_p = 1.0;
    ++tests;
    if (out.whiteness_p < least_p) worst = i;
    least_p = std::min(least_p, out.whiteness_p);
  }
  result.chi2_per_dof = chi2 / std::max(1.0, dof);
  result.whiteness_p = std::min(1.0, least_p * tests);
  for (const FitResiduals& one : result.data)
    if (one.chi2_per_dof > kNoiseDoubt * kNoiseDoubt)
      result.warnings.push_back(one.name + ": the residuals are " + rounded(std::sqrt(one.chi2_per_dof)) +
                                " times the noise that is assumed; the errors are scaled to them");
  if (result.status == FitStatus::converged && far) {
    const FitResiduals& one = result.data[*far];
    const bool spot = *far >= data.edges.size() + data.curves.size();
    result.status = FitStatus::converged_model_wrong;
    result.reason =
        "the residuals of " + one.name + " are " + rounded(std::sqrt(one.chi2_per_dof)) +
        (spot ? " times the noise of its background: it is saturated, not alone, or the model has the wrong shape"
              : " times the standard deviation that was given: the model has the wrong shape, or the curve is that of "
                "another sensor");
    return;
  }
  if (result.status != FitStatus::converged || result.whiteness_p >= kWrongModel_p) return;
  result.status = FitStatus::converged_model_wrong;
  std::array<char, 16> p{};
  std::snprintf(p.data(), p.size(), "%.0e", result.whiteness_p);
  result.reason = "the residuals of " + result.data[*worst].name +
                  " have structure that noise does not explain (p = " + p.data() +
                  "): the model lacks something or has the wrong shape; the errors given are those of noise alone";
}

}  // namespace calib
