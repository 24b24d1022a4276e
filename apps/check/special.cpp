// SPDX-License-Identifier: Apache-2.0
#include "mtf/math/special.h"

#include <algorithm>
#include <limits>

#include "apps/check/check.h"

namespace apps::check {
namespace {

constexpr long double kUlp = std::numeric_limits<double>::epsilon();

void sinc(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("sinc_extremes.csv")) {
    const long double exact = precise(row, "sinc_pi_x");
    tally.compare(mtf::sinc(number(row, "x_hex")).value, exact, 4.0L * kUlp * std::abs(exact), row.where);
  }
}

void gaussian(const Tables& tables, Tally& tally) {
  constexpr double smallest = std::numeric_limits<double>::denorm_min();
  for (const Row& row : tables.rows("gaussian_extremes.csv")) {
    const double value = mtf::gaussian(number(row, "sigma_f_hex")).value;
    const long double exact = precise(row, "mtf");
    tally.compare(value, exact, 4.0L * kUlp * exact + smallest, row.where);
    if (row.at("double_underflow") == "zero") tally.compare(value, 0.0L, smallest, row.where);
  }
}

/// 4 ulp of max(|J(x)|, sqrt(2 / (pi x))): near a zero no more digits than the envelope has.
long double bessel_error(double x, long double exact) {
  const long double envelope = std::sqrt(2.0L / (std::numbers::pi_v<long double> * std::max(x, 1.0)));
  return 4.0L * kUlp * std::max(std::abs(exact), envelope);
}

void bessel_j0(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("bessel_j_extremes.csv")) {
    const double x = number(row, "x_hex");
    const long double exact = precise(row, "j0");
    tally.compare(mtf::bessel_j0(x).value, exact, bessel_error(x, exact), row.where);
  }
}

void jinc(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("bessel_j_extremes.csv")) {
    const double x = number(row, "x_hex");
    const long double exact = precise(row, "two_j1_over_x");
    const long double allowed =
        x < 3.0 ? 4.0L * kUlp * exact : 2.0L / x * bessel_error(x, precise(row, "j1")) + kUlp * std::abs(exact);
    tally.compare(mtf::jinc(x).value, exact, allowed, row.where);
  }
}

// J0 and 2 J1/x to what their oscillation leaves between the zeros; slopes to 12 ulp of 1, since they are differences
// of terms of that size over a small x.
void dense(const Tables& tables, std::string_view function, Tally& tally) {
  constexpr double smallest = std::numeric_limits<double>::denorm_min();
  for (const Row& row : tables.rows("elementary.csv")) {
    if (row.at("function") != function) continue;
    const double x = number(row, "x_hex");
    const mtf::ValueSlope f = function == "sinc"       ? mtf::sinc(x)
                              : function == "gaussian" ? mtf::gaussian(x)
                              : function == "j0"       ? mtf::bessel_j0(x)
                                                       : mtf::jinc(x);
    const long double value = precise(row, "value"), slope = precise(row, "slope");
    const long double allowed = function == "j0" ? bessel_error(x, value)
                                : function == "jinc"
                                    ? std::max(bessel_error(x, 0.0L) / std::max(x, 1.0), 4.0L * kUlp * std::abs(value))
                                    : 4.0L * kUlp * std::abs(value);
    tally.compare(f.value, value, allowed + smallest, row.where);
    tally.compare(f.slope, slope, function == "j0" ? bessel_error(x, slope) : 12.0L * kUlp, row.where);
  }
}

Check dense_check(const std::string& component, const std::string& name, const std::string& function) {
  return {component, name, "4 ulp, or of the envelope; slopes 12 ulp of 1",
          [function](const Tables& tables, Tally& tally) { dense(tables, function, tally); }};
}

}  // namespace

std::vector<Check> special_checks() {
  return {{"footprint", "sinc", "4 ulp", sinc},
          {"gaussian", "Gaussian", "4 ulp", gaussian},
          {"vibration", "J0", "4 ulp of max(|J0|, sqrt(2/(pi x)))", bessel_j0},
          {"circular_footprint", "2 J1(x)/x", "4 ulp; from x = 3 on of the envelope", jinc},
          dense_check("footprint", "sinc and slope", "sinc"),
          dense_check("gaussian", "Gaussian and slope", "gaussian"),
          dense_check("vibration", "J0 and slope, to 1e8", "j0"),
          dense_check("circular_footprint", "2 J1(x)/x and slope", "jinc")};
}

}  // namespace apps::check
