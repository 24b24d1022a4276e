// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/correction/model_average.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calib/dense.h"

namespace calib {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Sizes that parts may have: shading and far light in parts of the contrast. Shading has half of the prior probability
// to be absent, far light a tenth, as every lens scatters some. (A twentieth brings 3 % of the light over 20 px in
// 40 x 60 pixels at a contrast / noise of 20 from 78 to 86 and 94 %, and makes the intervals of clean edges 1.35 times
// as wide at 0.05 cycles/pixel.) A blur that the reference lacks has an imaginary part seldom without a real one of the
// same size. Wide blurs, and those that come with light that is scattered far, are seldom what the reference describes.
struct Shading {
  double gradient, curvature;
};
constexpr std::array kShadings{Shading{0.0, 0.0},   Shading{0.01, 0.0}, Shading{0.1, 0.0}, Shading{0.5, 0.0},
                               Shading{0.01, 0.01}, Shading{0.1, 0.1},  Shading{0.5, 0.5}};
constexpr std::array kFarLights{0.0, 0.003, 0.01, 0.03, 0.1};
constexpr std::array kNearLights{0.0, 0.03, 0.1, 0.3};
constexpr double kNoFarLight = 0.1, kNoNearLight = 0.7;
constexpr double kNoDiffraction = 0.2, kNoCorrection = 0.4, kNoCorrectionOfOthers = 0.1;
constexpr double kWindow = 1.0 / 20.0;

using Weighted = std::vector<std::pair<PartSizes, double>>;

class Hypotheses {
 public:
  // Information and scores of the parts' unknowns in their unit standard deviations, the fixed ones projected out.
  Hypotheses(const MatrixXd& information, const VectorXd& score, const std::vector<Part>& part, bool wide)
      : information_(information), score_(score), part_(part), wide_(wide) {
    for (const Part one : part) has_[one] = true;
    if (!has_[kReal]) return;
    // From the size that doubles what is known of the direction that the pixels know best.
    constexpr double kLeast = 2.0, kFactor = 2.0, kMost = 1.0;
    constexpr std::size_t kSizes = 20;
    double size = std::sqrt(kLeast / std::max(1e-300, largest_real()));
    for (; real_.size() < kSizes && size < kMost; size *= kFactor) real_.push_back(size);
  }

  // Those within the window, with their probabilities; with given surroundings, if any.
  Weighted likely(const PartSizes* given = nullptr) {
    PartSizes best = given != nullptr ? *given : PartSizes{};
    best[kDiffraction] = has_[kDiffraction] ? 1.0 : 0.0;
    const auto around = [&](const PartSizes& from) {
      return given != nullptr ? std::vector<PartSizes>{from} : surroundings(from);
    };
    const auto lights = [&](const PartSizes& from) {
      return given != nullptr ? std::vector<PartSizes>{from} : near_lights(from);
    };
    constexpr int kMostSweeps = 4;
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      PartSizes better = best;
      for (const auto& moves : {diffractions(best), corrections(best), lights(best), around(best)})
        for (const PartSizes& one : moves)
          if (weight(one) > weight(better)) better = one;
      if (better == best) break;
      best = better;
    }
    // Every combination of alternatives that are likely by themselves.
    const double least = weight(best) + std::log(kWindow);
    std::vector<PartSizes> all{best};
    const auto combine = [&](const std::vector<PartSizes>& moves, std::initializer_list<Part> parts) {
      std::vector<PartSizes> combined;
      for (const PartSizes& move : moves) {
        if (weight(move) < least) continue;
        for (PartSizes one : all) {
          for (const Part part : parts) one[part] = move[part];
          combined.push_back(one);
        }
      }
      all = std::move(combined);
    };
    combine(diffractions(best), {kDiffraction});
    combine(corrections(best), {kReal, kImaginary});
    combine(lights(best), {kNearLight});
    combine(around(best), {kFarLight, kGradient, kCurvature});
    double most = -INFINITY;
    for (const PartSizes& one : all) most = std::max(most, weight(one));
    Weighted kept;
    double sum = 0.0;
    for (const PartSizes& one : all)
      if (const double probability = std::exp(weight(one) - most); probability > kWindow) {
        kept.emplace_back(one, probability);
        sum += probability;
      }
    for (auto& [one, probability] : kept) probability /= sum;
    return kept;
  }

