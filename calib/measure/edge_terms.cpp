// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_terms.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/dense.h"
#include "calib/measure/defects/score_covariance.h"

namespace calib {
namespace {

// The normal equations of some unknowns, scaled to a unit diagonal.
struct Selection {
  std::vector<int> list;
  Eigen::MatrixXd matrix;
  Eigen::VectorXd gradient, scale;
};

Selection select(const NormalEquations& normal, const Unknowns& unknowns) {
  Selection all;
  for (int a = 0; a < kUnknowns; ++a)
    if (unknowns[static_cast<std::size_t>(a)] && normal.matrix(a, a) > 0.0) all.list.push_back(a);
  const auto n = static_cast<Eigen::Index>(all.list.size());
  all.matrix.resize(n, n);
  all.gradient.resize(n);
  all.scale.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int a = all.list[static_cast<std::size_t>(i)];
    all.scale[i] = 1.0 / std::sqrt(normal.matrix(a, a));
    all.gradient[i] = normal.gradient[a] * all.scale[i];
    for (Eigen::Index j = 0; j <= i; ++j)
      all.matrix(i, j) = all.matrix(j, i) =
          normal.matrix(a, all.list[static_cast<std::size_t>(j)]) * all.scale[i] * all.scale[j];
    all.matrix(i, i) += 1e-12;
  }
  return all;
}

// A matrix of all unknowns in the order and the scale of a selection.
Eigen::MatrixXd selected(const Matrix& matrix, const Selection& all) {
  const auto n = static_cast<Eigen::Index>(all.list.size());
  Eigen::MatrixXd some(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      some(i, j) = all.scale[i] * all.scale[j] *
                   matrix(all.list[static_cast<std::size_t>(i)], all.list[static_cast<std::size_t>(j)]);
  return some;
}

struct Gain {
  double chi2 = 0.0;
  double by_noise = 0.0;  ///< the mean of chi2 where the residuals are noise: one an unknown if that is independent
  Vector step = Vector::Zero();
};

// The normal equations and the covariance of their right side.
struct Equations {
  const NormalEquations& normal;
  Matrix scores;
  bool independent;
};

// The linear step in some unknowns and how much it lowers chi2.
Gain gain_of(const Equations& equations, const Unknowns& unknowns) {
  const Selection all = select(equations.normal, unknowns);
  const SymmetricFactor factor(all.matrix);
  const Eigen::VectorXd x = factor.solve(all.gradient);
  Gain gain{.chi2 = x.dot(all.gradient), .by_noise = static_cast<double>(all.list.size())};
  if (!equations.independent) gain.by_noise = factor.solve(selected(equations.scores, all)).trace();
  for (std::size_t i = 0; i < all.list.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    gain.step[all.list[i]] = x[k] * all.scale[k];
  }
  return gain;
}

// Largest height of the terms t^first .. t^last over the edge.
double largest_bend(const Vector& step, int first, int last) {
  constexpr int kSteps = 20;
  double most = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = 2.0 * i / kSteps - 1.0;
    double height = 0.0;
    for (int k = last; k >= first; --k) height = (height + step[kFirstShift + k]) * t;
    most = std::max(most, std::abs(height * std::pow(t, first - 1)));
  }
  return most;
}

}  // namespace

Unknowns basic_unknowns() {
  Unknowns unknowns;
  for (const int a : {0, 1, kFirstShift, kFirstShift + 1}) unknowns.set(static_cast<std::size_t>(a));
  for (int k = 0; k < kShapes; ++k) unknowns.set(static_cast<std::size_t>(kFirstShape + k));
  return unknowns;
}

Unknowns with_order(Unknowns unknowns, int order) {
  for (int k = 2; k <= order; ++k) unknowns.set(static_cast<std::size_t>(kFirstShift + k));
  return unknowns;
}

Unknowns with_gradients(Unknowns unknowns) {
  for (std::size_t a = 2; a < kFirstCurvature; ++a) unknowns.set(a);
  return unknowns;
}

Unknowns with_shading(Unknowns unknowns) {
  for (std::size_t a = 0; a < kPlateauTerms; ++a) unknowns.set(a);
  return unknowns;
}

Unknowns without_bounds(Unknowns unknowns, const EdgeModel& model) {
  if (model.shape.s_px < 1e-9) unknowns.reset(kFirstShape);
  if (model.shape.v_px2 <= kLeastVariance_px2 * 1.0001) unknowns.reset(kFirstShape + 1);
  if (model.shape.q_px2 < 1e-9) unknowns.reset(kFirstShape + 2);
  return unknowns;
}

