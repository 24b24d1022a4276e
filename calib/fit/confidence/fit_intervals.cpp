// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/fit_intervals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "calib/dense.h"
#include "calib/fit/confidence/flat_points.h"
#include "mtf/units.h"

namespace calib {
namespace {

// Profile likelihood: how far a parameter can move, everything else fitted anew, until chi-square has risen by
// a quantile (allowed_rise). It holds also where the likelihood is not a parabola, and costs a few fits per end.

/// Fits with variable i held. `cost` and `noise_factor`: as for profile().
struct Profiler {
  FitProblem& problem;
  std::size_t i;
  double cost, noise_factor;
  std::span<const FlatPoint> flat;
  const std::function<bool()>& go_on;
  bool stopped = false;

  /// The root of the rise of chi-square at x, in sd of the noise: nearly linear in x. The problem is at that fit then,
  /// and the next one begins there.
  double at(double x) {
    for (const FlatPoint& point : flat) problem.x[point.parameter] = point.off_point(problem.x[point.parameter]);
    problem.x[i] = x;
    // To a hundredth of a standard deviation.
    constexpr double kCost = 1e-3;
    const Solution solution =
        solve(problem, {.fixed = i, .go_on = go_on, .tolerance = std::clamp(kCost / cost, 1e-10, 1e-6)});
    stopped = stopped || solution.stopped;
    return std::sqrt(std::max(0.0, 2.0 * (solution.cost - cost) / noise_factor));
  }
};

/// Ends of intervals, in x; a bound where chi-square does not rise that far.
struct XEnds {
  std::array<double, 2> x68{}, x95{};
};

/// x in the direction of `side` at which the root of the rise is that of `z` sd.
double end_of(Profiler& profiler, double from, double sd, double side, double z) {
  const Variable& v = profiler.problem.variables[profiler.i];
  const double bound = side > 0.0 ? v.hi : v.lo;
  const auto excess = [&](double x) { return profiler.at(x) - allowed_rise(z, std::min(x - v.lo, v.hi - x) / sd); };
  double low = from, low_value = -z, step = std::max(1e-12, sd * z);
  for (int grow = 0; grow < 40 && !profiler.stopped; ++grow) {
    const double high = side > 0.0 ? std::min(bound, low + step) : std::max(bound, low - step);
    const double high_value = excess(high);
    if (high_value < 0.0) {
      if (high == bound) return bound;
      low = high, low_value = high_value, step *= 1.5;
      continue;
    }
    // The root is nearly linear: false position, halved where it stalls.
    double a = low, fa = low_value, b = high, fb = high_value;
    for (int refine = 0; refine < 12 && !profiler.stopped; ++refine) {
      double x = b - fb * (b - a) / (fb - fa);
      if (refine % 4 == 3) x = 0.5 * (a + b);
      const double fx = excess(x);
      if (std::abs(fx) < 1e-3 * z) return x;
      (fx < 0.0 ? a : b) = x;
      (fx < 0.0 ? fa : fb) = fx;
    }
    return 0.5 * (a + b);
  }
  return bound;
}

/// The profile of variable i around the minimum, at which the problem is before and after. `sd`: of x. `noise_factor`:
/// chi-square per degree of freedom, times the ratio of the variance to that with independent pixels (J. T. Kent,
/// Biometrika 69, 19 (1982)), by which rises are divided. Refits begin away from the `flat` points, which the minimiser
/// would not leave. The result is empty when the fit was stopped.
std::optional<XEnds> profile(FitProblem& problem, std::size_t i, double sd, double cost, double noise_factor,
                             std::span<const FlatPoint> flat, const std::function<bool()>& go_on) {
  const FitPoint minimum = problem.here();
  Profiler profiler{problem, i, cost, noise_factor, flat, go_on};
  const auto end = [&](double side, double z) {
    problem.go_to(minimum);
    return end_of(profiler, minimum.x[i], sd, side, z);
  };
  const XEnds ends{{end(-1.0, 1.0), end(1.0, 1.0)}, {end(-1.0, k95_sd), end(1.0, k95_sd)}};
  problem.go_to(minimum);
  return profiler.stopped ? std::nullopt : std::optional(ends);
}

// The 95 % interval of a parameter about a flat point (flat_points.h), where chi-square is no parabola. Where the
// effect is mirrored, the interval may be two parts, one for each sign, or hold the centre.
//
// A value belongs to it where chi-square, the other parameters fitted anew, rises by no more than it does in 95 % of
// images of a sensor with that value. By how much that is depends on how the model bends: 2.7 at a point beyond which
// nothing differs, 3.84 where the effect is in proportion, up to 5 where two signs are half told apart. (Feldman and
// Cousins, Phys. Rev. D 57, 3873 (1998).) The images are those of the model itself: the residuals r(u) of fits with the
// parameter held at u, which differ by what the data see of the parameter, r(u) - r(w), however much noise they have.
// These differences span few dimensions, in which noise is drawn.

/// Parts of the range of x, in rising order, with the x of the least chi-square in each.
struct IntervalPart {
  double low = 0.0, high = 0.0, best = 0.0;
  double rise = 0.0;  ///< of chi-square there, above the minimum
};
struct FlatInterval {
  std::vector<IntervalPart> parts68, parts95;
};

constexpr double kFar_sd = 4.0;        // root of the rise as far as which values are tried
constexpr int kNodesToASide = 10;      // of values
constexpr int kBetween = 8;            // parts of the way between two of them
constexpr int kDraws = 4000;           // a 95 % point that holds in 94.3 to 95.7 %
constexpr std::size_t kPixels = 4000;  // of an edge, in the differences of residuals
constexpr double kSmall_sd = 0.02;     // of a dimension that does not matter

/// Residuals at the present values, in sd of the noise, scaled to stand for all pixels.
Eigen::VectorXd residuals(const FitProblem& problem, double noise_factor) {
  std::vector<double> all;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
    const std::size_t every = edge != nullptr ? edge->every_for(kPixels) : 1;
    const double scale = std::sqrt(static_cast<double>(every) / noise_factor);
    for (const Residual& r : problem.residuals(b, every)) all.push_back(scale * r.value);
  }
  for (std::size_t i = 0; i < problem.priors.size(); ++i)
    if (const auto& prior = problem.priors[i])
      all.push_back((problem.variables[i].value(problem.x[i]) - (*prior)[0]) / (*prior)[1]);
  return Eigen::Map<const Eigen::VectorXd>(all.data(), std::ssize(all));
}

/// A value that was tried.
struct Node {
  double x = 0.0, rise = 0.0;
  Eigen::VectorXd residuals;
};

/// Places of the nodes in the few dimensions that they span, one a row.
Eigen::MatrixXd places(std::span<const Node> nodes) {
  const Eigen::Index n = std::ssize(nodes), size = nodes.front().residuals.size();
  Eigen::MatrixXd all(n, size);
  for (Eigen::Index k = 0; k < n; ++k)
    all.row(k) = (nodes[static_cast<std::size_t>(k)].residuals - nodes.front().residuals);
  const auto [values, vectors] = eigenpairs(all * all.transpose());
  Eigen::Index kept = 1;
  while (kept < n && values[n - 1 - kept] > kSmall_sd * kSmall_sd) ++kept;
  return vectors.rightCols(kept) * values.tail(kept).cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// The curve that the nodes are on, finer, and some way beyond its open ends.
Eigen::MatrixXd fine_curve(const Eigen::MatrixXd& place, bool low_open, bool high_open) {
  constexpr int kBeyond = 16;
  constexpr double kStep_sd = 0.25;
  std::vector<Eigen::RowVectorXd> all;
  const auto beyond = [&](Eigen::Index end, Eigen::Index before) {
    const Eigen::RowVectorXd along = (place.row(end) - place.row(before)).normalized();
    for (int k = 1; k <= kBeyond; ++k) all.push_back(place.row(end) + k * kStep_sd * along);
  };
  const Eigen::Index last = place.rows() - 1;
  if (low_open) beyond(0, 1);
  for (Eigen::Index k = 0; k < last; ++k)
    for (int part = 0; part < kBetween; ++part)
      all.push_back(place.row(k) + (place.row(k + 1) - place.row(k)) * part / kBetween);
  all.push_back(place.row(last));
  if (high_open) beyond(last, last - 1);
  Eigen::MatrixXd curve(std::ssize(all), place.cols());
  for (Eigen::Index k = 0; k < curve.rows(); ++k) curve.row(k) = all[static_cast<std::size_t>(k)];
  return curve;
}

/// The rises that stay below in 68 and in 95 % of draws of noise about a place: noise e has the rise |e|^2 less the
/// least |e + place - c|^2 over the curve.
std::array<double, 2> allowed(const Eigen::RowVectorXd& place, const Eigen::MatrixXd& curve,
                              const Eigen::MatrixXd& noise) {
  const Eigen::MatrixXd to = curve.rowwise() - place;
  const Eigen::VectorXd squares = to.rowwise().squaredNorm();
  std::vector<double> rises;
  for (Eigen::Index k = 0; k < noise.rows(); ++k)
    rises.push_back(std::max(0.0, (2.0 * (to * noise.row(k).transpose()) - squares).maxCoeff()));
  std::array<double, 2> all{};
  for (const std::size_t which : {0U, 1U}) {
    const double share = which == 0 ? 0.682689492137086 : 0.95;
    const auto at = rises.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(rises.size()));
    std::nth_element(rises.begin(), at, rises.end());
    all[which] = *at;
  }
  return all;
}

/// The parts of the range in which `excess`, of the nodes, is below 0.
std::vector<IntervalPart> parts_of(std::span<const Node> nodes, std::span<const double> excess) {
  std::vector<IntervalPart> parts;
  const auto crossing = [&](std::size_t k) {  // between k and k + 1
    const double part = excess[k] / (excess[k] - excess[k + 1]);
    return nodes[k].x + part * (nodes[k + 1].x - nodes[k].x);
  };
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (!(excess[k] <= 0.0)) continue;
    const bool begins = k == 0 || excess[k - 1] > 0.0;
    if (begins) parts.push_back({k == 0 ? nodes[k].x : crossing(k - 1), nodes[k].x, nodes[k].x, nodes[k].rise});
    IntervalPart& part = parts.back();
    part.high = k + 1 < nodes.size() && excess[k + 1] > 0.0 ? crossing(k) : nodes[k].x;
    if (nodes[k].rise < part.rise) part.best = nodes[k].x, part.rise = nodes[k].rise;
  }
  return parts;
}

