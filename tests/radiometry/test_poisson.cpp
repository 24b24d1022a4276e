// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "radiometry/stages/noise/noise_lanes.h"
#include "radiometry/stages/noise/poisson.h"

namespace radiometry {
namespace {

constexpr std::array kMeans{1e-3, 0.02, 0.3,  1.0,  2.5, 7.0, 15.0, 16.0, 31.9, 32.0, 33.0,
                            64.0, 65.0, 110., 500., 1e3, 1e4, 3e4,  1e5,  1e6,  1e7,  9e7};

/// P(N <= n), P(N > n) by a sum in long double, the first term from lgammal.
long double slow_tail(double n, double mean, bool upper) {
  const long double m = mean;
  long double k = upper ? n + 1.0L : n, sum = 0.0L;
  long double term = std::exp(k * std::log(m) - m - std::lgamma(k + 1.0L));
  while (term > 1e-22L * sum) {
    sum += term;
    if (!upper && k <= 0.0L) break;
    term *= upper ? m / (k + 1.0L) : k / m;
    k += upper ? 1.0L : -1.0L;
  }
  return sum;
}

TEST(Poisson, tails_equal_sums_in_long_double) {
  for (const double mean : kMeans)
    for (const double w : {-9.0, -5.0, -2.0, -0.5, 0.0, 0.7, 3.0, 8.0}) {
      const double n = std::max(0.0, std::floor(mean + w * std::sqrt(mean)));
      const bool upper = n > mean;
      const auto exact = static_cast<double>(slow_tail(n, mean, upper));
      // lgammal of numbers near 1e9 has lost ten of its digits.
      EXPECT_NEAR(poisson_tail(n, mean), exact, (2e-13 + 1e-17 * mean) * exact) << n << " " << mean;
    }
}

TEST(Poisson, normal_quantile_inverts_erfc) {
  for (const double p : {1e-19, 1e-12, 1e-5, 0.02, 0.2, 0.49, 0.5}) {
    const double z = normal_quantile({p, 1.0 - p});
    EXPECT_NEAR(0.5 * std::erfc(-z * std::numbers::sqrt2 / 2), p, 1e-13 * p * (1.0 + z * z)) << p;
    EXPECT_EQ(normal_quantile({1.0 - p, p}), p == 0.5 ? z : -z);
  }
}

// At a step of the distribution function the inverse is a whole number: the expansion has to lie closer to it than the
// error that decides when the function itself is asked.
TEST(Poisson, the_expansion_keeps_its_error) {
  for (const double mean : {32.0, 33.3, 40.0, 64.0, 100.0, 333.0, 1e3, 1e4, 1e5, 1e6, 9.9e7})
    for (double w = -4.0; w <= 4.0; w += 0.0625) {
      const double root = std::sqrt(mean), n = std::floor(mean + w * root + w * w / 6.0);
      const double tail = poisson_tail(n, mean);
      const Uniform u = n <= mean ? Uniform{tail, 1.0 - tail} : Uniform{1.0 - tail, tail};
      const double exact_w = normal_quantile(u);
      if (std::abs(exact_w) > 4.0) continue;
      EXPECT_LT(std::abs(poisson_guess(mean, root, exact_w) - (n + 1.0)), poisson_guess_error(mean, root))
          << mean << " " << exact_w;
    }
}

TEST(Poisson, exact_numbers_fulfil_the_definition) {
  for (const double mean : kMeans) {
    if (mean > 2e6) continue;  // long double ends
    for (std::uint32_t i = 0; i < 300; ++i) {
      const RandomRow row{{7, 0}, Stream::shot, 0};
      Uniform u = uniform_at(row, i);
      if (i % 3 == 0) u = {u.u * 1e-9, 1.0};  // far tails
      if (i % 3 == 1) u = {1.0, u.rest * 1e-9};
      const double n = poisson_exact(u, mean);
      const auto reaches = [&](double k) {
        return k >= 0.0 && (k <= mean ? slow_tail(k, mean, false) >= static_cast<long double>(u.u)
                                      : slow_tail(k, mean, true) <= static_cast<long double>(u.rest));
      };
      EXPECT_TRUE(reaches(n)) << mean << " " << n;
      EXPECT_FALSE(reaches(n - 1.0)) << mean << " " << n;
    }
  }
}

TEST(Poisson, lanes_give_the_exact_numbers) {
  std::vector<float> mean(kNoiseLanes), count(kNoiseLanes);
  const RandomRow row{{3, 1}, Stream::shot, 5};
  for (std::uint32_t block = 0; block < 4000; ++block) {
    for (std::size_t i = 0; i < mean.size(); ++i) {
      const double u = uniform_at(row, i + 99 * block).u;
      mean[i] = static_cast<float>(block % 4 == 0   ? kMeans[block / 4 % kMeans.size()]
                                   : block % 4 == 1 ? std::pow(10.0, -3.0 + 11.0 * u)
                                   : block % 4 == 2 ? 60.0 * u
                                                    : 32.0 * std::pow(131000.0, u));  // what single precision is for
      if (block % 8 == 7 && i % 40 == 3) mean[i] = i % 80 == 3 ? 0.0F : 5e6F;  // dark and bright pixels among them
    }
    poisson_lanes(row, block * kNoiseLanes / 2, mean.data(), count.data());
    for (std::size_t i = 0; i < mean.size(); ++i) {
      const Uniform u = uniform_at(row, block * kNoiseLanes + i);
      ASSERT_EQ(count[i], static_cast<float>(poisson_exact(u, static_cast<double>(mean[i]))))
          << mean[i] << " " << u.u << " " << block;
    }
  }
}

TEST(Poisson, larger_means_never_give_smaller_numbers) {
  std::vector<float> mean(kNoiseLanes), count(kNoiseLanes), last(kNoiseLanes, 0.0F);
  const RandomRow row{{11, 0}, Stream::shot, 0};
  for (double m = 1e-3; m < 1e12; m *= m < 100.0 || (m > 0.9e8 && m < 1.1e8) ? 1.003 : 1.3) {
    std::fill(mean.begin(), mean.end(), static_cast<float>(m));
    poisson_lanes(row, 0, mean.data(), count.data());
    for (std::size_t i = 0; i < mean.size(); ++i) ASSERT_GE(count[i], last[i]) << m;
    last = count;
  }
}

TEST(Poisson, odd_means) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::vector<float> mean(kNoiseLanes, 5.0F), count(kNoiseLanes);
  mean[0] = std::nanf("");
  mean[1] = kInf;
  mean[2] = -kInf;
  mean[3] = -7.0F;
  mean[4] = 0.0F;
  mean[5] = 3e38F;
  mean[6] = 1e-38F;
  poisson_lanes({{1, 0}, Stream::shot, 0}, 0, mean.data(), count.data());
  EXPECT_TRUE(std::isnan(count[0]));
  EXPECT_EQ(count[1], kInf);
  for (const std::size_t i : {2U, 3U, 4U, 6U}) EXPECT_EQ(count[i], 0.0F);
  EXPECT_FLOAT_EQ(count[5], 3e38F);
  EXPECT_EQ(poisson_exact({0.5, 0.5}, -1.0), 0.0);
  EXPECT_TRUE(std::isnan(poisson_exact({0.5, 0.5}, std::nan(""))));
}

}  // namespace
}  // namespace radiometry
