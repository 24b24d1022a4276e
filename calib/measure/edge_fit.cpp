// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "mtf/math/clones.h"

namespace calib {
namespace {

// The normal equations of a fit, from the sums over the pixels.

// A range of bins, in multiples of kLot.
struct Range {
  std::size_t first, end;
};

[[gnu::always_inline]] inline double total(std::array<double, kLot>& sum) {
  for (std::size_t half = kLot / 2; half > 0; half /= 2)
    for (std::size_t k = 0; k < half; ++k) sum[k] += sum[k + half];
  return sum[0];
}

// Sums of a b c over a range of bins, for a few c: a b is computed once.
constexpr std::size_t kFew = 4;
using Few = std::array<const BinRow*, kFew>;
MTFKIT_CLONES std::array<double, kFew> sums_of_products(const BinRow& a, const BinRow& b, const Few& c, Range range) {
  const BinRow &c0 = *c[0], &c1 = *c[1], &c2 = *c[2], &c3 = *c[3];
  std::array<double, kLot> sum0{}, sum1{}, sum2{}, sum3{};
  for (std::size_t i = range.first; i < range.end; i += kLot)
    for (std::size_t k = 0; k < kLot; ++k) {
      const double product = a[i + k] * b[i + k];
      sum0[k] += product * c0[i + k];
      sum1[k] += product * c1[i + k];
      sum2[k] += product * c2[i + k];
      sum3[k] += product * c3[i + k];
    }
  return {total(sum0), total(sum1), total(sum2), total(sum3)};
}

MTFKIT_CLONES double sum_of_products(const BinRow& a, const BinRow& b, Range range = {0, kBins}) {
  std::array<double, kLot> sum{};
  for (std::size_t i = range.first; i < range.end; i += kLot)
    for (std::size_t k = 0; k < kLot; ++k) sum[k] += a[i + k] * b[i + k];
  return total(sum);
}

MTFKIT_CLONES void multiply(const BinRow& a, const BinRow& b, BinRow& product, Range range) {
  for (std::size_t i = range.first; i < range.end; ++i) product[i] = a[i] * b[i];
}

// The steps that follow from them.

// Bounds of a step.
struct Box {
  Vector low = Vector::Constant(-INFINITY), high = Vector::Constant(INFINITY);
  bool holds(const Vector& step) const { return (step.array() >= low.array() && step.array() <= high.array()).all(); }
};

Box parameter_bounds(const ReferenceShape& shape) {
  constexpr double kMostFootprint_px2 = 64.0;
  Box box;
  box.low.tail<kShapes>() << -shape.s_px, kLeastVariance_px2 - shape.v_px2, -shape.q_px2;
  box.high[kFirstShape + 2] = kMostFootprint_px2 - shape.q_px2;
  return box;
}

// Steps that the linear model can be trusted for, in parts of the whole blur.
Box trusted(const ReferenceShape& shape) {
  const double blur_px2 = shape.blur_px2();
  const double blur_px = std::sqrt(blur_px2);
  Box box;
  box.high.segment<kHighestOrder + 1>(kFirstShift).setConstant(2.0 + 3.0 * blur_px);
  box.high.tail<kShapes>() << 0.2 + blur_px, 0.05 + 1.5 * blur_px2, 0.5 + 6.0 * blur_px2;
  box.low = -box.high;
  // Both together must not leave an edge so sharp that no pixel lies on it.
  box.low[kFirstShape + 1] = -0.7 * blur_px2;
  box.low[kFirstShape + 2] = -0.5 - 0.7 * shape.q_px2;
  return box;
}

// Damped least squares within bounds: the unknown that would exceed its bound most is put on it, and the others are
// solved for again.
Vector solve_within(const NormalEquations& normal, const Unknowns& unknowns, const Box& box, double damping) {
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kUnknowns, kUnknowns>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kUnknowns, 1>;
  Vector step = Vector::Zero();
  Unknowns free = unknowns;
  while (free.any()) {
    std::array<int, kUnknowns> list{};
    int n = 0;
    for (int a = 0; a < kUnknowns; ++a)
      if (free[static_cast<std::size_t>(a)]) list[static_cast<std::size_t>(n++)] = a;
    Small m(n, n);
    SmallVector r(n), scale(n);
    const Vector rest = normal.gradient - normal.matrix * step;  // after the unknowns on their bounds
    for (int i = 0; i < n; ++i) {
      const double diagonal = normal.matrix(list[i], list[i]);
      scale[i] = diagonal > 0.0 ? 1.0 / std::sqrt(diagonal) : 0.0;
      r[i] = scale[i] * rest[list[i]];
      for (int j = 0; j <= i; ++j) m(i, j) = m(j, i) = scale[i] * scale[j] * normal.matrix(list[i], list[j]);
      m(i, i) += 1e-13 + (list[i] >= kFirstShift ? damping : 0.0);
    }
    const SmallVector x = m.ldlt().solve(r);
    int worst = -1;
    double excess = 0.0, bound = 0.0;
    for (int i = 0; i < n; ++i) {
      const double value = std::isfinite(x[i]) ? x[i] * scale[i] : 0.0;
      const double inside = std::clamp(value, box.low[list[i]], box.high[list[i]]);
      if (const double beyond = std::abs(value - inside) / std::max(scale[i], 1e-300); beyond > excess)
        excess = beyond, worst = list[i], bound = inside;
    }
    if (worst < 0) {
      for (int i = 0; i < n; ++i) step[list[i]] = std::isfinite(x[i]) ? x[i] * scale[i] : 0.0;
      break;
    }
    step[worst] = bound;
    free.reset(static_cast<std::size_t>(worst));
  }
  return step;
}

// The least damped step that can be trusted.
Vector next_step(const NormalEquations& normal, const EdgeModel& model, const Unknowns& unknowns, double& damping) {
  const Box bounds = parameter_bounds(model.shape), trust = trusted(model.shape);
  for (;; damping = std::max(1e-4, 2.0 * damping)) {
    const Vector step = solve_within(normal, unknowns, bounds, damping);
    if (damping > 1e6 || (trust.holds(step) && normal.gradient.dot(step) >= 0.0)) return step;
  }
}

double pixels_of(const EdgeSums& sums) { return std::accumulate(sums.moment(0).begin(), sums.moment(0).end(), 0.0); }

// The prior of the footprint.
constexpr double kMean_px2 = 0.75, kSd_px2 = 0.5;

// The prior's part of the cost.
double misfit_of(const ReferenceShape& shape, const Unknowns& unknowns) {
  const double off = (shape.q_px2 - kMean_px2) / kSd_px2;
  return unknowns[kFirstShape + 2] ? off * off : 0.0;
}

/// Whether the unknowns have square terms of the plateaus: sums of powers above t are needed in all bins then.
bool has_curvature(const Unknowns& unknowns) {
  for (std::size_t a = kFirstCurvature; a < kPlateauTerms; ++a)
    if (unknowns[a]) return true;
  return false;
}

}  // namespace

int order_of(const Unknowns& unknowns) {
  int order = kHighestOrder;
  while (order > 1 && !unknowns[static_cast<std::size_t>(kFirstShift + order)]) --order;
  return has_curvature(unknowns) ? std::max(2, order) : order;
}

int basis_power(int a) {
  if (a < kFirstShift) return plateau_powers(a).t;
  return a < kFirstShape ? a - kFirstShift : 0;
}

Basis::Basis(const StepProfile& profile, double contrast, const Unknowns& unknowns)
    : profile_(profile), contrast_(contrast) {
  for (std::size_t i = 0; i < kBins; ++i) {
    reference_dark_[i] = 1.0 - profile.reference_esf()[i];
    dark_[0][i] = 1.0 - profile.esf()[i];
    bright_[0][i] = profile.esf()[i];
  }
  const BinRow& centre = DistanceBins::get().centres();
  const std::size_t most = has_curvature(unknowns) ? 2 : unknowns[2] || unknowns[3] ? 1 : 0;
  for (std::size_t power = 1; power <= most; ++power)
    for (std::size_t i = 0; i < kBins; ++i) {
      dark_[power][i] = dark_[power - 1][i] * centre[i];
      bright_[power][i] = bright_[power - 1][i] * centre[i];
    }
}

const BinRow& Basis::row(int a) const {
  if (a >= kFirstShape) return profile_.slope(static_cast<std::size_t>(a - kFirstShape));
  // The response is made of the reference and its changes; what turns, bends or shades the edge acts on the step.
  if (a >= kFirstShift) return a == kFirstShift ? profile_.reference_lsf() : profile_.lsf();
  if (a < 2) return a == 0 ? reference_dark_ : profile_.reference_esf();
  return (a % 2 == 0 ? dark_ : bright_)[static_cast<std::size_t>(plateau_powers(a).d)];
}

double Basis::scale(int a) const {
  if (a >= kFirstShape) return contrast_;
  return a >= kFirstShift ? -contrast_ : 1.0;
}

double chi2_of(const EdgeSums& sums, const BinRow& weight) { return sum_of_products(sums.square(), weight); }

void assemble(FitState& state, const EdgeModel& model, const FitSettings& settings) {
  const EdgeSums& sums = state.sums;
  state.correlation = settings.correlation;
  NormalEquations& normal = state.normal = {};
  state.weight = pixel_weights(sums, model, state.profile, state.noise, settings.rounding, settings.few_distances);
  normal.chi2 = chi2_of(sums, state.weight);
  const Range everywhere{0, kBins},
      bent{static_cast<std::size_t>(state.profile.bend_first), static_cast<std::size_t>(state.profile.bend_end)};
  BinRow ratio;  // of the noise's variance to what the weight counts as it
  multiply(state.weight, variances(state.noise, state.profile), ratio, everywhere);
  normal.count = sum_of_products(sums.moment(0), ratio);
  const int order = order_of(settings.unknowns);
  std::array<BinRow, 2 * kHighestOrder + 1> moment;  // weighted sums, as the next
  std::array<BinRow, kHighestOrder + 1> residual;
  for (int k = 0; k <= 2 * order; ++k)
    multiply(state.weight, sums.moment(k), moment[static_cast<std::size_t>(k)], k < 3 ? everywhere : bent);
  for (int k = 0; k <= order; ++k)
    multiply(state.weight, sums.residual(k), residual[static_cast<std::size_t>(k)], k < 2 ? everywhere : bent);

  struct List {
    std::array<int, kUnknowns> unknown{};
    std::size_t size = 0;
  };
  std::array<List, kHighestOrder + 1> by_power;  // those of one power share a moment
  for (int a = 0; a < kUnknowns; ++a) {
    if (!settings.unknowns[static_cast<std::size_t>(a)]) continue;
    List& list = by_power[static_cast<std::size_t>(basis_power(a))];
    list.unknown[list.size++] = a;
  }
  const Basis basis(state.profile, model.contrast(), settings.unknowns);
  for (int a = 0; a < kUnknowns; ++a) {
    if (!settings.unknowns[static_cast<std::size_t>(a)]) continue;
    const auto p = static_cast<std::size_t>(basis_power(a));
    normal.gradient[a] = basis.scale(a) * sum_of_products(basis.row(a), residual[p], is_bend(a) ? bent : everywhere);
    for (std::size_t q = 0; q <= p; ++q) {
      const Range range = is_bend(a) || q > 1 ? bent : everywhere;
      const auto& [list, size] = by_power[q];
      for (std::size_t from = 0; from < size; from += kFew) {
        Few few;
        for (std::size_t k = 0; k < kFew; ++k) few[k] = &basis.row(list[std::min(from + k, size - 1)]);
        const auto found = sums_of_products(basis.row(a), moment[p + q], few, range);
        for (std::size_t k = 0; k < std::min(kFew, size - from); ++k) {
          const int b = list[from + k];
          normal.matrix(a, b) = normal.matrix(b, a) = basis.scale(a) * basis.scale(b) * found[k];
        }
      }
    }
  }
}

void move(EdgeModel& model, const Vector& step) {
  for (int a = 0; a < kPlateauTerms; ++a) model.plateau[static_cast<std::size_t>(a)] += step[a];
  EdgeCurve& curve = model.curve;
  const Point n = curve.normal();
  curve.origin.x += n.x * step[kFirstShift];
  curve.origin.y += n.y * step[kFirstShift];
  // A curve that gains u = c t has its normal turned towards -t.
  curve.angle_rad =
      std::remainder(curve.angle_rad - std::atan(step[kFirstShift + 1] / curve.half_length_px), 2.0 * std::numbers::pi);
  if (curve.shape == EdgeCurve::Shape::circle)
    curve.curvature_per_px += 2.0 * step[kFirstShift + 2] / (curve.half_length_px * curve.half_length_px);
  for (std::size_t k = 0; k < curve.coefficient.size(); ++k)
    curve.coefficient[k] += step[kFirstShift + 2 + static_cast<int>(k)];
  model.shape.s_px = std::max(0.0, model.shape.s_px + step[kFirstShape]);
  model.shape.v_px2 = std::max(kLeastVariance_px2, model.shape.v_px2 + step[kFirstShape + 1]);
  model.shape.q_px2 = std::max(0.0, model.shape.q_px2 + step[kFirstShape + 2]);
}

void add_prior(NormalEquations& normal, const ReferenceShape& shape, const Unknowns& unknowns) {
  constexpr int q = kFirstShape + 2;
  if (!unknowns[q]) return;
  normal.matrix(q, q) += 1.0 / (kSd_px2 * kSd_px2);
  normal.gradient[q] += (kMean_px2 - shape.q_px2) / (kSd_px2 * kSd_px2);
}

NoiseModel noise_of(const EdgeSums& sums, const StepProfile& profile, const FitSettings& settings) {
  if (settings.variance) return {.dark = *settings.variance, .bright = *settings.variance};
  return estimate_noise(sums, profile, settings.least_variance, settings.rounding);
}

StepProfile profile_of(const EdgeModel& model, const FitSettings& settings) {
  StepProfile profile(tabulate(model.shape, model.curve.angle_rad));
  if (has_curvature(settings.unknowns)) profile.bend_everywhere();
  if (settings.tails.empty()) return profile;
  BinRow per_s;
  for (std::size_t i = 0; i < kBins; ++i) per_s[i] = settings.tails[i] / model.contrast();
  profile.add_per_s(per_s, model.shape.s_px);
  return profile;
}

FitState evaluate(const EdgePixels& pixels, const EdgeModel& model, const FitSettings& settings) {
  FitState state;
  state.profile = profile_of(model, settings);
  state.sums = accumulate(pixels, model, state.profile, order_of(settings.unknowns), settings.every);
  state.noise = noise_of(state.sums, state.profile, settings);
  assemble(state, model, settings);
  return state;
}

FitState fit_reference(const EdgePixels& pixels, EdgeModel& model, const FitSettings& settings) {
  return fit_reference(pixels, model, settings, evaluate(pixels, model, settings));
}

FitState fit_reference(const EdgePixels& pixels, EdgeModel& model, const FitSettings& settings, FitState state) {
  double damping = 0.0;
  for (int round = 1; round <= settings.max_iterations; ++round) {
    NormalEquations normal = state.normal;
    add_prior(normal, model.shape, settings.unknowns);
    const Vector step = next_step(normal, model, settings.unknowns, damping);
    const double expected = normal.gradient.dot(step);
    if (expected < settings.tolerance || round == settings.max_iterations) break;
    EdgeModel next = model;
    move(next, step);
    FitState tried = evaluate(pixels, next, settings);
    // Pixels beyond the range do not count in chi2: an edge that moves away from them fits no better.
    constexpr double kKept = 0.7;
    const double more = chi2_of(tried.sums, state.weight) - state.normal.chi2;
    const bool better = more <= 2.0 && pixels_of(tried.sums) >= kKept * pixels_of(state.sums);
    // Steps between shapes that hardly differ may alternate without gaining anything.
    constexpr double kShort = 10.0;
    const double gained = misfit_of(model.shape, settings.unknowns) - misfit_of(next.shape, settings.unknowns) - more;
    const bool idle = expected < kShort * settings.tolerance && gained < settings.tolerance;
    damping = better ? 0.1 * damping : std::max(1e-4, 30.0 * damping);
    if (damping < 1e-6) damping = 0.0;
    if (better && !(idle && gained < 0.0)) model = next, state = std::move(tried);
    if (idle) break;
  }
  return state;
}

}  // namespace calib
