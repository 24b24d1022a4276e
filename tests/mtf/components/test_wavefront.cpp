// SPDX-License-Identifier: Apache-2.0
// Aberrated pupils against tables made elsewhere, and against a second quadrature in other coordinates.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <complex>

#include "mtf/components/pupil/defocus_pupil.h"
#include "mtf/components/pupil/wavefront_pupil.h"
#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"
#include "tests/mtf/conformance.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

using Cplx = std::complex<double>;

PupilPolynomial fringe(int number) { return zernike_polynomial(ZernikeNumbering::fringe, number); }

// 1e-11 is asked for; the tables are printed to 1e-13 and were made to that.
TEST(WavefrontPupil, every_row_of_the_five_tables) {
  std::int64_t rows = 0;
  for (const char* name : {"defocus", "spherical", "coma", "astigmatism", "mixed"}) {
    const auto check = reference_check("wavefront", name);
    EXPECT_TRUE(check.passed) << check.failure;
    EXPECT_LE(check.worst_abs, 2e-13);
    rows += check.count;
  }
  EXPECT_EQ(rows, 4500);
}

// Second route: rows across the direction of x, each cut into intervals by the edges of both pupils, no caps and no
// inclusion and exclusion. Between the heights where edges meet the rows end like square roots.
Cplx by_rows(const PupilPolynomial& w, const Freq<double>& nu, double e) {
  const double h = std::hypot(nu.x, nu.y);
  const PupilPolynomial turned = rotated(w, nu.x / h, nu.y / h);
  std::vector<double> breaks{0.0};
  const auto add = [&](double square) {
    if (square > 0.0 && square < 1.0) breaks.push_back(std::sqrt(square));
  };
  const double along = h + (1.0 - e * e) / (4.0 * h);
  for (const double square : {1.0 - h * h, e * e - h * h, e * e, 1.0 - along * along}) add(square);
  breaks.push_back(1.0);
  std::sort(breaks.begin(), breaks.end());
  using Interval = std::array<double, 2>;
  const auto pieces = [e](double y, double centre) {
    const double outer = std::sqrt(std::max(1.0 - y * y, 0.0)), inner = std::sqrt(std::max(e * e - y * y, 0.0));
    return std::array<Interval, 2>{{{centre - outer, centre - inner}, {centre + inner, centre + outer}}};
  };
  const GaussRule& rule = gauss_legendre(120);
  Cplx sum{};
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    for (std::size_t k = 0; k < rule.node.size(); ++k) {
      const double middle = 0.5 * (breaks[i] + breaks[i + 1]), half = 0.5 * (breaks[i + 1] - breaks[i]);
      const double t = 0.5 * kPi * rule.node[k], y = middle + half * std::sin(t);
      const double weight = 0.5 * kPi * rule.weight[k] * half * std::cos(t);
      for (const double side : {1.0, -1.0})
        for (const Interval& a : pieces(y, -h))
          for (const Interval& b : pieces(y, h)) {
            const double lo = std::max(a[0], b[0]), hi = std::min(a[1], b[1]);
            if (hi <= lo) continue;
            for (std::size_t m = 0; m < rule.node.size(); ++m) {
              const double x = 0.5 * (lo + hi) + 0.5 * (hi - lo) * rule.node[m];
              const double d = turned(x + h, side * y) - turned(x - h, side * y);
              sum += weight * 0.5 * (hi - lo) * rule.weight[m] * std::polar(1.0, 2.0 * kPi * d);
            }
          }
    }
  return sum / (kPi * (1.0 - e * e));
}

TEST(WavefrontPupil, random_zernike_wavefronts_by_a_second_quadrature) {
  Random random(77);
  for (int i = 0; i < 60; ++i) {
    PupilPolynomial w;
    const auto numbering = i % 2 == 0 ? ZernikeNumbering::fringe : ZernikeNumbering::noll;
    for (int number = 2; number <= 37; ++number)
      w.add(zernike_polynomial(numbering, number), random.uniform(-0.08, 0.08));
    const double e = i % 3 == 0 ? 0.0 : random.uniform(0.05, 0.95), nu = random.uniform(0.02, 0.98),
                 angle = random.uniform(-kPi, kPi);
    const Freq<double> f{nu * std::cos(angle), nu * std::sin(angle)};
    const Complex<double> h = wavefront_pupil_otf(w, f, e);
    EXPECT_LE(std::abs(Cplx(h.re, h.im) - by_rows(w, f, e)), 2e-13 / (1.0 - e * e)) << "e = " << e << " nu = " << nu;
    for (const double accuracy : {1e-4, 1e-6, 1e-8, 1e-10}) {
      const Complex<double> quick = wavefront_pupil_otf(w, f, e, accuracy);
      EXPECT_LE(std::hypot(quick.re - h.re, quick.im - h.im), accuracy) << accuracy;
    }
  }
}