  // The unknowns that a hypothesis has.
  std::vector<Index> unknowns(const PartSizes& sizes) const {
    std::vector<Index> list;
    for (std::size_t i = 0; i < part_.size(); ++i)
      if (sizes[part_[i]] > 0.0) list.push_back(static_cast<Index>(i));
    return list;
  }
  // 1 + P^(1/2) I P^(1/2) and P^(1/2) u of a hypothesis.
  MatrixXd matrix(const PartSizes& sizes, const std::vector<Index>& list) const {
    MatrixXd some = information_(list, list);
    for (Index i = 0; i < some.rows(); ++i)
      for (Index j = 0; j < some.cols(); ++j)
        some(i, j) *=
            size_of(sizes, list[static_cast<std::size_t>(i)]) * size_of(sizes, list[static_cast<std::size_t>(j)]);
    some.diagonal().array() += 1.0;
    return some;
  }
  VectorXd right(const PartSizes& sizes, const std::vector<Index>& list) const {
    VectorXd some = score_(list);
    for (Index i = 0; i < some.size(); ++i) some[i] *= size_of(sizes, list[static_cast<std::size_t>(i)]);
    return some;
  }
  double size_of(const PartSizes& sizes, Index i) const { return sizes[part_[static_cast<std::size_t>(i)]]; }

 private:
  double largest_real() const {
    std::vector<Index> list;
    for (std::size_t i = 0; i < part_.size(); ++i)
      if (part_[i] == kReal) list.push_back(static_cast<Index>(i));
    const MatrixXd some = information_(list, list);
    constexpr int kRounds = 12;  // of the power method
    Index largest = 0;
    some.diagonal().maxCoeff(&largest);
    VectorXd direction = some.col(largest).normalized();
    for (int round = 0; round < kRounds; ++round) direction = (some * direction).normalized();
    return direction.dot(some * direction);
  }

  double log_prior(const PartSizes& sizes) const {
    double sum = has_[kDiffraction] ? std::log(sizes[kDiffraction] > 0.0 ? 1.0 - kNoDiffraction : kNoDiffraction) : 0.0;
    if (has_[kReal]) {
      const double none = wide_ || sizes[kFarLight] > 0.0 ? kNoCorrectionOfOthers : kNoCorrection;
      constexpr double kOrders = 9.0, kEither = 0.5;
      sum += std::log(sizes[kReal] > 0.0 ? kEither * (1.0 - none) / kOrders : none);
    }
    if (has_[kNearLight])
      sum += std::log(sizes[kNearLight] > 0.0 ? (1.0 - kNoNearLight) / static_cast<double>(kNearLights.size() - 1)
                                              : kNoNearLight);
    if (has_[kFarLight])
      sum += std::log(sizes[kFarLight] > 0.0 ? (1.0 - kNoFarLight) / static_cast<double>(kFarLights.size() - 1)
                                             : kNoFarLight);
    if (sizes[kGradient] > 0.0) sum -= std::log(static_cast<double>(kShadings.size() - 1));
    return sum;
  }

  // Logarithm of prior times evidence.
  double weight(const PartSizes& sizes) {
    const auto known = weights_.find(sizes);
    if (known != weights_.end()) return known->second;
    const std::vector<Index> list = unknowns(sizes);
    double sum = log_prior(sizes);
    if (!list.empty()) {
      const auto solution = cholesky_solution(matrix(sizes, list), right(sizes, list));
      if (!solution) return weights_[sizes] = -INFINITY;
      sum += 0.5 * solution->half.squaredNorm() - solution->log_root;
      // Far light and shading of opposite signs can hide in each other, many times larger than either is in fact.
      constexpr double kMost = 4.0;  // standard deviations of the prior
      for (std::size_t i = 0; i < list.size(); ++i) {
        const Part part = part_[static_cast<std::size_t>(list[i])];
        const bool surrounding = part == kFarLight || part == kGradient || part == kCurvature;
        if (surrounding && std::abs(solution->x[static_cast<Index>(i)]) > kMost) return weights_[sizes] = -INFINITY;
      }
    }
    return weights_[sizes] = sum;
  }

