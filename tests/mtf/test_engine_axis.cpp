// SPDX-License-Identifier: Apache-2.0
// One axis of the engine: the terms of both resamplings and the chirp, against the sums that they stand for.
#include "mtf/engines/fft/axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

#include "mtf/image.h"

namespace mtf::test {
namespace {

using C = std::complex<double>;

AxisTransform job(Basis basis, std::int64_t length, double ratio, std::int64_t outputs, std::int64_t keep) {
  AxisTransform j;
  j.frequency = {basis, length, 10.0};
  j.samples = length;
  j.outputs = outputs;
  j.pitch_um = 10.0 * ratio;
  const double pitches = static_cast<double>(length) / ratio;
  j.resampling = std::abs(pitches - std::round(pitches)) < 1e-9 ? Resampling::fold : Resampling::chirp;
  if (j.resampling == Resampling::fold) j.out_length = std::llround(pitches);
  j.keep = std::min(keep, j.frequency.half_count());
  return j;
}

TEST(EngineAxis, chirp_evaluates_the_polynomial_at_every_output) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  for (const double ratio : {3.7, M_PI, 0.77, 12.3})
    for (const std::int64_t keep : {1, 7, 400}) {
      const AxisTransform j = job(Basis::fourier, 101, ratio, static_cast<std::int64_t>(101 / ratio), keep);
      const std::int64_t rows = inverse_length(j);
      AlignedBuffer<float> data(static_cast<std::size_t>(rows * kRow));
      std::fill_n(data.data(), data.size(), 0.0F);
      const std::size_t lane = 11;
      std::vector<C> expected(static_cast<std::size_t>(j.outputs));
      double energy = 0.0;
      for (const Term& term : axis_terms(j, Parity::even)) {
        const C g(normal(generator), normal(generator)), in = g * C(term.re, term.im);
        const std::size_t row = static_cast<std::size_t>(term.target) * kRow;
        data[row + lane] += static_cast<float>(in.real());
        data[row + kLanes + lane] += static_cast<float>(in.imag());
        energy += std::norm(g);
        for (std::int64_t o = 0; o < j.outputs; ++o) {
          const double x = (static_cast<double>(o) + 0.5) * ratio - 0.5;  // scene samples from the centre of sample 0
          expected[static_cast<std::size_t>(o)] +=
              g * std::polar(1.0, 2.0 * M_PI * static_cast<double>(term.k) * x / 101.0);
        }
      }
      const Chirp<float> chirp(j, fft::Rigor::estimate);
      chirp.run(data.data());
      for (std::size_t o = 0; o < expected.size(); ++o)
        ASSERT_LT(std::abs(C(data[o * kRow + lane], data[o * kRow + kLanes + lane]) - expected[o]),
                  3e-6 * std::sqrt(energy))
            << ratio << " " << o;
    }
}

TEST(EngineAxis, fold_adds_every_frequency_to_its_alias) {
  for (const Basis basis : {Basis::fourier, Basis::cosine})
    for (const std::int64_t ratio : {1, 2, 3, 4, 6})
      for (const std::int64_t length : {12, 24, 60}) {
        const AxisTransform j = job(basis, length, static_cast<double>(ratio), length / ratio, length);
        for (const Term& term : axis_terms(j, Parity::even))
          for (std::int64_t o = 0; o < j.outputs; ++o) {
            const double at = static_cast<double>(o), out = static_cast<double>(j.out_length);
            const double x = (at + 0.5) * static_cast<double>(ratio), n = static_cast<double>(length);
            if (basis == Basis::fourier) {
              const double weight = 2 * std::abs(term.k) == length ? 0.5 : 1.0;
              const C scene = weight * std::polar(1.0, 2.0 * M_PI * term.k * (x - 0.5) / n);
              const C folded = C(term.re, term.im) * std::polar(1.0, 2.0 * M_PI * term.target * at / out);
              ASSERT_LT(std::abs(scene - folded), 1e-6);
            } else {
              // The inverse doubles every cosine but the zeroth; so does the scene's own sum.
              const double scene = (term.k == 0 ? 1.0 : 2.0) * std::cos(M_PI * term.k * x / n);
              const double doubled = term.target == 0 ? 1.0 : 2.0;
              ASSERT_NEAR(scene, doubled * term.re * std::cos(M_PI * term.target * (at + 0.5) / out), 1e-6);
            }
          }
      }
}

TEST(EngineAxis, a_sine_folds_to_a_cosine_of_alternating_sign) {
  for (const std::int64_t ratio : {1, 2, 3, 4, 6})
    for (const std::int64_t length : {12, 24, 60}) {
      const AxisTransform j = job(Basis::cosine, length, static_cast<double>(ratio), length / ratio, length);
      std::vector<bool> seen(static_cast<std::size_t>(length));
      for (const Term& term : axis_terms(j, Parity::odd)) {
        seen[static_cast<std::size_t>(term.k)] = true;
        ASSERT_EQ(term.otf, term.k);
        for (std::int64_t o = 0; o < j.outputs; ++o) {
          const double at = static_cast<double>(o) + 0.5, out = static_cast<double>(j.out_length);
          const double scene =
              2.0 * std::sin(M_PI * term.k * at * static_cast<double>(ratio) / static_cast<double>(length));
          const double doubled = term.target == 0 ? 1.0 : 2.0, sign = o % 2 == 0 ? 1.0 : -1.0;
          ASSERT_NEAR(scene, sign * doubled * term.re * std::cos(M_PI * term.target * at / out), 1e-6);
        }
      }
      // What has no term is no sine on the detector's samples.
      for (std::int64_t k = 0; k < length; ++k)
        ASSERT_EQ(seen[static_cast<std::size_t>(k)], k % (2 * j.out_length) != 0);
    }
}

TEST(EngineAxis, rotation_keeps_its_accuracy_for_many_turns) {
  for (const std::int64_t whole : {std::int64_t{0}, std::int64_t{1} << 40, -(std::int64_t{1} << 40)}) {
    const Complex<double> r = rotation(static_cast<long double>(whole) + 0.125L);
    EXPECT_NEAR(r.re, std::sqrt(0.5), 1e-15);
    EXPECT_NEAR(r.im, std::sqrt(0.5), 1e-15);
  }
}

}  // namespace
}  // namespace mtf::test