/// `cost` at the minimum, at which the problem is before and after; `noise_factor` as for profile(). The other `flat`
/// points are left by every fit. Values are tried from the minimum and from each of the `mirrors`, and the lower
/// chi-square counts: a partner may have a valley of its own for each, as the spherical aberration beside a defocus.
/// Empty when the fit was stopped.
std::optional<FlatInterval> flat_interval(FitProblem& problem, const FlatPoint& point, double first_step, double cost,
                                          double noise_factor, std::span<const FlatPoint> flat,
                                          std::span<const Mirror> mirrors, const std::function<bool()>& go_on) {
  const std::size_t i = point.parameter;
  const Variable& v = problem.variables[i];
  std::vector<Mirror> minima{{problem.here(), 0.0}};
  minima.insert(minima.end(), mirrors.begin(), mirrors.end());
  Profiler profiler{problem, i, cost, noise_factor, flat, go_on};
  // How far from the point values need to be tried, on either side.
  double far = point.off;
  for (const Mirror& minimum : minima) far = std::max(far, std::abs(minimum.x[i] - point.at));
  const double farthest = v.period > 0.0 ? 0.5 * v.period / v.step : v.hi - v.lo;
  const auto too_near = [&](double side) {
    const double x = point.at + side * far;
    return far < farthest && x > v.lo && x < v.hi && profiler.at(x) < kFar_sd;
  };
  for (const Mirror& minimum : minima)
    for (const double side : {point.side, -point.side}) {
      if (side != point.side && !point.inside) continue;
      problem.go_to(minimum);
      for (double step = first_step; too_near(side) && !profiler.stopped; step *= 1.5) far += step;
    }
  // The minima and what is opposite are among the values, as the root of the rise has its kinks there.
  std::vector<double> x;
  for (const Mirror& minimum : minima) {
    x.push_back(minimum.x[i]);
    if (point.inside) x.push_back(2.0 * point.at - minimum.x[i]);
  }
  for (int k = point.inside ? -kNodesToASide : 0; k <= kNodesToASide; ++k)
    x.push_back(point.at + point.side * far * k / kNodesToASide);
  for (double& value : x) value = std::clamp(value, v.lo, v.hi);
  std::ranges::sort(x);
  std::vector<Node> nodes;
  for (const double value : x)
    if (nodes.empty() || value - nodes.back().x > 0.01 * far / kNodesToASide) nodes.push_back({value, INFINITY, {}});
  const auto try_value = [&](Node& node) {
    const double root = profiler.at(node.x);
    if (!(root * root < node.rise)) return;
    node.rise = root * root;
    node.residuals = residuals(problem, noise_factor);
  };
  // From the one next to a minimum to either end, each fit beginning where its neighbour ended.
  for (const Mirror& minimum : minima) {
    const auto nearest = std::ranges::min_element(nodes, [&](const Node& a, const Node& b) {
      return std::abs(a.x - minimum.x[i]) < std::abs(b.x - minimum.x[i]);
    });
    problem.go_to(minimum);
    for (auto node = nearest; node != nodes.end() && !profiler.stopped; ++node) try_value(*node);
    problem.go_to(minimum);
    for (auto node = nearest; node != nodes.begin() && !profiler.stopped;) try_value(*--node);
  }
  problem.go_to(minima.front());
  if (profiler.stopped) return std::nullopt;
  // Values that the model refuses end the range.
  std::erase_if(nodes, [](const Node& node) { return !std::isfinite(node.rise); });
  if (nodes.size() < 3) return std::nullopt;

  const Eigen::MatrixXd place = places(nodes);
  const Eigen::MatrixXd curve = fine_curve(place, nodes.front().x > v.lo, nodes.back().x < v.hi);
  Eigen::MatrixXd noise(kDraws, place.cols());
  std::mt19937_64 bits(1);
  std::normal_distribution<double> normal;
  for (Eigen::Index k = 0; k < noise.size(); ++k) noise.data()[k] = normal(bits);
  std::array<std::vector<double>, 2> excess;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    constexpr double kWithin = 0.2, kBeyond = 16.0;  // rises that no value is left out for, or in
    const bool needed = nodes[k].rise > kWithin && nodes[k].rise < kBeyond;
    const std::array<double, 2> most =
        needed ? allowed(place.row(static_cast<Eigen::Index>(k)), curve, noise) : std::array{1.0, 3.84};
    for (const std::size_t which : {0U, 1U}) excess[which].push_back(std::sqrt(nodes[k].rise) - std::sqrt(most[which]));
  }
  return FlatInterval{parts_of(nodes, excess[0]), parts_of(nodes, excess[1])};
}