  std::vector<PartSizes> diffractions(const PartSizes& from) const {
    std::vector<PartSizes> moves(has_[kDiffraction] ? 2 : 1, from);
    if (has_[kDiffraction]) moves[0][kDiffraction] = 0.0, moves[1][kDiffraction] = 1.0;
    return moves;
  }
  std::vector<PartSizes> corrections(const PartSizes& from) {
    constexpr double kFalling = 6.0;  // less likely sizes are followed by less likely ones
    std::vector<PartSizes> moves{from};
    moves[0][kReal] = moves[0][kImaginary] = 0.0;
    double most = weight(moves[0]);
    for (const double size : real_) {
      double now = -INFINITY;
      for (const double imaginary : {0.0, size}) {
        PartSizes& move = moves.emplace_back(from);
        move[kReal] = size;
        move[kImaginary] = imaginary;
        now = std::max(now, weight(move));
      }
      if (now < most - kFalling) break;
      most = std::max(most, now);
    }
    return moves;
  }
  std::vector<PartSizes> near_lights(const PartSizes& from) const {
    std::vector<PartSizes> moves(has_[kNearLight] ? kNearLights.size() : 1, from);
    for (std::size_t i = 0; has_[kNearLight] && i < kNearLights.size(); ++i) moves[i][kNearLight] = kNearLights[i];
    return moves;
  }
  std::vector<PartSizes> surroundings(const PartSizes& from) const {
    std::vector<PartSizes> moves;
    for (const double far : kFarLights)
      for (const auto& [gradient, curvature] : kShadings) {
        if ((far > 0.0 && !has_[kFarLight]) || (gradient > 0.0 && !has_[kGradient])) continue;
        PartSizes& move = moves.emplace_back(from);
        move[kFarLight] = far;
        move[kGradient] = gradient;
        move[kCurvature] = curvature;
      }
    return moves;
  }

  const MatrixXd& information_;
  const VectorXd& score_;
  const std::vector<Part>& part_;
  bool wide_;
  std::array<bool, kParts> has_{};
  std::vector<double> real_;
  std::map<PartSizes, double> weights_;
};

// Far light and shading differ little on the sides, so that the least misfit of the core decides between them where
// there is no noise. No edge follows its model so closely: they, and near light, are judged by `share` of the
// information only.
Weighted likely_hypotheses(const MatrixXd& information, const VectorXd& score, const LinearModel& model) {
  Hypotheses all(information, score, model.part, model.wide);
  if (model.share >= 1.0) return all.likely();
  const MatrixXd less_information = model.share * information;
  const VectorXd less_score = model.share * score;
  Hypotheses cautious(less_information, less_score, model.part, model.wide);
  std::map<PartSizes, double> surroundings;
  for (auto [sizes, probability] : cautious.likely()) {
    for (const Part part : {kDiffraction, kReal, kImaginary}) sizes[part] = 0.0;
    surroundings[sizes] += probability;
  }
  Weighted joined;
  for (const auto& [sizes, outer] : surroundings)
    for (const auto& [whole, inner] : all.likely(&sizes)) joined.emplace_back(whole, outer * inner);
  return joined;
}

}  // namespace

