// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/unsharp.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> unsharp(double amount, int size) {
  auto c = Component<double>::make("unsharp");
  set(c, "amount", amount);
  set(c, "size", size);
  return c;
}

Component<double> unsharp_gaussian(double amount, double sigma_px) {
  auto c = unsharp(amount, 3);
  set(c, "sigma", sigma_px);
  return c;
}

/// 1 + amount (1 - blur) as a kernel, blur = outer product of `tap`(k) for |k| <= reach, made to sum to 1.
template <class Tap>
Component<double> kernel(double amount, int reach, Tap tap) {
  double sum = 0.0;
  for (int k = -reach; k <= reach; ++k) sum += tap(k);
  Taps<double> taps;
  for (int j = -reach; j <= reach; ++j) {
    taps.emplace_back();
    for (int k = -reach; k <= reach; ++k)
      taps.back().push_back((j == 0 && k == 0 ? 1.0 + amount : 0.0) - amount * tap(j) * tap(k) / (sum * sum));
  }
  return fir(taps);
}

constexpr std::array kFrequencies{0.0, 1e-9, 3.0, 17.0, 29.41176470588235, 40.0, -58.0, 1234.5};

TEST(Unsharp, box_is_a_kernel_of_even_weights) {
  for (const int size : {1, 3, 5, 11}) {
    const auto taps = kernel(0.8, size / 2, [](int) { return 1.0; });
    for (const double f : kFrequencies)
      EXPECT_NEAR(otf_at(unsharp(0.8, size), f, 0.3 * f + 2.0).re, otf_at(taps, f, 0.3 * f + 2.0).re, 2e-14) << size;
  }
}

TEST(Unsharp, gaussian_is_a_kernel_of_gaussian_taps) {
  for (const double sigma : {0.05, 0.3, 0.4999999, 0.5, 0.8, 1.7}) {
    const auto taps = kernel(1.5, 16, [&](int k) { return std::exp(-0.5 * (k / sigma) * (k / sigma)); });
    for (const double f : kFrequencies)
      EXPECT_NEAR(otf_at(unsharp_gaussian(1.5, sigma), f, 0.3 * f + 2.0).re, otf_at(taps, f, 0.3 * f + 2.0).re, 1e-13)
          << sigma << " " << f;
  }
}

// At half the sampling frequency along x and nothing along y: a box of n leaves (-1)^((n-1)/2)/n.
TEST(Unsharp, values_at_nyquist) {
  const double nyquist = detector().frame.nyquist_cy_mm(Axis::x);
  EXPECT_NEAR(otf_at(unsharp(0.6, 3), nyquist, 0.0).re, 1.0 + 0.6 * (4.0 / 3.0), 1e-15);
  EXPECT_NEAR(otf_at(unsharp(0.6, 5), nyquist, 0.0).re, 1.0 + 0.6 * (4.0 / 5.0), 1e-15);
  EXPECT_NEAR(otf_at(unsharp_gaussian(0.6, 30.0), nyquist, 0.0).re, 1.6, 1e-15);
  EXPECT_EQ(otf_at(unsharp(0.6, 5), 0.0, 0.0).re, 1.0);
  EXPECT_EQ(otf_at(unsharp_gaussian(0.6, 0.7), 0.0, 0.0).re, 1.0);
}

TEST(Unsharp, is_periodic_in_the_sampling_frequency) {
  const System<double> s = detector(15.625, 31.25);  // 64 and 32 cycles/mm: sums are exact
  for (const auto& c : {unsharp(0.8, 7), unsharp_gaussian(0.8, 0.3), unsharp_gaussian(0.8, 2.0)})
    for (const double f : {0.25, 3.0, 17.5, 31.75})
      EXPECT_NEAR(otf_at(c, f + 192.0, f - 64.0, s).re, otf_at(c, f, f, s).re, 1e-14) << f;
}

TEST(Unsharp, slopes_of_gaussian_taps_meet_at_the_switch) {
  for (const double x : {0.0, 1e-6, 0.1, 0.37, 0.5}) {
    const GaussianTaps below(x, std::nextafter(0.5, 0.0)), above(x, 0.5);
    EXPECT_NEAR(below.value, above.value, 1e-15);
    EXPECT_NEAR(below.by_x, above.by_x, 1e-14);
    EXPECT_NEAR(below.by_sigma, above.by_sigma, 1e-14);
  }
}

TEST(Unsharp, blurs_that_are_none_are_refused) {
  EXPECT_TRUE(refused(unsharp(0.8, 4), "size"));
  auto both = unsharp(0.8, 5);
  set(both, "sigma", 1.0);
  EXPECT_TRUE(refused(both, "size"));
  EXPECT_FALSE(refused(unsharp_gaussian(0.8, 1.0), "size"));
}

}  // namespace
}  // namespace mtf::test
