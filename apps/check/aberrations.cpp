// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <sstream>

#include "apps/check/check.h"
#include "mtf/components/pupil/defocus_pupil.h"
#include "mtf/components/pupil/pupil.h"
#include "mtf/components/pupil/wavefront_pupil.h"
#include "mtf/error.h"

namespace apps::check {
namespace {

/// Values: 1e-12 up to 3 waves and 1e-10 beyond; the kernel's own statement is tighter, rounding that grows with the
/// phase k = 8 pi W020 nu over the area of the ring. Slopes are larger by the phase or the waves, and lose another
/// width of the ring.
void defocus(const Tables& tables, const std::string& file, bool slopes, Tally& tally) {
  for (const Row& row : tables.rows(file)) {
    const double w020 = number(row, "w020_hex"), nu = number(row, "nu_hex"), k = 8.0 * std::numbers::pi * w020 * nu;
    const double e = row.cells.contains("obscuration_hex") ? number(row, "obscuration_hex") : 0.0;
    const mtf::DefocusOtf h = mtf::defocus_pupil_otf(nu, e, w020);
    const long double ring = (1.0L - e) * (1.0L + e);
    if (!slopes) {
      const long double asked = w020 <= 3.0 ? 1e-12L : 1e-10L, stated = 2e-15L * (1.0L + k / 8.0L) / ring;
      tally.compare(h.value, precise(row, "otf"), std::min(asked, stated), row.where);
      continue;
    }
    const long double allowed = 1e-14L * (1.0L + k + w020) / (ring * ring);
    tally.compare(h.d_nu, precise(row, "d_nu"), allowed, row.where);
    tally.compare(h.d_w020, precise(row, "d_w020"), allowed, row.where);
    if (e > 0.0) tally.compare(h.d_obscuration, precise(row, "d_obscuration"), allowed, row.where);
  }
}

Check defocus_check(const std::string& name, const std::string& file, bool slopes) {
  return {"defocus", name + (slopes ? ", slopes" : ""),
          slopes ? "1e-14 (1 + phase + waves) / (1 - e^2)^2" : "1e-12 to 3 waves, 1e-10 to 50",
          [file, slopes](const Tables& tables, Tally& tally) { defocus(tables, file, slopes, tally); }};
}

mtf::PupilPolynomial term(const std::string& name, const std::string& where) {
  using mtf::SeidelTerm;
  const auto fringe = [](int number) { return zernike_polynomial(mtf::ZernikeNumbering::fringe, number); };
  if (name == "defocus_W020") return seidel_polynomial(SeidelTerm::w020);
  if (name == "spherical_W040") return seidel_polynomial(SeidelTerm::w040);
  if (name == "coma_W131") return seidel_polynomial(SeidelTerm::w131);
  if (name == "astig_W222") return seidel_polynomial(SeidelTerm::w222);
  if (name == "spherical_Z9") return fringe(9);
  if (name == "coma_Z7") return fringe(7);
  if (name == "astig_Z5") return fringe(5);
  throw mtf::UsageError(where + ": unknown aberration \"" + name + "\"");
}

/// "coma_W131" with its coefficient in waves, or a mixture "defocus_W020=0.5+coma_W131=-0.2".
mtf::PupilPolynomial wavefront(const Row& row) {
  mtf::PupilPolynomial w;
  const auto add = [&](const std::string& name, const std::string& waves) {
    const Row cell{row.where, {{"waves", waves}}};
    w.add(term(name, row.where), number(cell, "waves"));
  };
  const std::string& coefficient = row.at("coefficient_waves");
  if (!row.at("aberration").starts_with("mix")) {
    add(row.at("aberration"), coefficient);
    return w;
  }
  std::istringstream terms(coefficient);
  for (std::string each; std::getline(terms, each, '+');) {
    const std::size_t equals = std::min(each.find('='), each.size() - 1);
    add(each.substr(0, equals), each.substr(equals + 1));
  }
  return w;
}

/// Degrees from x towards y.
double direction(const Row& row) {
  const std::string& text = row.at("direction");
  if (text == "x" || text == "any") return 0.0;
  if (text == "y") return 90.0;
  const std::size_t unit = text.find("deg");
  const Row cell{row.where, {{"direction", text.substr(0, unit)}}};
  return number(cell, "direction");
}

void aberrated(const Tables& tables, const std::string& file, Tally& tally) {
  for (const Row& row : tables.rows(file)) {
    const double nu = number(row, "nu"), angle = direction(row) * std::numbers::pi / 180.0;
    const mtf::Complex<double> h = mtf::wavefront_pupil_otf(
        wavefront(row), {nu * std::cos(angle), nu * std::sin(angle)}, number(row, "obscuration"));
    const std::complex<long double> exact(precise(row, "otf_real"), precise(row, "otf_imag"));
    tally.error(std::abs(std::complex<long double>(h.re, h.im) - exact), std::abs(exact), 2e-13L, row.where);
  }
}

Check aberration_check(const std::string& name) {
  return {"wavefront", name, "2e-13",
          [file = "otf_" + name + ".csv"](const Tables& tables, Tally& tally) { aberrated(tables, file, tally); }};
}

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

std::vector<Check> aberration_checks() {
  std::vector<Check> checks;
  for (const bool slopes : {false, true}) {
    checks.push_back(defocus_check("clear, to 50 waves", "defocus_circular.csv", slopes));
    checks.push_back(defocus_check("annular, to 10 waves", "defocus_annular.csv", slopes));
  }
  for (const char* name : {"defocus", "spherical", "coma", "astigmatism", "mixed"})
    checks.push_back(aberration_check(name));
  return checks;
}

std::vector<Check> pupil_checks() {
  return {{"diffraction", "circular", "4e-16 and relative 1e-14", circular},
          {"diffraction", "annular", "2e-15 and relative 1e-13", annular},
          {"diffraction", "annular, slopes", "1e-15 / (1 - e)", annular_slopes}};
}

}  // namespace apps::check
