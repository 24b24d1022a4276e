// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil.h"

#include <cmath>

#include "apps/check/families.h"

namespace apps::check {
namespace {

void circular(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("circular_mtf_extremes.csv")) {
    const double nu = number(row, "nu_double_hex");
    const long double exact = precise(row, "mtf_at_double"), allowed = std::min(4e-16L, 1e-14L * exact);
    tally.compare(mtf::circular_pupil_mtf(nu).value, exact, allowed, row.where);
    tally.compare(mtf::annular_pupil_mtf(nu, 0.0).value, exact, allowed, row.where);
  }
}

// nu is an exact decimal in this table: half an ulp of nu times the slope comes on top of the error of the kernel.
void annular(const Tables& tables, Tally& tally) {
  constexpr long double kHalfUlp = 0x1p-53L;
  for (const Row& row : tables.rows("annular_diffraction_mtf.csv")) {
    const double nu = number(row, "nu"), e = number(row, "obscuration");
    const mtf::PupilMtf m = mtf::annular_pupil_mtf(nu, e);
    const long double input = kHalfUlp * nu * std::abs(m.d_nu) + kHalfUlp * e * std::abs(m.d_obscuration);
    tally.compare(m.value, precise(row, "mtf"), std::min(1e-15L + input, 2e-15L), row.where);
  }
}

}  // namespace

std::vector<Check> pupil_checks() {
  return {{"diffraction", "circular", "4e-16 and relative 1e-14", circular},
          {"diffraction", "annular", "1e-15 and the rounding of nu, at most 2e-15", annular}};
}

}  // namespace apps::check
