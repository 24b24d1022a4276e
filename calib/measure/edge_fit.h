// SPDX-License-Identifier: Apache-2.0
#pragma once

// Levels, geometry and the shape of the reference step, by Gauss-Newton steps over the pixels' residuals.

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <optional>

#include "calib/measure/edge_noise.h"
#include "calib/measure/edge_sums.h"

namespace calib {

/// The unknowns in their order: the levels; the coefficients of t^k that move the curve towards the bright side, in px,
/// k = 0 .. 5; S, v, q.
inline constexpr int kFirstShift = kLevels;
inline constexpr int kFirstShape = kFirstShift + kHighestOrder + 1;
inline constexpr int kUnknowns = kFirstShape + kShapes;
using Unknowns = std::bitset<kUnknowns>;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// J^T W J and J^T W r, weights 1 / variance; chi2 of the residuals as they are, and how many they count as.
struct NormalEquations {
  Matrix matrix = Matrix::Zero();
  Vector gradient = Vector::Zero();
  double chi2 = 0.0, count = 0.0;
};

/// The derivative by unknown `a` is a function of d, here at the middle of each bin, times t^basis_power(a); that of a
/// shift t^2 or higher in the bins that show bends, zero elsewhere.
class Basis {
 public:
  /// Of some unknowns; refers to the profile.
  Basis(const StepProfile& profile, double contrast, const Unknowns& unknowns);
  /// The function is scale(a) x row(a).
  const BinRow& row(int a) const;
  double scale(int a) const;

 private:
  const StepProfile& profile_;
  double contrast_;
  BinRow dark_, dark_d_, bright_d_;  // 1 - E; that and E, times d
};
int basis_power(int a);
inline bool is_bend(int a) { return a >= kFirstShift + 2 && a < kFirstShape; }

/// What the reference's shapes usually are: a footprint of about a pixel. Weak: one edge seldom tells S, v and q apart.
void add_prior(NormalEquations& normal, const ReferenceShape& shape, const Unknowns& unknowns);

struct FitRounds {
  Unknowns unknowns{};
  int rounds = 8;                    ///< at most
  double enough = 0.3;               ///< ends when no more of chi2 is to be gained, or a short step gained no more
  std::size_t step = 1;              ///< every step-th pixel
  double least_variance = 4e-12;     ///< of a pixel
  std::optional<double> variance{};  ///< of a pixel, when known
  Rounding rounding{};
};
/// The highest power of t that the unknowns' derivatives have, at least 1.
int order_of(const Unknowns& unknowns);
NoiseModel noise_of(const EdgeSums& sums, const StepProfile& profile, const FitRounds& rounds);

/// What is known at a model: profile, residuals, noise, equations.
struct FitState {
  NoiseModel noise;
  StepProfile profile;
  EdgeSums sums;
  BinRow weight{};  ///< of a pixel, by bin
  NormalEquations normal;
  bool converged = false;
};
double chi2_of(const EdgeSums& sums, const BinRow& weight);
/// Weights and equations of a state that has its profile, sums and noise.
void assemble(FitState& state, const EdgeModel& model, const FitRounds& rounds);
/// Damped Gauss-Newton steps, each over all pixels; `model` becomes the one of the returned state, `state` is that of
/// the model at the start.
FitState fit_reference(const EdgePixels& pixels, EdgeModel& model, const FitRounds& rounds, FitState state);
FitState fit_reference(const EdgePixels& pixels, EdgeModel& model, const FitRounds& rounds);
/// Takes a step.
void move(EdgeModel& model, const Vector& step);

/// The state at the model as it is.
FitState evaluate(const EdgePixels& pixels, const EdgeModel& model, const FitRounds& rounds);

}  // namespace calib
