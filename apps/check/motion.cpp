// SPDX-License-Identifier: Apache-2.0

// Fresnel integrals, and the OTF of accelerated motion that they give.

#include <cmath>

#include "apps/check/families.h"
#include "mtf/components/chirp.h"
#include "mtf/math/fresnel.h"

namespace apps::check {
namespace {

void fresnel(const Tables& tables, Tally& tally) {
  constexpr long double allowed = 5e-16L;
  for (const Row& row : tables.rows("fresnel_integrals.csv"))
    for (const double sign : {1.0, -1.0}) {
      const mtf::FresnelIntegrals f = mtf::fresnel(sign * number(row, "u_hex"));
      tally.compare(sign * f.c.value, precise(row, "c"), allowed, row.where);
      tally.compare(sign * f.s.value, precise(row, "s"), allowed, row.where);
    }
}

void chirp(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("accelerated_motion.csv")) {
    const mtf::ChirpMean h = mtf::chirp_mean(number(row, "d_hex"), number(row, "b_hex"));
    const auto compare = [&](const mtf::Complex<double>& value, const std::string& by, long double allowed) {
      const long double re = precise(row, "re" + by), im = precise(row, "im" + by);
      tally.error(std::hypot(value.re - re, value.im - im), std::hypot(re, im), allowed, row.where);
    };
    compare(h.value, "", 5e-16L);
    compare(h.by_d, "_by_d", 1e-15L);
    compare(h.by_b, "_by_b", 1e-15L);
  }
}

}  // namespace

std::vector<Check> motion_checks() {
  return {{"accelerated_motion", "Fresnel integrals", "5e-16", fresnel},
          {"accelerated_motion", "mean phase and slopes", "5e-16, slopes 1e-15", chirp}};
}

}  // namespace apps::check
