// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/fit_rounds.h"

#include <algorithm>
#include <cmath>

#include "calib/edge/median.h"
#include "calib/fit/fit_build.h"

namespace calib {
namespace {

constexpr double kGradientChi2 = 18.47;  // of four more unknowns: one edge in a thousand has it by chance
constexpr int kMostRounds = 3;
constexpr std::size_t kSomePixels = 2000;  // enough to come close, and for a median

/// Chi-square of each block a degree of freedom; the shared parameters are counted by the blocks' sizes.
std::vector<double> noise_factors(const FitProblem& problem, std::span<const Eigen::MatrixXd> normals,
                                  std::span<const std::size_t> counts) {
  double all = 0.0;
  for (const std::size_t count : counts) all += static_cast<double>(count);
  std::vector<double> factors;
  for (std::size_t b = 0; b < normals.size(); ++b) {
    const auto n = static_cast<double>(counts[b]);
    const double shared = static_cast<double>(problem.variables.size()) * n / all;
    const double used = static_cast<double>(problem.own[b].size()) + shared;
    factors.push_back(normals[b](normals[b].rows() - 1, normals[b].cols() - 1) / std::max(1.0, n - used));
  }
  return factors;
}

/// By how much four gradients of an edge's plateaus would lower its chi-square with all other unknowns fitted anew:
/// with their columns last, it is the part of r in their rows of the triangular factor.
double gain_of_gradients(const Eigen::MatrixXd& normal, Eigen::Index own) {
  const Eigen::Index n = normal.cols();
  std::vector<Eigen::Index> order;
  for (Eigen::Index i = 0; i < n - 1; ++i)
    if (i < own || i >= own + 4) order.push_back(i);
  for (const Eigen::Index i : {own, own + 1, own + 2, own + 3, n - 1}) order.push_back(i);
  return triangular_factor(normal(order, order)).col(n - 1).segment(n - 5, 4).squaredNorm();
}

/// Normal matrices and noise at the present values. Returns the edges whose plateaus have gradients, which would
/// lower chi-square by more than chance.
std::vector<std::size_t> examine(FitProblem& problem, std::span<const std::size_t> counts, Solved& solved) {
  const std::vector<Eigen::MatrixXd> extended = problem.normals(true);
  solved.normals = extended;
  std::vector<std::size_t> candidates;
  for (std::size_t b = 0; b < extended.size(); ++b) {
    const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
    if (edge == nullptr || edge->gradients()) continue;
    candidates.push_back(b);
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < extended[b].cols(); ++i)
      if (i < std::ssize(problem.own[b]) || i >= std::ssize(problem.own[b]) + 4) kept.push_back(i);
    solved.normals[b] = extended[b](kept, kept);
  }
  solved.noise_factor = noise_factors(problem, solved.normals, counts);
  std::erase_if(candidates, [&](std::size_t b) {
    const double gain = gain_of_gradients(extended[b], std::ssize(problem.own[b]));
    return gain < kGradientChi2 * trusted_noise(solved.noise_factor[b]);
  });
  return candidates;
}

/// Sets the noise from the fitted values; true when the weights of a block have changed enough to fit again.
bool update_weights(FitProblem& problem, std::span<const double> noise) {
  bool any = false;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    if (auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]); edge != nullptr && edge->noise_follows()) {
      edge->update_noise(*problem.sensors, problem.own[b]);
      any = true;
    }
    if (auto* spot = std::get_if<SpotBlock>(&problem.blocks[b]))
      any = spot->update_noise(*problem.sensors, problem.own[b]) || any;
    // Between sets of data, and against priors, the size of the noise matters; it is taken from the residuals.
    const bool relative = problem.blocks.size() > 1 || std::any_of(problem.priors.begin(), problem.priors.end(),
                                                                   [](auto& p) { return p.has_value(); });
    const bool own_noise = !std::holds_alternative<CurveBlock>(problem.blocks[b]);
    const double factor = trusted_noise(noise[b]);
    if (!relative || !own_noise || (factor > 0.8 && factor < 1.25)) continue;
    std::visit([&](auto& block) { block.scale_noise(factor); }, problem.blocks[b]);
    any = true;
  }
  return any;
}

/// Where residuals are larger than the noise that was given, the noise is scaled to their median, so that the threshold
/// for outliers follows from the residuals but not from the outliers.
void estimate_noise_scale(FitProblem& problem) {
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    if (std::holds_alternative<CurveBlock>(problem.blocks[b])) continue;
    const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
    std::vector<double> sizes;
    for (const Residual& r : problem.residuals(b, edge != nullptr ? edge->every_for(kSomePixels) : 1))
      sizes.push_back(std::abs(r.value));
    const double middle = median(sizes), scale = middle / 0.6744897501960817;
    // Residuals within half a step of the image's values are rounding.
    if (edge != nullptr && middle * edge->middle_sd() < 0.6 * edge->data().quantum) continue;
    if (scale > 1.25) std::visit([&](auto& block) { block.scale_noise(scale * scale); }, problem.blocks[b]);
  }
}

