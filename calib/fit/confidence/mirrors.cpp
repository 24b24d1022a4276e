// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/mirrors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mtf/words.h"

namespace calib {
namespace {

constexpr double kDiffers_sd = 0.5;
constexpr double kNearZero_sd = 5.0;
constexpr std::size_t kFollowed = 4;       // of the changes that promise most
constexpr std::size_t kSomePixels = 2000;  // of an edge, to see where a change leads

/// Variables and their new values.
using Change = std::vector<std::pair<std::size_t, double>>;

double difference(const Variable& v, double a, double b) {
  const double period = v.period / v.step;
  return period > 0.0 ? std::remainder(a - b, period) : a - b;
}

std::vector<double> sd_of_x(const Solved& solved) {
  std::vector<double> all;
  for (Eigen::Index i = 0; i < solved.identified.covariance.rows(); ++i)
    all.push_back(std::sqrt(solved.identified.covariance(i, i)));
  return all;
}

bool differs(const FitProblem& problem, std::span<const double> sd, const std::vector<double>& a,
             const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(difference(problem.variables[i], a[i], b[i])) > kDiffers_sd * sd[i]) return true;
  return false;
}

/// C^T C of all blocks and the priors (dense.h), their own unknowns projected out.
Eigen::MatrixXd shared_normal(const FitProblem& problem) {
  const std::size_t n = problem.variables.size();
  const auto last = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(last + 1, last + 1);
  const std::vector<Eigen::MatrixXd> normals = problem.normals();
  for (std::size_t b = 0; b < normals.size(); ++b) sum += project_out(normals[b], problem.own[b].size(), n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    const Variable& v = problem.variables[i];
    const auto& prior = problem.priors[i];
    if (!prior) continue;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(last + 1);
    row[static_cast<Eigen::Index>(i)] = v.slope(problem.x[i]) / (*prior)[1];
    row[last] = (v.value(problem.x[i]) - (*prior)[0]) / (*prior)[1];
    sum += row * row.transpose();
  }
  return sum;
}

/// Chi-square that one step from the present values promises, all unknowns fitted.
double promised_chi2(const FitProblem& problem) {
  const Eigen::MatrixXd normal = shared_normal(problem);
  if (!normal.allFinite()) return std::numeric_limits<double>::infinity();
  const double left = triangular_factor(normal)(normal.rows() - 1, normal.rows() - 1);
  return left * left;
}

/// Two squares with each other's effect, by what they do where both are small.
Change exchanged(FitProblem& problem, std::size_t i, std::size_t k) {
  const std::vector<double> x = problem.x;
  problem.x[i] = problem.x[k] = 0.0;
  Change change{{i, x[k]}, {k, x[i]}};
  if (problem.apply()) {
    const Eigen::VectorXd information = shared_normal(problem).diagonal();
    const double ratio =
        std::sqrt(information[static_cast<Eigen::Index>(k)] / information[static_cast<Eigen::Index>(i)]);
    if (std::isfinite(ratio) && ratio > 0.0) change = {{i, ratio * x[k]}, {k, x[i] / ratio}};
  }
  problem.x = x;
  problem.apply();
  return change;
}

std::vector<Change> single_changes(SomeBlocks& some) {
  FitProblem& problem = some.problem;
  const std::vector<double> x = problem.x;
  std::vector<Change> all;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Variable& v = problem.variables[i];
    for (const double centre : possible_centres(some, i)) all.push_back({{i, 2.0 * centre - x[i]}});
    if (v.direction)
      for (const double turn_deg : {90.0, 180.0}) all.push_back({{i, x[i] + turn_deg / v.step}});
    for (std::size_t k = 0; k < i; ++k)
      if (v.squared && problem.variables[k].squared) all.push_back(exchanged(problem, i, k));
  }
  return all;
}