constexpr double kLikeNormal = 0.1;  // of a half interval: to within this the standard error agrees with it
constexpr double kOwnSd = 3.0;       // a first step of the profile, in sd of the parameter with the others fixed

const FlatPoint* flat_of(std::size_t i, std::span<const FlatPoint> flat) {
  const auto point = std::ranges::find_if(flat, [&](const FlatPoint& f) { return f.parameter == i; });
  return point == flat.end() ? nullptr : &*point;
}

/// sd of x to begin the profile with. About a flat point the covariance may be of any size.
double first_step(const Solved& solved, std::size_t i, std::span<const FlatPoint> flat) {
  const auto index = static_cast<Eigen::Index>(i);
  const double sd = std::sqrt(solved.identified.covariance(index, index));
  if (flat.empty()) return sd;
  const double own = std::min(sd, kOwnSd / std::sqrt(solved.information.matrix(index, index)));
  const FlatPoint* const point = flat_of(i, flat);
  return point == nullptr ? own : std::min(own, point->off);
}

/// Ends of intervals, in values. Open: that of `interval95` is a bound up to which chi-square does not rise enough.
struct Ends {
  std::array<double, 2> interval68{}, interval95{};
  bool low_open = false, high_open = false;
};

/// `at`: the x of the fit, from which a direction is counted on beyond its half turn.
Ends ends_of(const XEnds& x, const Variable& v, double at) {
  const auto value = [&](double to) {
    if (v.period > 0.0) return v.value(at) + v.step * (to - at);
    return v.squared ? v.sign * v.step * std::sqrt(std::max(0.0, to)) : v.value(to);
  };
  bool from_low = x.x95[0] <= v.lo, from_high = x.x95[1] >= v.hi;
  const bool from_zero = v.squared && v.lo == 0.0 && from_low;
  // Of the values on both sides of 0, those of the other one have the same square.
  const auto both = [&](const std::array<double, 2>& to) {
    double a = value(to[0]), b = value(to[1]);
    if (v.other_side > 0.0 && to[0] <= 0.0) a = -v.sign * std::min(std::abs(b), v.other_side);
    return std::array{std::min(a, b), std::max(a, b)};
  };
  Ends ends{both(x.x68), both(x.x95)};
  if (from_zero) from_low = v.other_side > 0.0 && std::abs(value(x.x95[1])) >= v.other_side;
  const bool rises = v.sign > 0.0;
  ends.low_open = rises ? from_low : from_high;
  ends.high_open = rises ? from_high : from_low;
  return ends;
}