ModelAverage average_over_parts(const LinearModel& model) {
  const Index fixed = model.fixed, all = model.score.size(), free = all - fixed;
  const VectorXd scale = model.information.diagonal().head(fixed).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  MatrixXd n = scale.asDiagonal() * model.information.topLeftCorner(fixed, fixed) * scale.asDiagonal();
  n.diagonal().array() += 1e-15;
  const MatrixXd one = MatrixXd::Identity(fixed, fixed);
  const MatrixXd inverse = scale.asDiagonal() * SymmetricFactor(n).solve(one) * scale.asDiagonal();
  const VectorXd alone = inverse * model.score.head(fixed);
  ModelAverage average{.mean = VectorXd::Zero(all), .covariance = MatrixXd::Zero(all, all)};
  average.mean.head(fixed) = alone;
  average.covariance.topLeftCorner(fixed, fixed) = inverse;
  if (free == 0) return average;

  // The fixed unknowns follow the others by -explained.
  const MatrixXd cross = model.information.topRightCorner(fixed, free) * model.unit_sd.asDiagonal();
  const MatrixXd explained = inverse * cross;
  const MatrixXd information = MatrixXd(model.unit_sd.asDiagonal() * model.information.bottomRightCorner(free, free) *
                                        model.unit_sd.asDiagonal()) -
                               cross.transpose() * explained;
  const VectorXd score =
      model.unit_sd.cwiseProduct(model.score.tail(free)) - explained.transpose() * model.score.head(fixed);
  const Hypotheses hypotheses(information, score, model.part, model.wide);
  struct Node {
    double probability, real;
    std::vector<Index> list;
    VectorXd at;
    MatrixXd covariance;
  };
  std::vector<Node> nodes;
  VectorXd mean = VectorXd::Zero(free);
  for (const auto& [sizes, probability] : likely_hypotheses(information, score, model)) {
    for (std::size_t part = 0; part < kParts; ++part)
      average.probability[part] += sizes[part] > 0.0 ? probability : 0.0;
    std::vector<Index> list = hypotheses.unknowns(sizes);
    const auto size = static_cast<Index>(list.size());
    const SymmetricFactor own(hypotheses.matrix(sizes, list));
    VectorXd sd(size), at = VectorXd::Zero(free);
    for (Index i = 0; i < size; ++i) sd[i] = hypotheses.size_of(sizes, list[static_cast<std::size_t>(i)]);
    at(list) = sd.cwiseProduct(own.solve(hypotheses.right(sizes, list)));
    mean += probability * at;
    nodes.push_back({probability, sizes[kReal], std::move(list), at,
                     sd.asDiagonal() * own.solve(MatrixXd(MatrixXd::Identity(size, size))) * sd.asDiagonal()});
  }
  // A correction that the noise hides shrinks to a part of itself. What wide blurs and sharpened steps lack of the
  // reference is seldom small: their deviations are those with the largest correction that the pixels allow, and the
  // difference to it.
  constexpr double kLikely = 0.5;
  const bool unlike = model.wide || average.probability[kNearLight] > kLikely;
  double least_real = 0.0, sum = 0.0;
  for (const Node& node : nodes)
    if (unlike) least_real = std::max(least_real, node.real);
  for (const Node& node : nodes) sum += node.real >= least_real ? node.probability : 0.0;
  MatrixXd covariance = MatrixXd::Zero(free, free);
  for (const auto& [probability, real, list, at, own] : nodes) {
    if (real < least_real) continue;
    covariance += probability / sum * (at - mean) * (at - mean).transpose();
    covariance(list, list) += probability / sum * own;
  }
  average.mean.head(fixed) -= explained * mean;
  average.mean.tail(free) = model.unit_sd.cwiseProduct(mean);
  average.covariance.topLeftCorner(fixed, fixed) += explained * covariance * explained.transpose();
  average.covariance.topRightCorner(fixed, free) = -explained * covariance * model.unit_sd.asDiagonal();
  average.covariance.bottomLeftCorner(free, fixed) = average.covariance.topRightCorner(fixed, free).transpose();
  average.covariance.bottomRightCorner(free, free) =
      model.unit_sd.asDiagonal() * covariance * model.unit_sd.asDiagonal();
  return average;
}

}  // namespace calib