/// Variables whose signs may belong together: all that have one, and those of them that alone, the others being 0, act
/// by their square.
std::vector<std::vector<std::size_t>> sign_groups(FitProblem& problem) {
  constexpr double kSame = 1e-9;
  constexpr std::array kFrequencies{0.08, 0.17, 0.3};  // at which an edge sees what a sign does
  const std::vector<double> x = problem.x;
  std::vector<std::size_t> with_sign, even;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (problem.variables[i].has_sign()) with_sign.push_back(i), problem.x[i] = 0.0;
  const std::vector<double> none = problem.x;
  const auto response = [&](std::size_t i, double value) {
    problem.x = none;
    problem.x[i] = value;
    std::vector<mtf::Complex<double>> h;
    if (!problem.apply()) return h;
    for (const Block& block : problem.blocks)
      if (const auto* edge = std::get_if<EdgeBlock>(&block)) {
        const OtfTable table =
            problem.sensors->otf(edge->place(), along(edge->data().start.curve.angle_rad, kFrequencies));
        h.insert(h.end(), table[0].begin(), table[0].end());
      }
    return h;
  };
  for (const std::size_t i : with_sign.size() > 2 ? with_sign : std::vector<std::size_t>{}) {
    const auto up = response(i, std::abs(x[i])), down = response(i, -std::abs(x[i]));
    const auto same = [](const auto& a, const auto& b) { return std::hypot(a.re - b.re, a.im - b.im) < kSame; };
    if (!up.empty() && std::ranges::equal(up, down, same)) even.push_back(i);
  }
  problem.x = x;
  problem.apply();
  return {std::move(with_sign), std::move(even)};
}

std::vector<Change> changes(SomeBlocks& some) {
  std::vector<Change> all = single_changes(some);
  const std::size_t single = all.size();
  const auto of_others = [](const Change& a, const Change& b) {
    return std::ranges::none_of(a, [&](const auto& one) {
      return std::ranges::any_of(b, [&](const auto& other) { return one.first == other.first; });
    });
  };
  const auto told_apart = [&](const Change& change) {
    return std::ranges::any_of(change, [&](const auto& one) { return some.told_apart[one.first]; });
  };
  for (std::size_t i = 0; i < single; ++i)
    for (std::size_t k = 0; k < i; ++k) {
      if (told_apart(all[i]) || told_apart(all[k]) || !of_others(all[i], all[k])) continue;
      Change both = all[i];
      both.insert(both.end(), all[k].begin(), all[k].end());
      all.push_back(std::move(both));
    }
  for (const std::vector<std::size_t>& group : sign_groups(some.problem)) {
    Change signs;
    for (const std::size_t i : group) signs.emplace_back(i, -some.problem.x[i]);
    if (signs.size() > 2) all.push_back(std::move(signs));
  }
  return all;
}

