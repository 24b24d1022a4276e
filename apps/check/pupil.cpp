// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/pupil.h"

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

void annular(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("annular_diffraction_mtf.csv")) {
    const double nu = number(row, "nu_hex"), e = number(row, "obscuration_hex");
    const long double exact = precise(row, "mtf");
    tally.compare(mtf::annular_pupil_mtf(nu, e).value, exact, std::min(2e-15L, 1e-13L * exact), row.where);
  }
}

// A few ulp of terms as large as 1/(1 - e).
void annular_slopes(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("annular_diffraction_mtf.csv")) {
    const double nu = number(row, "nu_hex"), e = number(row, "obscuration_hex");
    const mtf::PupilMtf m = mtf::annular_pupil_mtf(nu, e);
    const long double d_nu = precise(row, "d_nu"), ulp = 1e-15L / (1.0L - e);
    tally.compare(m.d_nu, d_nu, ulp * std::max(1.0L, std::abs(d_nu)), row.where);
    tally.compare(m.d_obscuration, precise(row, "d_obscuration"), ulp, row.where);
  }
}

}  // namespace

std::vector<Check> pupil_checks() {
  return {{"diffraction", "circular", "4e-16 and relative 1e-14", circular},
          {"diffraction", "annular", "2e-15 and relative 1e-13", annular},
          {"diffraction", "annular, slopes", "1e-15 / (1 - e)", annular_slopes}};
}

}  // namespace apps::check
