// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "radiometry/stages/noise/noise.h"
#include "radiometry/stages/noise/poisson.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::chi_square_sigmas;
using test::correlation_sigmas;
using test::flat;
using test::kMostSigmas;
using test::moments;
using test::samples;

mtf::Image gaussian_frame(const NoiseKey& key, Stream stream, std::int64_t width = 1024, std::int64_t height = 1024) {
  mtf::Image image = flat(width, height, 0.0F);
  add_gaussian(image.view(), 1.0, key, stream);
  return image;
}

TEST(Gaussian, chi_square_moments_and_tails) {
  const mtf::Image image = gaussian_frame({20, 0}, Stream::read, 4096, 2048);
  const auto n = static_cast<double>(image.size());
  constexpr int kBins = 200;
  std::vector<double> observed(kBins), expected(kBins, n / kBins);
  double cube = 0.0, fourth = 0.0;
  std::vector<double> beyond(7);
  for (const float z : samples(image)) {
    const double u = 0.5 * std::erfc(-static_cast<double>(z) / std::numbers::sqrt2);
    ++observed[static_cast<std::size_t>(std::min(kBins - 1.0, std::floor(u * kBins)))];
    cube += std::pow(static_cast<double>(z), 3);
    fourth += std::pow(static_cast<double>(z), 4);
    for (std::size_t k = 1; k < beyond.size(); ++k) beyond[k] += std::abs(z) > static_cast<float>(k);
  }
  EXPECT_LT(std::abs(chi_square_sigmas(observed, expected)), kMostSigmas);
  const auto m = moments(samples(image));
  EXPECT_LT(std::abs(m.mean) * std::sqrt(n), kMostSigmas);
  EXPECT_LT(std::abs(m.variance - 1.0) * std::sqrt(n / 2.0), kMostSigmas);
  EXPECT_LT(std::abs(cube / n) * std::sqrt(n / 15.0), kMostSigmas);
  EXPECT_LT(std::abs(fourth / n - 3.0) * std::sqrt(n / 96.0), kMostSigmas);
  for (std::size_t k = 1; k < beyond.size(); ++k) {
    const double mean = n * std::erfc(static_cast<double>(k) / std::numbers::sqrt2);
    EXPECT_LT(std::abs(beyond[k] - mean), kMostSigmas * std::sqrt(mean) + 1.0) << k;
  }
}

TEST(Gaussian, frames_streams_rows_and_neighbours_are_independent) {
  const mtf::Image a = gaussian_frame({20, 0}, Stream::read), b = gaussian_frame({20, 1}, Stream::read);
  const mtf::Image c = gaussian_frame({20, 0}, Stream::dsnu), d = gaussian_frame({21, 0}, Stream::read);
  for (const mtf::Image* other : {&b, &c, &d})
    EXPECT_LT(std::abs(correlation_sigmas(samples(a), samples(*other))), kMostSigmas);
  const auto s = samples(a);
  for (const std::size_t lag : {1U, 2U, 3U, 128U, 1024U, 1025U}) {
    EXPECT_LT(std::abs(correlation_sigmas(s.subspan(lag), s.first(s.size() - lag))), kMostSigmas) << lag;
    std::vector<float> squares(s.begin(), s.end());
    for (float& z : squares) z *= z;
    const std::span<const float> q = squares;
    EXPECT_LT(std::abs(correlation_sigmas(q.subspan(lag), q.first(q.size() - lag))), kMostSigmas) << lag;
  }
}

template <class Apply>
void expect_the_same_everywhere(Apply apply) {
  constexpr std::int64_t kWidth = 517, kHeight = 67;
  const auto value = [](std::int64_t x, std::int64_t y) { return static_cast<float>((x * 37 + y * 101) % 900) * 0.7F; };
  mtf::Image whole(kWidth, kHeight), threaded(kWidth, kHeight);
  for (std::int64_t y = 0; y < kHeight; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x) whole.at(x, y) = threaded.at(x, y) = value(x, y);
  apply(whole.view(), Origin{}, 1);
  apply(threaded.view(), Origin{}, 2);
  EXPECT_TRUE(std::equal(whole.data(), whole.data() + whole.size(), threaded.data()));
  for (const auto& [x0, y0, w, h] :
       {std::array<std::int64_t, 4>{0, 0, 1, 1}, {1, 5, 2, 3}, {127, 1, 130, 4}, {255, 60, 262, 7}, {516, 66, 1, 1}}) {
    mtf::Image part(w, h);
    for (std::int64_t y = 0; y < h; ++y)
      for (std::int64_t x = 0; x < w; ++x) part.at(x, y) = value(x0 + x, y0 + y);
    apply(part.view(), Origin{x0, y0}, 2);
    for (std::int64_t y = 0; y < h; ++y)
      for (std::int64_t x = 0; x < w; ++x)
        ASSERT_EQ(part.at(x, y), whole.at(x0 + x, y0 + y)) << x0 + x << " " << y0 + y;
  }
}