/// Where the changes that promise most lead, by some of the data: minima about as low as the present one. Of many sets
/// of data those where the `simpler` fit of one unknown less has its own, where there is one, and of these and of the
/// present one those with the other sign of that unknown, the last.
std::vector<std::vector<double>> places_to_try(const FitProblem& all_data, const Solved& solved,
                                               const FitResult* simpler, const std::function<bool()>& go_on) {
  constexpr double kAsLow = 10.0, kCoarse = 1e-6;  // half of chi-square, of some of the pixels
  SomeBlocks some = some_blocks(all_data, solved);
  FitProblem& problem = some.problem;
  if (simpler != nullptr && std::ranges::find(some.told_apart, true) != some.told_apart.end()) {
    std::vector<std::vector<double>> places{problem.x};
    for (const std::vector<double>& values : simpler->other_minima) {
      std::vector<double>& place = places.emplace_back(problem.x);
      for (std::size_t k = 0; k < values.size(); ++k) place[k] = problem.variables[k].x_of(values[k]);
    }
    const Variable& last = problem.variables.back();
    for (std::size_t k = 0, n = places.size(); k < n && last.has_sign(); ++k) {
      places.push_back(places[k]);
      places.back().back() = std::clamp(-places[k].back(), last.lo, last.hi);
    }
    places.erase(places.begin());
    return places;
  }
  const FitPoint here = problem.here();
  const std::vector<double> sd = sd_of_x(solved);
  std::vector<std::pair<double, std::vector<double>>> promises;
  const std::vector<Change> all = changes(some);
  for (Block& block : problem.blocks)
    if (auto* edge = std::get_if<EdgeBlock>(&block)) edge->thin_out(edge->every_for(kSomePixels));
  for (const Change& change : all) {
    problem.x = here.x;
    bool allowed = true;
    for (const auto& [i, to] : change) {
      const Variable& v = problem.variables[i];
      problem.x[i] = to;
      allowed = allowed && (v.period > 0.0 || (to >= v.lo && to <= v.hi));
    }
    if (!allowed || !differs(problem, sd, here.x, problem.x) || !problem.apply()) continue;
    if (const double chi2 = promised_chi2(problem); std::isfinite(chi2)) promises.emplace_back(chi2, problem.x);
  }
  std::ranges::stable_sort(promises, [](const auto& a, const auto& b) { return a.first < b.first; });
  promises.resize(std::min(kFollowed, promises.size()));
  const auto minimum_from = [&](const std::vector<double>& start) {
    problem.x = start;
    problem.own = here.own;
    return promises.empty() ? Solution{} : solve(problem, {.go_on = go_on, .tolerance = kCoarse});
  };
  const double best = minimum_from(here.x).cost;
  const std::vector<double> best_x = problem.x;
  std::vector<double> sd_of_some;
  for (const double one : sd) sd_of_some.push_back(one / std::sqrt(some.share));
  std::vector<std::vector<double>> places;
  for (const auto& [chi2, start] : promises) {
    const Solution there = minimum_from(start);
    if (there.converged && there.cost < best + kAsLow && differs(problem, sd_of_some, best_x, problem.x))
      places.push_back(problem.x);
  }
  all_data.apply();
  return places;
}

/// Where all signs together make no difference at the best minimum they make none at the others, which the search, of
/// the changes that promise most, need not have reached.
void add_opposites(const FitProblem& problem, std::span<const double> sd, const Mirror& best,
                   std::vector<Mirror>& found) {
  constexpr double kSame_chi2 = 0.01;
  const auto opposite = [&](Mirror mirror) {
    for (std::size_t i = 0; i < mirror.x.size(); ++i)
      if (problem.variables[i].has_sign()) mirror.x[i] = -mirror.x[i];
    return mirror;
  };
  const auto allowed = [&](const Mirror& one) {
    for (std::size_t i = 0; i < one.x.size(); ++i) {
      const Variable& v = problem.variables[i];
      if (v.period == 0.0 && !(one.x[i] >= v.lo && one.x[i] <= v.hi)) return false;
    }
    return true;
  };
  const auto find = [&](const Mirror& one) {
    return std::ranges::find_if(found, [&](const Mirror& other) { return !differs(problem, sd, other.x, one.x); });
  };
  const auto turned = find(opposite(best));
  if (turned == found.end() || turned->rise > kSame_chi2) return;
  for (const Mirror& mirror : std::vector(found)) {
    const Mirror other = opposite(mirror);
    if (allowed(other) && differs(problem, sd, other.x, best.x) && find(other) == found.end()) found.push_back(other);
  }
}

/// The intervals of a value with those of another within them, where these reach further: no standard error says that.
void extend_intervals(FittedParameter& p, const OtherValue& other, const Variable& v) {
  constexpr double kFurther = 1e-3;  // of the interval
  const auto extend = [&](std::array<double, 2>& interval, double sds) {
    const double sd = other.stderr_value.value_or(0.0);
    std::array<double, 2> there{other.value - sds * sd, other.value + sds * sd};
    if (!other.stderr_value && other.interval95 && sds == k95_sd) there = *other.interval95;
    if (v.period == 0.0) {
      const auto [least, most] = std::minmax({v.value(v.lo), v.value(v.hi)});
      for (double& end : there) end = std::clamp(end, std::min(least, interval[0]), std::max(most, interval[1]));
    }
    const double slack = kFurther * (interval[1] - interval[0]);
    const bool further = there[0] < interval[0] - slack || there[1] > interval[1] + slack;
    interval = {std::min(interval[0], there[0]), std::max(interval[1], there[1])};
    return further;
  };
  if (p.interval68) extend(*p.interval68, 1.0);
  if (!extend(*p.interval95, k95_sd)) return;
  if (p.interval && p.interval->low) p.interval->low = (*p.interval95)[0];
  if (p.interval && p.interval->high) p.interval->high = (*p.interval95)[1];
  if (p.limit95) p.limit95 = (*p.interval95)[p.limit_is_upper ? 1 : 0];
  if (p.knowledge != Knowledge::determined) return;
  p.knowledge = Knowledge::interval;
  p.stderr_value.reset();
  if (!p.interval) p.interval = ProfiledInterval{(*p.interval95)[0], (*p.interval95)[1], ""};
}

