// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/turbulence.h"

#include <limits>

#include "apps/check/families.h"

namespace apps::check {
namespace {

// v, w rounded to double, the power and the bracket: a few units in the last place of the exponent.
void compare(const Row& row, double v, double w, double alpha, Tally& tally) {
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  const mtf::KolmogorovExponent e = mtf::kolmogorov_exponent(v, w, alpha);
  for (const auto& [column, c] :
       {std::pair{"otf_coeff_exact", mtf::Turbulence<double>::kExact}, {"otf_coeff_3_44", 3.44}}) {
    const auto exact = static_cast<double>(precise(row, column));
    const double full = c * std::pow(v, 5.0 / 3.0);
    tally.compare(std::exp(-c * e.value), exact, 4.0 * kRounding * exact * (1.0 + 2.0 * full) + 5e-324, row.where);
  }
}

void long_exposure(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("kolmogorov_long_exposure.csv")) compare(row, number(row, "u"), 0.0, 0.0, tally);
}

void short_exposure(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("kolmogorov_short_exposure.csv")) {
    const double nu = number(row, "nu");
    compare(row, nu * number(row, "D_over_r0"), nu, number(row, "alpha"), tally);
  }
}

}  // namespace

std::vector<Check> turbulence_checks() {
  const std::string promise = "4 ulp x (1 + 2 |exponent|)";
  return {{"turbulence", "long exposure", promise, long_exposure},
          {"turbulence", "short exposure", promise, short_exposure}};
}

}  // namespace apps::check
