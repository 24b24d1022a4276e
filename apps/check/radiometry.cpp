// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cfloat>
#include <cmath>

#include "apps/check/check.h"
#include "radiometry/light/blackbody.h"

namespace apps::check {
namespace {

using radiometry::Flux;

constexpr long double kRelative = 2e-15L;
/// Two of the smallest doubles: what underflow leaves.
constexpr long double kSmallest = 2.0L * static_cast<long double>(DBL_TRUE_MIN);

struct Values {
  double radiance, derivative, log_radiance;
};

/// Radiances span hundreds of decades: errors are relative to the value, of logarithms to 1 + |value|.
void compare(const Row& row, const Values& values, Tally& tally) {
  const auto relative = [&](double value, long double exact) {
    const long double error = std::max(0.0L, std::abs(value - exact) - kSmallest);
    tally.error(error == 0.0L ? 0.0L : error / std::abs(exact), 1.0L, kRelative, row.where);
  };
  relative(values.radiance, precise(row, "radiance"));
  relative(values.derivative, precise(row, "derivative"));
  const long double log_radiance = precise(row, "log_radiance");
  tally.error(std::abs(values.log_radiance - log_radiance) / (1.0L + std::abs(log_radiance)), 1.0L, kRelative,
              row.where);
}

Flux flux_of(const Row& row) { return row.at("flux") == "watts" ? Flux::watts : Flux::photons; }

void planck(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("planck.csv")) {
    const Flux flux = flux_of(row);
    const double w = number(row, "wavelength_um_hex"), t = number(row, "temperature_k_hex");
    compare(
        row,
        {radiometry::planck(flux, w, t), radiometry::planck_derivative(flux, w, t), radiometry::log_planck(flux, w, t)},
        tally);
  }
}

void bands(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("planck_bands.csv")) {
    const Flux flux = flux_of(row);
    const double lo = number(row, "lo_um_hex"), hi = number(row, "hi_um_hex"), t = number(row, "temperature_k_hex");
    compare(row,
            {radiometry::band_radiance(flux, lo, hi, t), radiometry::band_derivative(flux, lo, hi, t),
             radiometry::log_band_radiance(flux, lo, hi, t)},
            tally);
  }
}

}  // namespace

std::vector<Check> radiometry_checks() {
  return {{"blackbody", "Planck's law, 1 K to 1e9 K", "2e-15 relative", planck},
          {"blackbody", "in bands", "2e-15 relative", bands}};
}

}  // namespace apps::check
