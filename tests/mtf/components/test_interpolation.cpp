// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

enum Kernel { nearest, linear, cubic, bspline, six_coefficient };

Component<double> interpolation(Kernel kernel) {
  auto c = Component<double>::make("interpolation");
  choose(c, "kernel", kernel);
  return c;
}

Component<double> keys(double a) {
  auto c = interpolation(cubic);
  set(c, "a", a);
  return c;
}

/// One cycle/mm is one cycle/pixel.
double at(const Component<double>& c, double x, double y = 0.0) { return otf_at(c, x, y, detector(1000.0, 1000.0)).re; }

TEST(Interpolation, keys_golden_values) {
  const std::array x{.1, .25, .5, .75}, golden{.998120, .939019, .492767, .062558};
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(at(keys(-0.5), x[i]), golden[i], 5e-7);
    EXPECT_EQ(at(interpolation(cubic), x[i]), at(keys(-0.5), x[i]));
  }
  EXPECT_NEAR(at(keys(-1.0), 0.25), 1.032, 5e-4);
}

// The formula of Keys' response at the doubles, 60 digits (mpmath); the series takes over below 0.25.
TEST(Interpolation, keys_to_the_last_digits) {
  struct Row {
    double x, half, three_quarters;
  };
  for (const Row& row :
       {Row{1e-8, 1.0, 1.00000000000000013}, Row{1e-3, 0.999999999980518251, 1.0000013159166393},
        Row{0.01, 0.999999805250984811, 1.00013128868705449}, Row{0.1, 0.998119766748091116, 1.01020077765228391},
        Row{0.2499999999, 0.939019491123797267, 0.985534296522316577},
        Row{0.25, 0.939019491037008702, 0.985534296449696178},
        Row{0.2500000001, 0.939019490950220138, 0.985534296377075779},
        Row{0.5, 0.492767148224848089, 0.492767148224848089}, Row{0.75, 0.0625582209689696706, 0.0121670900796258787},
        Row{1.3, -0.00451847672377477364, 0.000164425335587626594},
        Row{7.7, 0.0000477274837294630573, 0.0000183339501768135346}}) {
    EXPECT_NEAR(at(keys(-0.5), row.x), row.half, 1e-15) << row.x;
    EXPECT_NEAR(at(keys(-0.75), row.x), row.three_quarters, 1e-15) << row.x;
  }
}

// The kernel itself (Keys 1981), transformed by Simpson's rule over each of its two pieces.
TEST(Interpolation, keys_is_the_transform_of_its_kernel) {
  constexpr int kPanels = 2000;
  for (const double a : {-2.0, -1.0, -0.5, -0.2, 0.0})
    for (const double x : {0.003, 0.17, 0.4, 0.9, 2.3}) {
      double sum = 0.0;
      for (const int piece : {0, 1})
        for (int k = 0; k <= kPanels; ++k) {
          const double t = piece + static_cast<double>(k) / kPanels;
          const double kernel = piece == 0 ? (a + 2.0) * t * t * t - (a + 3.0) * t * t + 1.0
                                           : a * (t * t * t - 5.0 * t * t + 8.0 * t - 4.0);
          const double w = (k == 0 || k == kPanels ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) / kPanels / 3.0;
          sum += 2.0 * w * kernel * std::cos(2.0 * kPi * x * t);
        }
      EXPECT_NEAR(at(keys(a), x), sum, 1e-10) << a << " " << x;
    }
}

TEST(Interpolation, nearest_and_linear_are_powers_of_sinc) {
  for (const double x : {0.0, 1e-5, 0.3, 0.5, 1.5, 8.25}) {
    const double s = x == 0.0 ? 1.0 : std::sin(kPi * x) / (kPi * x);
    EXPECT_NEAR(at(interpolation(nearest), x), s, 1e-15);
    EXPECT_NEAR(at(interpolation(linear), x), s * s, 1e-15);
    EXPECT_NEAR(at(interpolation(linear), x, 0.3), s * s * std::pow(std::sin(0.3 * kPi) / (0.3 * kPi), 2), 1e-15);
  }
}

// Through its own samples: the B-spline's transform over the sum of its replicas.
TEST(Interpolation, bspline_interpolates) {
  for (const double x : {0.01, 0.2, 0.5, 0.77, 1.4, 3.1}) {
    double replicas = 0.0;
    for (int k = -3000; k <= 3000; ++k) replicas += std::pow(std::sin(kPi * (x - k)) / (kPi * (x - k)), 4);
    EXPECT_NEAR(at(interpolation(bspline), x), std::pow(std::sin(kPi * x) / (kPi * x), 4) / replicas, 1e-12) << x;
  }
  EXPECT_NEAR(at(interpolation(bspline), 0.5), 48.0 / std::pow(kPi, 4), 1e-15);
}

// Interpolation leaves samples as they are: the response and its replicas add to 1.
TEST(Interpolation, replicas_add_to_one) {
  for (const auto& c : {interpolation(bspline), keys(-0.5), keys(-1.0)})
    for (const double x : {0.0, 0.1, 0.31, 0.5}) {
      double sum = 0.0;
      for (int k = -4000; k <= 4000; ++k) sum += at(c, x + k);
      EXPECT_NEAR(sum, 1.0, 1e-9) << x;
    }
}

TEST(Interpolation, zero_at_multiples_of_the_sampling_frequency) {
  for (const Kernel kernel : {nearest, linear, cubic, bspline})
    for (const double x : {1.0, -2.0, 1e6, 1e200}) EXPECT_EQ(at(interpolation(kernel), x), 0.0) << kernel << " " << x;
}

TEST(Interpolation, six_coefficients_as_published) {
  const std::array x{.25, .4, .5}, golden{1.0005, .9236, .5};
  const double zero = at(interpolation(six_coefficient), 0.0);  // the gain of the other axis as well
  EXPECT_NEAR(zero, 0.9996 * 0.9996, 1e-15);
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(at(interpolation(six_coefficient), x[i]) / 0.9996, golden[i], 5e-5);
  EXPECT_DOUBLE_EQ(interpolation(six_coefficient).traits(detector().context()).dc, 0.9996 * 0.9996);
}

// The same filter by its taps, on the grid of twice the samples.
TEST(Interpolation, six_coefficients_are_a_filter_of_the_doubled_grid) {
  const std::array c{.6213, -.1704, .0693, -.0276, .0100, -.0030};
  std::vector<double> row(23, 0.0);
  row[11] = 0.5;
  for (std::size_t j = 0; j < c.size(); ++j) row[11 + 2 * j + 1] = row[11 - 2 * j - 1] = 0.5 * c[j];
  const auto taps = fir({row});
  for (const double f : {0.0, 0.1, 0.33, 0.5, 0.8, 1.0, 2.7, -0.2})
    EXPECT_NEAR(at(interpolation(six_coefficient), f) / 0.9996, otf_at(taps, f, 0.0, detector(500.0, 500.0)).re, 1e-14)
        << f;
}

TEST(Interpolation, a_belongs_to_the_cubic) {
  auto c = keys(-0.5);
  EXPECT_FALSE(refused(c, "a"));
  choose(c, "kernel", linear);
  EXPECT_TRUE(refused(c, "a"));
}

}  // namespace
}  // namespace mtf::test
