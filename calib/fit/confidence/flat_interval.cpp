// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/flat_interval.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "calib/dense.h"
#include "calib/fit/confidence/profile.h"

namespace calib {
namespace {

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
    std::size_t every = 1;
    const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b]);
    if (edge != nullptr) every = std::max<std::size_t>(1, edge->pixels() / kPixels);
    const std::vector<Residual> some =
        edge != nullptr
            ? edge->residuals(*problem.sensors, problem.own[b], every)
            : std::visit([&](const auto& block) { return block.residuals(*problem.sensors, problem.own[b]); },
                         problem.blocks[b]);
    const double scale = std::sqrt(static_cast<double>(every) / noise_factor);
    for (const Residual& r : some) all.push_back(scale * r.value);
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

}  // namespace

std::optional<FlatInterval> flat_interval(FitProblem& problem, const FlatPoint& point, double first_step, double cost,
                                          double noise_factor, std::span<const FlatPoint> flat,
                                          const std::function<bool()>& go_on) {
  const std::size_t i = point.parameter;
  const Variable& v = problem.variables[i];
  const std::vector<double> minimum = problem.x;
  const std::vector<std::vector<double>> own = problem.own;
  Profiler profiler{problem, i, cost, noise_factor, flat, go_on};
  const auto at_minimum = [&] {
    problem.x = minimum;
    problem.own = own;
  };
  // How far from the point values need to be tried, on either side.
  double far = std::max(std::abs(minimum[i] - point.at), point.off);
  const double farthest = v.period > 0.0 ? 0.5 * v.period / v.step : v.hi - v.lo;
  const auto too_near = [&](double side) {
    const double x = point.at + side * far;
    return far < farthest && x > v.lo && x < v.hi && profiler.at(x) < kFar_sd;
  };
  for (const double side : {point.side, -point.side}) {
    if (side != point.side && !point.inside) continue;
    at_minimum();
    for (double step = first_step; too_near(side) && !profiler.stopped; step *= 1.5) far += step;
  }
  // The minimum and its mirror are among the values, as the root of the rise has its kinks there.
  std::vector<double> x{minimum[i]};
  if (point.inside) x.push_back(2.0 * point.at - minimum[i]);
  for (int k = point.inside ? -kNodesToASide : 0; k <= kNodesToASide; ++k)
    x.push_back(point.at + point.side * far * k / kNodesToASide);
  for (double& value : x) value = std::clamp(value, v.lo, v.hi);
  std::sort(x.begin(), x.end());
  std::vector<Node> nodes;
  for (const double value : x)
    if (nodes.empty() || value - nodes.back().x > 0.01 * far / kNodesToASide) nodes.push_back({value, 0.0, {}});
  // From the one next to the minimum to either end, each fit beginning where its neighbour ended.
  const auto nearest = std::min_element(nodes.begin(), nodes.end(), [&](const Node& a, const Node& b) {
    return std::abs(a.x - minimum[i]) < std::abs(b.x - minimum[i]);
  });
  const auto try_value = [&](Node& node) {
    const double root = profiler.at(node.x);
    node.rise = root * root;
    node.residuals = residuals(problem, noise_factor);
  };
  at_minimum();
  for (auto node = nearest; node != nodes.end() && !profiler.stopped; ++node) try_value(*node);
  at_minimum();
  for (auto node = nearest; node != nodes.begin() && !profiler.stopped;) try_value(*--node);
  at_minimum();
  problem.apply();
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

}  // namespace calib
