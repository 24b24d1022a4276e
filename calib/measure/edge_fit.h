// SPDX-License-Identifier: Apache-2.0
#pragma once

// The fit of plateaus, geometry and the shape of the reference step, by Gauss-Newton steps over the pixels' residuals.

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <optional>
#include <vector>

#include "calib/measure/edge_noise.h"
#include "calib/measure/residual_sums.h"

namespace calib {

/// The unknowns in their order: the terms of the plateaus; the coefficients of t^k that move the curve towards the
/// bright side, in px, k = 0 .. 5; S, v, q.
inline constexpr int kFirstShift = kPlateauTerms;
inline constexpr int kFirstShape = kFirstShift + kHighestOrder + 1;
inline constexpr int kUnknowns = kFirstShape + kShapes;
using Unknowns = std::bitset<kUnknowns>;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// J^T W J and J^T W r, weights 1 / variance; chi2 of the residuals, and how many independent
/// residuals they count as.
struct NormalEquations {
  Matrix matrix = Matrix::Zero();
  Vector gradient = Vector::Zero();
  double chi2 = 0.0, count = 0.0;
};

/// The derivative by unknown `a` is a function of d, tabulated at the middle of each bin, times t^basis_power(a). That
/// of a shift t^2 or higher is taken in the bins that show bends and counts as zero elsewhere.
class Basis {
 public:
  /// For some unknowns. The profile must outlive it.
  Basis(const StepProfile& profile, double contrast, const Unknowns& unknowns);
  /// The function is scale(a) x row(a).
  const BinRow& row(int a) const;
  double scale(int a) const;

 private:
  const StepProfile& profile_;
  double contrast_;
  BinRow reference_dark_;                // 1 - E of the reference
  std::array<BinRow, 3> dark_, bright_;  // 1 - E and E times 1, d, d^2
};
int basis_power(int a);
inline bool is_bend(int a) { return a >= kFirstShift + 2 && a < kFirstShape; }

/// A weak Gaussian prior on the shape, a footprint of about a pixel, as one edge seldom tells S, v and q apart.
void add_prior(NormalEquations& normal, const ReferenceShape& shape, const Unknowns& unknowns);

struct FitSettings {
  Unknowns unknowns{};
  int max_iterations = 8;
  double tolerance = 0.3;         ///< of chi2: ends when a step is expected to gain less, or a short step gained less
  std::size_t every = 1;          ///< takes every so-many-th pixel
  double least_variance = 4e-12;  ///< of a pixel
  std::optional<double> variance{};  ///< of a pixel, when known
  Rounding rounding{};
  bool few_distances = false;  ///< the pixels at each distance from the edge round alike
  NoiseCorrelation correlation{};
  std::vector<double> tails{};  ///< of edges beside the region (edge_region.cpp); empty: none
};
/// The reference step of a model, with the tails that extend into the region.
StepProfile profile_of(const EdgeModel& model, const FitSettings& settings);
/// The highest power of t that the unknowns' derivatives have, at least 1.
int order_of(const Unknowns& unknowns);
NoiseModel noise_of(const EdgeSums& sums, const StepProfile& profile, const FitSettings& settings);

/// What one evaluation of a model tells: profile, sums of the residuals, noise, normal equations.
struct FitState {
  NoiseModel noise;
  NoiseCorrelation correlation;
  StepProfile profile;
  EdgeSums sums;
  BinRow weight{};  ///< of a pixel, by bin
  NormalEquations normal;
};
double chi2_of(const EdgeSums& sums, const BinRow& weight);
/// Weights and equations of a state that has its profile, sums and noise.
void assemble(FitState& state, const EdgeModel& model, const FitSettings& settings);
/// Damped Gauss-Newton steps, each over all pixels; `model` becomes the one of the returned state, `state` is that of
/// the model at the start.
FitState fit_reference(const EdgePixels& pixels, EdgeModel& model, const FitSettings& settings, FitState state);
FitState fit_reference(const EdgePixels& pixels, EdgeModel& model, const FitSettings& settings);
/// Adds a step to the model.
void move(EdgeModel& model, const Vector& step);

/// One pass over the pixels, the model unchanged.
FitState evaluate(const EdgePixels& pixels, const EdgeModel& model, const FitSettings& settings);

}  // namespace calib
