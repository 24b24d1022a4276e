// SPDX-License-Identifier: Apache-2.0
// The normal equations of a fit, from the sums over the pixels.
#include <algorithm>

#include "calib/measure/edge_fit.h"
#include "mtf/math/clones.h"

namespace calib {
namespace {

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

}  // namespace calib