ProfiledInterval interval_of(const Ends& ends, const Variable& v, const FitParameter& parameter) {
  const auto open = [&](const char* side, double bound) {
    return "the data do not bound it from " + std::string(side) + ": chi-square rises too little up to the bound of " +
           mtf::format_double(bound) + (parameter.unit.empty() ? "" : " " + parameter.unit);
  };
  ProfiledInterval interval{ends.interval95[0], ends.interval95[1], ""};
  const bool size_from_zero = v.positive && !(parameter.min && *parameter.min > 0.0);
  if (ends.low_open && !(size_from_zero && ends.interval95[0] >= 0.0)) {
    interval.low.reset();
    interval.reason = open("below", ends.interval95[0]);
  }
  if (ends.high_open) {
    interval.high.reset();
    interval.reason += (interval.reason.empty() ? "" : "; ") + open("above", ends.interval95[1]);
  }
  return interval;
}

void set_intervals(FittedParameter& p, const Ends& ends, const Variable& v) {
  p.interval68 = ends.interval68;
  p.interval95 = ends.interval95;
  p.interval = interval_of(ends, v, p.parameter);
}

bool same_as(const std::array<double, 2>& interval, double value, double half) {
  return std::abs(interval[0] - (value - half)) < kLikeNormal * half &&
         std::abs(interval[1] - (value + half)) < kLikeNormal * half;
}