Terms choose_terms(const FitState& state, const EdgeModel& model, double extent_px, const MeasureOptions& options,
                   int least_order) {
  constexpr double kSureGradient = 8.0, kSureBend = 12.0;  // F: once in 10^5 and in 2000 straight, even edges
  constexpr double kLeastGradient = 2e-3;                  // of the contrast, at the outermost pixels
  constexpr double kLeastBend_px = 3e-3;                   // changes no MTF by more than 1e-4
  const Unknowns base = without_bounds(basic_unknowns(), model);
  const Unknowns most = with_gradients(with_order(base, kHighestOrder));
  const Equations equations{state.normal, score_covariance(state, model, most), state.correlation.white()};
  const Gain all = gain_of(equations, most);
  const double unit = std::max(1.0, (state.normal.chi2 - all.chi2) / std::max(1.0, state.normal.count - kUnknowns));
  Terms terms;
  const int tested = options.order || options.circle ? options.order.value_or(2) : least_order;
  const Gain flat = gain_of(equations, with_order(base, tested));
  const Gain tilted = gain_of(equations, with_gradients(with_order(base, tested)));
  const double across = std::max(std::abs(tilted.step[2]), std::abs(tilted.step[3])) * extent_px;
  const double along = std::max(std::abs(tilted.step[4]), std::abs(tilted.step[5]));
  // How many gains of an unknown by noise the terms of `more` add to those of `less`.
  const auto surely = [&](const Gain& more, const Gain& less, double count, double times) {
    return more.chi2 - less.chi2 > times * unit * std::max(count, more.by_noise - less.by_noise);
  };
  terms.gradients =
      surely(tilted, flat, 4.0, kSureGradient) && std::max(across, along) > kLeastGradient * std::abs(model.contrast());
  if (options.circle || options.order) {
    terms.order = options.circle ? 2 : *options.order;
    return terms;
  }
  terms.order = least_order;
  const Unknowns rest = with_order(terms.gradients ? with_gradients(base) : base, least_order);
  Gain explained = gain_of(equations, rest);
  for (int order = least_order + 1; order <= kHighestOrder; ++order) {
    const Gain bent = gain_of(equations, with_order(rest, order));
    if (!surely(bent, explained, order - terms.order, kSureBend)) continue;
    if (largest_bend(bent.step, terms.order + 1, order) < kLeastBend_px) continue;
    terms.order = order;
    explained = bent;
  }
  return terms;
}

Diffraction diffraction_in(const FitState& state, const EdgeModel& model, const Unknowns& unknowns) {
  constexpr double kSure = 6.0;  // chi2: once in 140 blurs without diffraction
  constexpr double kUnclear =
      0.35;  // of the blur's standard deviation; an aberration-free pupil alone has S = 2.2 of it
  NormalEquations normal = state.normal;
  add_prior(normal, model.shape, unknowns);
  const Selection all = select(normal, without_bounds(unknowns, model).set(kFirstShape, unknowns[kFirstShape]));
  for (std::size_t i = 0; i < all.list.size(); ++i) {
    if (all.list[i] != kFirstShape) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(all.matrix.rows(), k);
    const Eigen::VectorXd column = SymmetricFactor(all.matrix).solve(unit);
    double by_score = column[k];
    if (!state.correlation.white()) {
      const Eigen::MatrixXd more = selected(score_covariance(state, model, unknowns) - state.normal.matrix, all);
      by_score += std::max(0.0, column.dot(more * column));
    }
    const double variance = by_score * all.scale[k] * all.scale[k];
    const double s_px = std::max(0.0, model.shape.s_px + column.dot(all.gradient) * all.scale[k]);
    if (variance > kUnclear * kUnclear * model.shape.blur_px2()) return Diffraction::unclear;
    return s_px * s_px > kSure * variance ? Diffraction::shown : Diffraction::absent;
  }
  return Diffraction::absent;
}

void set_order(EdgeCurve& curve, int order, bool circle) {
  if (circle) {
    curve.shape = EdgeCurve::Shape::circle;
  } else if (order > 1) {
    curve.shape = EdgeCurve::Shape::polynomial;
    curve.coefficient.resize(static_cast<std::size_t>(order - 1));
  }
}

}  // namespace calib
