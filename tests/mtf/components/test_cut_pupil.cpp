// SPDX-License-Identifier: Apache-2.0
// Pupils cut by a rim against those of the whole pupil and against a second quadrature, in rows.
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>

#include "mtf/components/pupil/cut_pupil.h"
#include "mtf/components/wavefront.h"
#include "tests/expect_error.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

PupilPolynomial aberrations() {
  PupilPolynomial w;
  w.add(seidel_polynomial(SeidelTerm::w040), 0.25);
  w.add(seidel_polynomial(SeidelTerm::w131), 0.7);
  w.add(seidel_polynomial(SeidelTerm::w222), 1.0);
  w.add(zernike_polynomial(ZernikeNumbering::fringe, 8), 0.1);
  return w;
}

Complex<double> cut_otf(const PupilPolynomial& w, const Freq<double>& nu, double e, const PupilRim<double>& rim) {
  WavePolynomial<double> waves;
  waves.add(w, 1.0);
  return cut_pupil_otf<double>(waves, nu, e, rim);
}

TEST(CutPupil, an_idle_rim_leaves_the_pupil) {
  for (const double e : {0.0, 0.3})
    for (const Freq<double>& nu :
         {Freq<double>{0.1, 0.0}, {0.2, 0.15}, {0.0, -0.45}, {0.6, -0.3}, {1e-9, 0.0}, {0.9, 0.4}}) {
      const Complex<double> whole = wavefront_pupil_otf(aberrations(), nu, e),
                            same = cut_otf(aberrations(), nu, e, {1.5, 0.5});
      EXPECT_NEAR(same.re, whole.re, 2e-13);
      EXPECT_NEAR(same.im, whole.im, 2e-13);
    }
}

// Rows at heights of a midpoint rule, each cut by the circles: 3e-6 by its ends, like square roots.
std::complex<double> by_rows(const PupilPolynomial& w, const Freq<double>& nu, double e, const PupilRim<double>& rim) {
  constexpr int kRows = 20000;
  const GaussRule& rule = gauss_legendre(24);
  const auto integral = [&](bool overlap) {
    std::complex<double> sum{};
    for (int j = 0; j < kRows; ++j) {
      const double y = 2.0 * (j + 0.5) / kRows - 1.0;
      std::vector<double> ends;
      double lo = -2.0, hi = 2.0;
      std::vector<std::array<double, 2>> holes;
      for (const double side : overlap ? std::vector{-1.0, 1.0} : std::vector{0.0}) {
        const auto chord = [&](double x, double r) {
          const double v = y - side * nu.y, half = std::sqrt(std::max(0.0, r * r - v * v));
          return std::array{x + side * nu.x - half, x + side * nu.x + half};
        };
        for (const auto& c : {chord(0.0, 1.0), chord(rim.shift, rim.radius)})
          lo = std::max(lo, c[0]), hi = std::min(hi, c[1]);
        holes.push_back(chord(0.0, e));
      }
      ends = {lo, hi};
      for (const auto& hole : holes)
        for (const double end : hole)
          if (end > lo && end < hi) ends.push_back(end);
      std::ranges::sort(ends);
      for (std::size_t i = 0; hi > lo && i + 1 < ends.size(); ++i) {
        const double middle = 0.5 * (ends[i] + ends[i + 1]), half = 0.5 * (ends[i + 1] - ends[i]);
        if (std::ranges::any_of(holes, [&](const auto& hole) { return middle > hole[0] && middle < hole[1]; }))
          continue;
        for (std::size_t k = 0; k < rule.node.size(); ++k) {
          const double x = middle + half * rule.node[k];
          const double cycles = overlap ? w(x + nu.x, y + nu.y) - w(x - nu.x, y - nu.y) : 0.0;
          sum += half * rule.weight[k] * std::polar(2.0 / kRows, 2.0 * kPi * cycles);
        }
      }
    }
    return sum;
  };
  return integral(true) / integral(false);
}

TEST(CutPupil, equals_rows) {
  for (const double e : {0.0, 0.3})
    for (const PupilRim<double>& rim : {PupilRim<double>{1.05, 0.5}, {0.95, 0.7}, {0.8, -0.1}, {1.2, -0.9}})
      for (const Freq<double>& nu : {Freq<double>{0.1, 0.0}, {0.2, 0.15}, {0.0, 0.45}, {0.5, -0.3}}) {
        const std::complex<double> slow = by_rows(aberrations(), nu, e, rim);
        const Complex<double> h = cut_otf(aberrations(), nu, e, rim);
        EXPECT_NEAR(h.re, slow.real(), 5e-6) << e << " " << rim.radius << " " << nu.x;
        EXPECT_NEAR(h.im, slow.imag(), 5e-6) << e << " " << rim.radius << " " << nu.x;
      }
}

TEST(CutPupil, half_its_diameter_is_the_cutoff) {
  for (const PupilRim<double>& rim :
       {PupilRim<double>{1.05, 0.5}, {0.95, 0.7}, {0.8, -0.1}, {1.2, -0.9}, {1.05, 0.1}}) {
    double reach = 0.0;  // the farthest overlap over all directions
    for (int k = 0; k < 720; ++k) {
      const double a = kPi * k / 720.0;
      double lo = 0.0, hi = 1.0;
      while (hi - lo > 1e-9) {
        const double nu = 0.5 * (lo + hi);
        (cut_otf({}, {nu * std::cos(a), nu * std::sin(a)}, 0.0, rim).re > 0.0 ? lo : hi) = nu;
      }
      reach = std::max(reach, lo);
    }
    EXPECT_NEAR(rim.half_diameter(), reach, 1e-5) << rim.radius;
    EXPECT_GE(rim.half_diameter(), reach - 1e-9);
  }
}

TEST(CutPupil, WhatMakesNoPupilIsRefused) {
  auto c = Component<double>::make("wavefront");
  set(c, "vignetting_rim", 1.05);
  EXPECT_TRUE(refused(c, "vignetting_shift"));
  set(c, "vignetting_shift", 2.1);
  EXPECT_TRUE(refused(c, "vignetting_shift"));
  set(c, "vignetting_shift", 0.5);
  EXPECT_FALSE(refused(c, "vignetting_shift"));
}

}  // namespace
}  // namespace mtf::test
