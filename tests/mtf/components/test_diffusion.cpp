// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> diffusion(double absorption_um, double depletion_um, double diffusion_um) {
  auto c = Component<double>::make("diffusion");
  set(c, "absorption_length", absorption_um);
  set(c, "depletion_depth", depletion_um);
  set(c, "diffusion_length", diffusion_um);
  return c;
}

TEST(Diffusion, ten_digits) {
  const std::array values{.9626812075, .8897905224, .7623483282, .6817120513};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(otf_at(diffusion(10.0, 3.0, 20.0), kGoldenFrequencies[i], 0.0).re, values[i], kTenDigits) << i;
}

TEST(Diffusion, equals_the_fraction_as_published) {
  for (const double a : {0.5, 10.0, 300.0})
    for (const double w : {0.2, 3.0, 50.0})
      for (const double l0 : {1.0, 20.0, 400.0})
        for (const double f : {0.1, 3.0, 40.0, 900.0}) {
          const double u = 2.0 * kPi * l0 * 1e-3 * f, l = l0 / std::sqrt(1.0 + u * u), left = std::exp(-w / a);
          const double expected = (1.0 - left / (1.0 + l / a)) / (1.0 - left / (1.0 + l0 / a));
          EXPECT_NEAR(otf_at(diffusion(a, w, l0), 0.6 * f, -0.8 * f).re, expected, 1e-13);
        }
}

// The illumination that the header states, by its own integral: light from the front is absorbed at a depth z with
// exp(-z/A)/A; charge from within W is collected at once, from behind W it comes back with exp(-(z - W)/L(f)), as in
// field-free material without another side.
TEST(Diffusion, is_that_of_light_from_the_front) {
  const double a = 10.0, w = 3.0, l0 = 20.0;
  const auto share = [&](double l) {
    const GaussRule& rule = gauss_legendre(64);
    double sum = -std::expm1(-w / a);
    for (int panel = 0; panel < 40; ++panel)  // to 40 A
      for (std::size_t i = 0; i < rule.node.size(); ++i) {
        const double z = w + a * (panel + 0.5 + 0.5 * rule.node[i]);
        sum += 0.5 * rule.weight[i] * std::exp(-z / a - (z - w) / l);
      }
    return sum;
  };
  for (const double f : {3.0, 15.0, 60.0, 300.0}) {
    const double u = 2.0 * kPi * l0 * 1e-3 * f, l = l0 / std::sqrt(1.0 + u * u);
    EXPECT_NEAR(otf_at(diffusion(a, w, l0), f, 0.0).re, share(l) / share(l0), 1e-13) << f;
  }
}

// What is absorbed in the depletion layer stays sharp; all of it when that is deep.
TEST(Diffusion, limits) {
  const double left = std::exp(-0.3);
  EXPECT_NEAR(otf_at(diffusion(10.0, 3.0, 20.0), 1e12, 0.0).re, (1.0 - left) / (1.0 - left / 3.0), 1e-9);
  EXPECT_NEAR(otf_at(diffusion(1.0, 1000.0, 20.0), 40.0, 0.0).re, 1.0, 1e-15);
  EXPECT_LT(otf_at(diffusion(10.0, 0.0, 20.0), 1e12, 0.0).re, 1e-8);
}

}  // namespace
}  // namespace mtf::test