/// The interval of a square by its standard deviation, near its bound as allowed_rise.
XEnds ends_of_square(const Variable& v, double x, double sd) {
  const double away_sd = (x - v.lo) / sd;
  const auto within = [&](double z) {
    double lo = 0.0, hi = away_sd;
    if (away_sd > allowed_rise(z, 0.0))
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (lo + hi);
        (away_sd - middle > allowed_rise(z, middle) ? lo : hi) = middle;
      }
    return std::array{v.lo + lo * sd, std::min(v.hi, x + z * sd)};
  };
  return {within(1.0), within(k95_sd)};
}

/// First derivatives tell nothing of the correlation at a flat point, and at a square that may have either sign.
void forget_correlation(std::size_t i, FitResult& result) {
  for (std::size_t k = 0; k < result.correlation.size(); ++k)
    result.correlation[i][k] = result.correlation[k][i] = std::numeric_limits<double>::quiet_NaN();
}

/// The interval about a flat point: the part that the minimum is in, the others as `others` of the parameter. Nothing
/// where the values tried are too far apart for it.
std::optional<XEnds> split(const FlatInterval& found, const Variable& v, double x, FittedParameter& p) {
  const auto own = [&](const std::vector<IntervalPart>& parts) {
    return std::ranges::find_if(parts, [&](auto& part) { return part.low <= x && x <= part.high; });
  };
  const auto most = own(found.parts68), all = own(found.parts95);
  if (most == found.parts68.end() || all == found.parts95.end()) return std::nullopt;
  for (auto part = found.parts95.begin(); part != found.parts95.end(); ++part) {
    if (part == all) continue;
    const Ends ends = ends_of({{}, {part->low, part->high}}, v, x);
    p.others.push_back({v.value(part->best), std::nullopt, ends.interval95, part->rise});
  }
  return XEnds{{most->low, most->high}, {all->low, all->high}};
}