TEST(WavefrontPupil, defocus_alone_is_hopkins_integral) {
  for (const double e : {0.0, 1e-6, 0.3, 0.9, 0.999})
    for (const double waves : {1e-9, 0.01, 1.0, -5.0, 40.0})
      for (const double nu : {1e-12, 1e-3, 0.05, 0.3, 0.35, 0.5, 0.9, 0.999}) {
        PupilPolynomial w;
        w.add(seidel_polynomial(SeidelTerm::w020), waves);
        const Complex<double> h = wavefront_pupil_otf(w, {0.6 * nu, -0.8 * nu}, e);
        EXPECT_NEAR(h.re, defocus_pupil_otf(nu, e, waves).value, 2e-14 / (1.0 - e * e))
            << e << " " << waves << " " << nu;
        EXPECT_EQ(h.im, 0.0);
      }
}

TEST(Zernike, printed_polynomials) {
  const double x = 0.31, y = -0.52, r2 = x * x + y * y, r4 = r2 * r2;
  const std::array<double, 16> list{1.0,
                                    x,
                                    y,
                                    2 * r2 - 1,
                                    x * x - y * y,
                                    2 * x * y,
                                    (3 * r2 - 2) * x,
                                    (3 * r2 - 2) * y,
                                    6 * r4 - 6 * r2 + 1,
                                    x * x * x - 3 * x * y * y,
                                    3 * x * x * y - y * y * y,
                                    (4 * r2 - 3) * (x * x - y * y),
                                    (4 * r2 - 3) * 2 * x * y,
                                    (10 * r4 - 12 * r2 + 3) * x,
                                    (10 * r4 - 12 * r2 + 3) * y,
                                    20 * r4 * r2 - 30 * r4 + 12 * r2 - 1};
  for (std::size_t i = 0; i < list.size(); ++i) EXPECT_NEAR(fringe(static_cast<int>(i) + 1)(x, y), list[i], 1e-15) << i;
  const double z37 =
      924 * r4 * r4 * r4 - 2772 * r4 * r4 * r2 + 3150 * r4 * r4 - 1680 * r4 * r2 + 420 * r4 - 42 * r2 + 1;
  EXPECT_NEAR(fringe(37)(x, y), z37, 1e-13);
  // Noll's table: Z5 = sqrt(6) rho^2 sin 2t, Z8 = sqrt(8) (3 rho^3 - 2 rho) cos t, Z11 = sqrt(5) (6 rho^4 - 6 rho^2 +
  // 1).
  const auto noll = [&](int number) { return zernike_polynomial(ZernikeNumbering::noll, number)(x, y); };
  EXPECT_NEAR(noll(5), std::sqrt(6.0) * 2 * x * y, 1e-15);
  EXPECT_NEAR(noll(6), std::sqrt(6.0) * (x * x - y * y), 1e-15);
  EXPECT_NEAR(noll(8), std::sqrt(8.0) * (3 * r2 - 2) * x, 1e-15);
  EXPECT_NEAR(noll(9), std::sqrt(8.0) * (3 * x * x * y - y * y * y), 1e-15);
  EXPECT_NEAR(noll(11), std::sqrt(5.0) * (6 * r4 - 6 * r2 + 1), 1e-15);
}