std::string value_text(const FitParameter& parameter, double value, double sd) {
  const int digits = sd > 0.0 ? static_cast<int>(std::log10(std::max(1.0, std::abs(value) / sd))) + 2 : 4;
  return mtf::significant(value, std::min(digits, 8)) + (parameter.unit.empty() ? "" : " " + parameter.unit);
}

/// Whether other values are those of a wavefront with the opposite sign, which the same wavefront out of focus is not.
bool is_other_sign(const FitProblem& problem, const FitResult& result, const Alternative& one) {
  const auto& entries = problem.sensors->system(0).list(mtf::Stage::presample);
  for (std::size_t k = 0; k < one.parameters.size(); ++k) {
    const FittedParameter& p = result.parameters[one.parameters[k]];
    const auto holds = [&](const auto& entry) {
      const std::string place = "presample[" + std::to_string(&entry - entries.data()) + "].";
      return entry.component.is_pupil() && p.parameter.path.starts_with(place);
    };
    if (std::ranges::none_of(entries, holds) || !(std::abs(one.values[k] + p.value) <= p.linear_sd)) return false;
  }
  return true;
}

}  // namespace

std::vector<Mirror> mirrored_minima(FitProblem& problem, Solved& solved, Solution& solution,
                                    std::span<const FitParameter> parameters, const MinimiseOptions& options,
                                    const FitResult* simpler) {
  constexpr double kLower = 0.005;  // half of chi-square
  constexpr int kMostLower = 3;
  for (int lower = 0; lower < kMostLower; ++lower) {
    std::vector<Mirror> found;
    const FitPoint best = problem.here();
    const std::vector<double> sd = sd_of_x(solved);
    bool left = false;
    for (const std::vector<double>& place : places_to_try(problem, solved, simpler, options.go_on)) {
      problem.x = place;
      problem.own = best.own;
      Solution there = solve(problem, {.go_on = options.go_on});
      solution.stopped = solution.stopped || there.stopped;
      if (!there.converged || !differs(problem, sd, best.x, problem.x)) continue;
      left = there.cost < solution.cost - kLower;
      if (left) {
        there.iterations += solution.iterations;
        solution = finish(problem, solved, there, options);
        judge(solved, parameters);
        break;
      }
      const double rise = 2.0 * std::max(0.0, there.cost - solution.cost) / noise_factor_of(problem, solved);
      const bool known =
          std::ranges::any_of(found, [&](const Mirror& other) { return !differs(problem, sd, other.x, problem.x); });
      if (rise < kToldApart_chi2 && !known) found.push_back({problem.here(), rise});
    }
    if (left) continue;
    problem.go_to(best);
    add_opposites(problem, sd, {best, 0.0}, found);
    std::ranges::stable_sort(found, [](const Mirror& a, const Mirror& b) { return a.rise < b.rise; });
    return found;
  }
  return {};
}