/// The verdict on a parameter whose interval comes from the likelihood, a flat point being near to it or to a partner.
void judge_by_likelihood(FittedParameter& p, const Variable& v, double best, bool normal, const FlatPoint* own,
                         const Ends& ends) {
  if (own != nullptr && own->here && !own->inside && v.other_side == 0.0) {
    const bool from_low = own->side > 0.0;
    const bool has_limit = from_low ? !ends.high_open : !ends.low_open;
    p.knowledge = has_limit ? Knowledge::at_bound : Knowledge::not_determined;
    p.limit95 = has_limit ? std::optional(ends.interval95[from_low ? 1 : 0]) : std::nullopt;
    p.limit_is_upper = from_low;
    p.value = v.squared && own->at <= 1e-8 ? 0.0 : v.value(own->at);
    p.stderr_value.reset();
    p.pressed_sd = 0.0;
    return;
  }
  const bool held = p.knowledge == Knowledge::at_bound;
  const bool still_held = held && own == nullptr && (p.limit_is_upper ? ends.low_open : ends.high_open);
  const bool about_centre = own != nullptr && (own->inside || v.other_side > 0.0) && !(ends.low_open && ends.high_open);
  if ((held && !still_held) || (p.knowledge == Knowledge::determined && !normal) ||
      (about_centre && p.knowledge != Knowledge::determined)) {
    p.knowledge = Knowledge::interval;
    p.value = best;
    p.stderr_value.reset();
    p.limit95.reset();
    p.pressed_sd = 0.0;
  }
  if (!p.others.empty()) p.knowledge = Knowledge::ambiguous;
}

}  // namespace

double rise_at(FitProblem& problem, std::size_t i, double x, double cost, double noise_factor,
               std::span<const FlatPoint> flat, const std::function<bool()>& go_on, std::vector<double>* all) {
  const FitPoint minimum = problem.here();
  Profiler profiler{problem, i, cost, noise_factor, flat, go_on};
  const double rise = profiler.at(x);
  if (all != nullptr) *all = problem.x;
  problem.go_to(minimum);
  return rise;
}

bool leave_flat_points(FitProblem& problem, Solved& solved, std::span<const FlatPoint> flat, Solution& solution,
                       const MinimiseOptions& options) {
  constexpr double kLower = 0.005;  // half of chi-square: minima within a tenth of a standard deviation are the same
  if (std::ranges::none_of(flat, [](const FlatPoint& f) { return f.here; })) return false;
  const FitPoint before = problem.here();
  for (const FlatPoint& f : flat) problem.x[f.parameter] = f.off_point(problem.x[f.parameter]);
  Solution again = solve(problem, {.go_on = options.go_on});
  solution.stopped = solution.stopped || again.stopped;
  if (!again.converged || !(again.cost < solution.cost - kLower)) {
    problem.go_to(before);
    return false;
  }
  again.iterations += solution.iterations;
  again.agreeing = 1;
  solution = finish(problem, solved, again, options);
  return true;
}