/// Plain least squares on some of the pixels first: far from the minimum all residuals are beyond the bend of the loss,
/// where steps are short. The noise is estimated in the first run only, so that the costs of several runs can be
/// compared.
Solution solve_robustly(FitProblem& problem, const MinimiseOptions& options, bool estimate_noise) {
  constexpr double kCoarse = 1e-4;
  const auto set_up = [&](bool coarse) {
    for (Block& block : problem.blocks) {
      std::visit([&](auto& b) { b.set_robust(options.robust && !coarse); }, block);
      if (auto* edge = std::get_if<EdgeBlock>(&block)) edge->thin_out(coarse ? edge->every_for(kSomePixels) : 1);
    }
  };
  set_up(true);
  const Solution first = solve(problem, {.go_on = options.go_on, .tolerance = kCoarse});
  set_up(false);
  if (first.stopped) return first;
  if (estimate_noise) estimate_noise_scale(problem);
  Solution second = solve(problem, {.go_on = options.go_on});
  second.iterations += first.iterations;
  return second;
}

/// The best of several starts, with the number of runs that ended at the same minimum.
Solution solve_from(FitProblem& problem, const MinimiseOptions& options) {
  const auto own = problem.own;
  Solution best = solve_robustly(problem, options, true);
  std::vector<double> costs{best.cost};
  FitPoint minimum = problem.here();
  for (int run = 1; run < options.starts && !best.stopped; ++run) {
    problem.x = other_start(problem.variables, run);
    problem.own = own;
    const Solution next = solve_robustly(problem, options, false);
    costs.push_back(next.cost);
    best.stopped = next.stopped;
    best.iterations += next.iterations;
    if (!(next.cost < best.cost) || !next.converged) continue;
    best.cost = next.cost;
    best.converged = true;
    minimum = problem.here();
  }
  problem.go_to(minimum);
  // Minima within a tenth of a standard deviation count as the same.
  best.agreeing = static_cast<int>(
      std::count_if(costs.begin(), costs.end(), [&](double c) { return c < best.cost + 0.01 + 1e-7 * best.cost; }));
  return best;
}

/// The number of pixels or samples of every block.
std::vector<std::size_t> counts_of(const FitProblem& problem) {
  std::vector<std::size_t> counts;
  for (std::size_t b = 0; b < problem.blocks.size(); ++b) {
    const Block& block = problem.blocks[b];
    const auto* edge = std::get_if<EdgeBlock>(&block);
    const auto* spot = std::get_if<SpotBlock>(&block);
    counts.push_back(edge != nullptr   ? edge->pixels()
                     : spot != nullptr ? spot->pixels()
                                       : std::get<CurveBlock>(block).frequencies().size());
  }
  return counts;
}

}  // namespace

void add_gradients(FitProblem& problem, std::size_t edge) {
  std::get<EdgeBlock>(problem.blocks[edge]).use_gradients();
  problem.own[edge].resize(problem.own[edge].size() + 4, 0.0);
}

double noise_factor_of(const FitProblem& problem, const Solved& solved) {
  double factor = 0.0, weight = 0.0;
  const std::vector<std::size_t> counts = counts_of(problem);
  for (std::size_t b = 0; b < counts.size(); ++b) {
    factor += trusted_noise(solved.noise_factor[b]) * static_cast<double>(counts[b]);
    weight += static_cast<double>(counts[b]);
  }
  return factor / weight;
}

Solution finish(FitProblem& problem, Solved& solved, const Solution& first, const MinimiseOptions& options) {
  Solution solution = first;
  const std::vector<std::size_t> counts = counts_of(problem);
  for (int round = 0;; ++round) {
    const std::vector<std::size_t> gradients = examine(problem, counts, solved);
    if (!solution.converged || round == kMostRounds) break;
    const bool weights = round < 2 && update_weights(problem, solved.noise_factor);
    if (gradients.empty() && !weights) break;
    for (const std::size_t b : gradients) add_gradients(problem, b);
    const Solution again = solve(problem, {.go_on = options.go_on});
    solution = {again.converged, again.stopped, again.cost, solution.iterations + again.iterations, solution.agreeing};
  }
  return solution;
}

Solution minimise(FitProblem& problem, Solved& solved, const MinimiseOptions& options) {
  return finish(problem, solved, solve_from(problem, options), options);
}

}  // namespace calib