void report_mirrors(FitProblem& problem, const Solved& solved, std::span<const Mirror> mirrors,
                    std::span<const FlatPoint> flat, FitResult& result) {
  const FitPoint best = problem.here();
  const std::vector<double> sd = sd_of_x(solved);
  // True where the value is one of those of an ambiguous parameter.
  const auto add = [&](std::size_t i, const OtherValue& other) {
    FittedParameter& p = result.parameters[i];
    const auto within = [&](const std::optional<std::array<double, 2>>& interval) {
      return interval && other.value >= (*interval)[0] && other.value <= (*interval)[1];
    };
    // Of an interval about a flat point all parts are there already.
    const bool whole = std::ranges::any_of(flat, [&](const FlatPoint& f) { return f.parameter == i; });
    if (within(p.interval95)) {
      if (!whole) extend_intervals(p, other, problem.variables[i]);
      return false;
    }
    for (const OtherValue& one : p.others)
      if (within(one.interval95) || std::abs(one.value - other.value) <= kDiffers_sd * p.linear_sd) return true;
    const bool known = p.knowledge == Knowledge::determined || p.knowledge == Knowledge::interval ||
                       p.knowledge == Knowledge::ambiguous;
    const bool stated = known || (p.knowledge == Knowledge::not_determined && p.interval95);
    if (whole || !stated) return false;
    p.others.push_back(other);
    if (known) p.knowledge = Knowledge::ambiguous;
    return true;
  };
  const auto tell = [&](Alternative one) {
    std::vector<std::string> names, values, others;
    for (std::size_t k = 0; k < one.parameters.size(); ++k) {
      const FittedParameter& p = result.parameters[one.parameters[k]];
      names.push_back(name_of(p.parameter));
      values.push_back(value_text(p.parameter, p.value, p.linear_sd));
      others.push_back(value_text(p.parameter, one.values[k], p.linear_sd));
    }
    one.text = mtf::listed(names) + ": the data do not tell " + mtf::listed(values) + " from " + mtf::listed(others);
    if (one.chi2_rise >= 0.05) one.text += ", where chi-square is higher by " + mtf::significant(one.chi2_rise, 2);
    if (is_other_sign(problem, result, one)) one.text += "; an image at another focus that is known tells the sign";
    result.alternatives.push_back(std::move(one));
  };
  for (const Mirror& mirror : mirrors) {
    if (!problem.go_to(mirror)) continue;
    const std::vector<Eigen::MatrixXd> normals = problem.normals();
    const Identified there =
        identify(information_of(problem, normals, solved.scores, solved.noise_factor).matrix, solved.reference);
    Alternative one{.chi2_rise = mirror.rise};
    result.other_minima.push_back(values_at(problem.variables, mirror.x));
    for (std::size_t i = 0; i < best.x.size(); ++i) {
      const Variable& v = problem.variables[i];
      if (!(std::abs(difference(v, mirror.x[i], best.x[i])) > kDiffers_sd * sd[i])) continue;
      const auto index = static_cast<Eigen::Index>(i);
      const double at = mirror.x[i], sd_there = std::sqrt(there.covariance(index, index));
      OtherValue other{
          .value = v.value(at), .stderr_value = sd_there * std::abs(v.slope(at)), .chi2_rise = mirror.rise};
      if (v.squared && at < kNearZero_sd * sd_there) {  // the root of its square
        other.stderr_value.reset();
        const double a = v.value(at - k95_sd * sd_there), b = v.value(at + k95_sd * sd_there);
        other.interval95 = {std::min(a, b), std::max(a, b)};
      }
      if (!add(i, other)) continue;
      one.parameters.push_back(i);
      one.values.push_back(other.value);
    }
    if (!one.parameters.empty()) tell(std::move(one));
  }
  problem.go_to(best);
  // A square that does not hold 0 has the same on the other side.
  for (std::size_t i = 0; i < best.x.size(); ++i) {
    const Variable& v = problem.variables[i];
    const FittedParameter& p = result.parameters[i];
    const double other = -p.value;
    if (!v.squared || p.value == 0.0 || std::abs(p.value) > v.other_side) continue;
    OtherValue there{.value = other, .stderr_value = p.stderr_value, .interval95 = p.interval95};
    if (there.interval95) there.interval95 = {-(*p.interval95)[1], -(*p.interval95)[0]};
    if (add(i, there)) tell({.parameters = {i}, .values = {other}, .chi2_rise = 0.0});
  }
}

}  // namespace calib