TEST(Noise, the_same_for_any_region_and_threads) {
  expect_the_same_everywhere([](mtf::ImageView<float> image, Origin origin, int threads) {
    add_gaussian(image, 2.5, {1, 4}, Stream::read, origin, threads);
  });
  expect_the_same_everywhere([](mtf::ImageView<float> image, Origin origin, int threads) {
    shot_noise(image, {1, 4}, origin, threads);
  });
}

TEST(Noise, of_some_rows_is_that_of_all) {
  constexpr std::int64_t kWidth = 300, kHeight = 64;
  const auto noisy = [](std::int64_t every, int threads) {
    mtf::Image image = flat(kWidth, kHeight, 500.0F);
    shot_noise(image.view(), {3, 1}, {5, 7}, threads, every);
    add_gaussian(image.view(), 20.0, {3, 1}, Stream::read, {5, 7}, threads, every);
    return image;
  };
  const mtf::Image all = noisy(1, 1);
  for (const std::int64_t every : {2, 3, 64, 100})
    for (const int threads : {1, 3}) {
      const mtf::Image some = noisy(every, threads);
      for (std::int64_t y = 0; y < kHeight; ++y)
        for (std::int64_t x = 0; x < kWidth; ++x)
          ASSERT_EQ(some.at(x, y), y % every == 0 ? all.at(x, y) : 500.0F) << every << ": " << x << ", " << y;
    }
}

// Bins of the numbers themselves where they are few, else of about equal probability.
TEST(ShotNoise, chi_square_from_1e_3_to_1e7) {
  for (const double mean : {1e-3, 0.1, 1.0, 5.0, 31.0, 33.0, 70.0, 300.0, 1e3, 1e4, 1e5, 1e6, 1e7}) {
    const mtf::Image image = [&] {
      mtf::Image frame = flat(1024, 512, static_cast<float>(mean));
      shot_noise(frame.view(), {99, 3});
      return frame;
    }();
    const double m = static_cast<double>(static_cast<float>(mean)), n = static_cast<double>(image.size());
    std::vector<double> last{};  // the largest number of each bin
    for (double u = 0.01; u < 1.0; u += 0.01) {
      const double k = poisson_exact({u, 1.0 - u}, m);
      if (last.empty() || k > last.back()) last.push_back(k);
    }
    if (last.back() < m) last.push_back(std::ceil(m));
    std::vector<double> expected, observed(last.size() + 1);
    double below = 0.0;
    for (const double k : last) {
      const double p = k <= m ? poisson_tail(k, m) : 1.0 - poisson_tail(k, m);
      expected.push_back(n * (p - below));
      below = p;
    }
    expected.push_back(n * poisson_tail(last.back(), m) * (last.back() > m ? 1.0 : 0.0) +
                       (last.back() > m ? 0.0 : n * (1.0 - below)));
    for (const float count : samples(image)) {
      ASSERT_EQ(count, std::floor(count));
      ++observed[static_cast<std::size_t>(std::lower_bound(last.begin(), last.end(), static_cast<double>(count)) -
                                          last.begin())];
    }
    EXPECT_LT(std::abs(chi_square_sigmas(observed, expected)), kMostSigmas) << mean;
    const auto got = moments(samples(image));
    EXPECT_LT(std::abs(got.mean - m) / std::sqrt(m / n), kMostSigmas) << mean;
    EXPECT_LT(std::abs(got.variance - m) / std::sqrt((2.0 * m * m + m) / n), kMostSigmas) << mean;
  }
}

TEST(ShotNoise, frames_are_independent) {
  mtf::Image a = flat(1024, 256, 40.0F), b = flat(1024, 256, 40.0F);
  shot_noise(a.view(), {5, 0});
  shot_noise(b.view(), {5, 1});
  EXPECT_LT(std::abs(correlation_sigmas(samples(a), samples(b))), kMostSigmas);
}

TEST(Noise, refusals) {
  mtf::Image image = flat(4, 4, 1.0F);
  expect_refused({"-1 rms"}, [&] { add_gaussian(image.view(), -1.0, {}, Stream::read); });
  expect_refused({"nan rms"}, [&] { add_gaussian(image.view(), std::nan(""), {}, Stream::read); });
  expect_refused({"column -1"}, [&] { shot_noise(image.view(), {}, {-1, 0}); });
  expect_refused({"row 4294967295"}, [&] { shot_noise(image.view(), {}, {0, 4294967295}); });
  mtf::Image empty(0, 0);
  shot_noise(empty.view(), {});
  add_gaussian(image.view(), 0.0, {}, Stream::read);
  EXPECT_EQ(image.at(3, 3), 1.0F);
}

}  // namespace
}  // namespace radiometry