std::vector<BentSquare> report_squares(FitProblem& problem, const Solved& solved, double cost,
                                       const std::function<bool()>& go_on, FitResult& result) {
  const double factor = noise_factor_of(problem, solved);
  std::vector<BentSquare> bent;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    FittedParameter& p = result.parameters[i];
    const Variable& v = problem.variables[i];
    if (!v.squared || (p.knowledge != Knowledge::determined && p.knowledge != Knowledge::at_bound)) continue;
    const auto index = static_cast<Eigen::Index>(i);
    const double x = problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
    XEnds to = ends_of_square(v, x, sd);
    const bool holds_bound = to.x95[0] <= v.lo, determined = p.knowledge == Knowledge::determined;
    const Ends ends = ends_of(to, v, x);
    if (determined && (holds_bound || !same_as(ends.interval95, p.value, k95_sd * *p.stderr_value)))
      set_intervals(p, ends, v);
    if (!holds_bound) continue;
    const double far = std::min(v.hi, p.limit95 ? v.x_of(*p.limit95) : to.x95[1]);
    if (v.other_side > 0.0) forget_correlation(i, result);
    if (determined) {
      p.knowledge = Knowledge::interval;
      p.stderr_value.reset();
    } else if (v.other_side > 0.0 && v.lo == 0.0) {  // 0 is no bound of the parameter
      to.x95[1] = far;
      set_intervals(p, ends_of(to, v, x), v);
      p.knowledge = Knowledge::interval;
      p.value = v.sign * v.step * std::sqrt(std::max(0.0, x));
      p.limit95.reset();
    }
    BentSquare held;
    const double rise = rise_at(problem, i, far, cost, factor * solved.variance_ratio[i], {}, go_on, &held.x);
    if (!(std::abs(rise - k95_sd) <= kLikeNormal * k95_sd)) bent.push_back(std::move(held));
  }
  return bent;
}

void report_intervals(FitProblem& problem, const Solved& solved, std::span<const FlatPoint> flat,
                      std::span<const BentSquare> bent, bool all, double cost, std::span<const Mirror> mirrors,
                      const std::function<bool()>& go_on, FitResult& result) {
  const double factor = noise_factor_of(problem, solved);
  const bool judge = !bent.empty() || !flat.empty();
  const auto is_moved = [&](std::size_t i, double sd) {  // or not known to stay
    return std::ranges::any_of(bent, [&](const BentSquare& square) {
      return !(std::abs(square.x[i] - problem.x[i]) <= kLikeNormal * k95_sd * sd);
    });
  };
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    FittedParameter& p = result.parameters[i];
    const Variable& v = problem.variables[i];
    const FlatPoint* const own = flat_of(i, flat);
    if (p.knowledge == Knowledge::not_determined && own == nullptr && (flat.empty() || v.period > 0.0)) continue;
    const auto index = static_cast<Eigen::Index>(i);
    const double x = problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
    if (!all && flat.empty() && !is_moved(i, sd)) continue;
    const double step = first_step(solved, i, flat), noise = factor * solved.variance_ratio[i];
    std::optional<XEnds> to;
    if (own != nullptr) {
      const auto found = flat_interval(problem, *own, step, cost, noise, flat, mirrors, go_on);
      if (!found) return;
      to = split(*found, v, x, p);
    }
    if (!to) to = profile(problem, i, step, cost, noise, flat, go_on);
    if (!to) return;
    const Ends ends = ends_of(*to, v, x);
    set_intervals(p, ends, v);
    if (p.limit95) p.limit95 = ends.interval95[p.limit_is_upper ? 1 : 0];
    if (judge) judge_by_likelihood(p, v, v.value(x), same_as(to->x95, x, k95_sd * sd), own, ends);
  }
  for (const FlatPoint& f : flat)
    if (f.here) forget_correlation(f.parameter, result);
  const auto known = [&](std::size_t i) { return result.parameters[i].knowledge != Knowledge::not_determined; };
  std::erase_if(result.not_separable,
                [&](const NullDirection& direction) { return std::ranges::all_of(direction.parameters, known); });
}

}  // namespace calib