TEST(Zernike, fringe_has_unit_peak_and_noll_is_orthonormal) {
  for (int number = 1; number <= 37; ++number) {
    double peak = 0.0;
    for (int i = 0; i < 720; ++i) peak = std::max(peak, std::abs(fringe(number)(cos_pi(i / 360.0), sin_pi(i / 360.0))));
    EXPECT_NEAR(peak, 1.0, 1e-4) << number;
  }
  const GaussRule& rule = gauss_legendre(16);
  constexpr int kSpokes = 32;  // exact for products of degree 24
  const auto mean_product = [&](int a, int b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < rule.node.size(); ++i)
      for (int k = 0; k < kSpokes; ++k) {
        const double r = std::sqrt(0.5 * (1.0 + rule.node[i])), t = 2.0 * k / static_cast<double>(kSpokes);
        sum += 0.5 * rule.weight[i] / kSpokes *
               zernike_polynomial(ZernikeNumbering::noll, a)(r * cos_pi(t), r * sin_pi(t)) *
               zernike_polynomial(ZernikeNumbering::noll, b)(r * cos_pi(t), r * sin_pi(t));
      }
    return sum;
  };
  for (int a = 1; a <= 91; a += 3)
    for (int b = 1; b <= 91; b += 4) EXPECT_NEAR(mean_product(a, b), a == b ? 1.0 : 0.0, 2e-12) << a << " " << b;
  for (int a = 1; a <= 91; ++a) EXPECT_NEAR(mean_product(a, a), 1.0, 2e-12) << a;
}

Component<double> wavefront(const char* field, double waves) {
  auto c = Component<double>::make("wavefront");
  set(c, field, waves);
  return c;
}

// detector(): 4 um, F/1, so nu = f / 250 cy/mm.
TEST(Wavefront, tilt_moves_the_image) {
  const double waves = 0.7, shift_mm = -2.0 * 4e-3 * 1.0 * waves, f = 31.0;
  const Complex<double> h = otf_at(wavefront("w311", waves), f, 12.0),
                        clear = otf_at(Component<double>::make("diffraction"), f, 12.0);
  EXPECT_NEAR(h.re, clear.re * std::cos(2.0 * kPi * f * shift_mm), 1e-14);
  EXPECT_NEAR(h.im, -clear.re * std::sin(2.0 * kPi * f * shift_mm), 1e-14);
  EXPECT_NEAR(otf_at(wavefront("w311", waves), 0.0, 50.0).im, 0.0, 1e-15);
}

TEST(Wavefront, orientation_turns_the_aberration_with_its_frequencies) {
  const auto turned = [](double degrees) {
    auto c = wavefront("w131", 0.4);
    set(c, "orientation", degrees);
    return c;
  };
  for (const double degrees : {30.0, 90.0, 200.0}) {
    const double a = degrees * kPi / 180.0, x = 40.0, y = -25.0;
    const Complex<double> h = otf_at(turned(0.0), x, y), g = otf_at(turned(degrees), x * std::cos(a) - y * std::sin(a),
                                                                    x * std::sin(a) + y * std::cos(a));
    EXPECT_NEAR(h.re, g.re, 1e-13);
    EXPECT_NEAR(h.im, g.im, 1e-13);
  }
}

TEST(Wavefront, one_path_difference_is_fewer_of_longer_waves) {
  auto c = wavefront("w040", 0.5);
  set(c, "wavelength_reference", 2.0);
  System<double> s = detector();
  s.optics.wavelength_um = 4.0;
  const double there = otf_at(c, 60.0, 0.0, s).re;
  EXPECT_EQ(there, otf_at(wavefront("w040", 0.25), 60.0, 0.0, s).re);
}

TEST(Wavefront, what_is_refused) {
  auto c = Component<double>::make("wavefront");
  std::get<Coefficients<double>*>(field(c, "zernike").value)->assign(38, 0.01);
  EXPECT_TRUE(refused(c, "zernike"));
  choose(c, "numbering", 1);
  EXPECT_FALSE(refused(c, "zernike"));
  std::get<Coefficients<double>*>(field(c, "zernike").value)->assign(9, 0.0);
  std::get<Coefficients<double>*>(field(c, "zernike").value)->at(4) = 11.0;
  EXPECT_TRUE(refused(c, "zernike[4]"));
  std::get<Coefficients<double>*>(field(c, "zernike").value)->assign(36, 3.0);
  EXPECT_TRUE(refused(c, ""));  // too steep
  System<double> narrow = detector();
  narrow.optics.obscuration = 0.9995;
  EXPECT_TRUE(refused(wavefront("w040", 0.1), "obscuration", narrow));
}

}  // namespace
}  // namespace mtf::test
