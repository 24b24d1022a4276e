// SPDX-License-Identifier: Apache-2.0
#include "calib/iso12233/iso12233.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <numbers>

#include "edge_truth.h"
#include "mtf/error.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using test::shared_data;

/// Values at `at` of the cubic spline through the points that has one cubic over the first two and last two intervals:
/// how the published figures were read off the curves.
std::vector<double> spline_at(const std::vector<double>& x, const std::vector<double>& y,
                              const std::vector<double>& at) {
  const auto n = static_cast<Eigen::Index>(x.size());
  const auto h = [&](Eigen::Index i) { return x[static_cast<std::size_t>(i) + 1] - x[static_cast<std::size_t>(i)]; };
  const auto rise = [&](Eigen::Index i) {
    return (y[static_cast<std::size_t>(i) + 1] - y[static_cast<std::size_t>(i)]) / h(i);
  };
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    a.row(i).segment(i - 1, 3) << h(i - 1), 2.0 * (h(i - 1) + h(i)), h(i);
    b(i) = 6.0 * (rise(i) - rise(i - 1));
  }
  a.row(0).head(3) << h(1), -(h(0) + h(1)), h(0);
  a.row(n - 1).tail(3) << h(n - 2), -(h(n - 3) + h(n - 2)), h(n - 3);
  const Eigen::VectorXd m = a.partialPivLu().solve(b);
  std::vector<double> values;
  for (const double f : at) {
    const auto next = std::upper_bound(x.begin() + 1, x.end() - 1, f);
    const auto k = static_cast<Eigen::Index>(next - x.begin()) - 1;
    const auto i = static_cast<std::size_t>(k);
    const double t = f - x[i], u = x[i + 1] - f, w = h(k);
    values.push_back((m(k) * u * u * u + m(k + 1) * t * t * t) / (6.0 * w) + (y[i] / w - m(k) * w / 6.0) * u +
                     (y[i + 1] / w - m(k + 1) * w / 6.0) * t);
  }
  return values;
}

struct Row {
  std::string name;
  Iso12233Options options;
};

const std::vector<Row> kRows{{"sfrmat5 C++ npol5 Tukey", {5, true}},
                             {"sfrmat5.m octave npol5", {5, true}},
                             {"sfrmat5 C++ npol1 Tukey", {1, true}},
                             {"sfrmat5 C++ npol1 Hamming", {1, false}}};

/// The published figures of the reference program, of all cases, rounded to 1e-6 (MTF50) and 1e-5.
TEST(Iso12233, ReproducesTheReferenceProgram) {
  if (shared_data().empty()) GTEST_SKIP() << "no shared data";
  const auto truth = test::shared_json("edges/truth.json").at("cases");
  const auto peers = test::shared_json("edges/peers.json").at("cases");
  std::vector<double> grid;
  for (int i = 0; i <= 50; ++i) grid.push_back(0.01 * i);
  int compared = 0;
  for (const auto& edge : truth) {
    const std::string file = edge.at("file");
    const auto& peer = peers.at(file.substr(0, file.size() - 4));
    const mtf::Image image =
        test::linear_image(shared_data() / "edges" / file, edge.at("encoding") == "sRGB" ? "srgb" : "linear");
    for (const Row& row : kRows) {
      SCOPED_TRACE(file + ", " + row.name);
      const auto& figures = peer.at(row.name);
      const Iso12233Result result = measure_iso12233(image.view(), {0, 0, image.width(), image.height()}, row.options);
      ASSERT_EQ(result.trouble, Trouble::none) << result.reason;
      ASSERT_TRUE(result.mtf50);
      EXPECT_NEAR(*result.mtf50, figures.at("mtf50").get<double>(), 1.5e-6);

      const std::vector<double> sfr = spline_at(result.frequency_cy_px, result.sfr, grid);
      double largest = 0.0, squares = 0.0;
      for (std::size_t i = 0; i < grid.size(); ++i) {
        const double error = sfr[i] - test::true_mtf(edge, grid[i]);
        largest = std::max(largest, std::abs(error));
        squares += error * error;
      }
      EXPECT_NEAR(largest, figures.at("max_abs_dmtf_0_0p5").get<double>(), 1e-5);
      EXPECT_NEAR(std::sqrt(squares / static_cast<double>(grid.size())), figures.at("rms_dmtf_0_0p5").get<double>(),
                  1e-5);
      ++compared;
    }
  }
  EXPECT_EQ(compared, 76);
}

/// An edge of a Gaussian blur through the middle, the normal at `angle_deg` from +x towards +y.
mtf::Image made_edge(std::int64_t width, std::int64_t height, double angle_deg, double dark = 0.2,
                     double bright = 0.8) {
  mtf::Image image(width, height);
  const double angle = angle_deg * std::numbers::pi / 180.0;
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) {
      const double d = std::cos(angle) * (static_cast<double>(x) + 0.5 - 0.5 * static_cast<double>(width)) +
                       std::sin(angle) * (static_cast<double>(y) + 0.5 - 0.5 * static_cast<double>(height));
      image.at(x, y) = static_cast<float>(dark + (bright - dark) * 0.5 * std::erfc(-d / (std::numbers::sqrt2 * 0.7)));
    }
  return image;
}

Iso12233Result whole(const mtf::Image& image, const Iso12233Options& options = {}) {
  return measure_iso12233(image.view(), {0, 0, image.width(), image.height()}, options);
}

TEST(Iso12233, TakesEdgesOfAnyOrientationAndPolarity) {
  const double expected = std::sqrt(std::log(2.0) / 2.0) / (std::numbers::pi * 0.7);
  for (const double angle : {5.0, -8.0, 12.0, 30.0, 85.0, 97.0, 120.0, 175.0, -85.0, -95.0, 188.0}) {
    SCOPED_TRACE(angle);
    const Iso12233Result result = whole(made_edge(120, 110, angle));
    ASSERT_EQ(result.trouble, Trouble::none) << result.reason;
    EXPECT_NEAR(*result.mtf50, expected, 0.01 * expected);
    double folded = std::remainder(angle, 180.0);
    if (folded <= -90.0) folded += 180.0;
    EXPECT_NEAR(result.angle_deg, folded, 0.02);
    EXPECT_TRUE(says(result.warnings, "biased"));
  }
}

TEST(Iso12233, MeasuresTheRegionAlone) {
  const mtf::Image edge = made_edge(100, 90, 6.0);
  mtf::Image image(300, 200);
  std::fill_n(image.data(), image.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::int64_t y = 0; y < 90; ++y) std::copy_n(&edge.view().at(0, y), 100, &image.at(140, 70 + y));
  const Iso12233Result inside = measure_iso12233(image.view(), {140, 70, 100, 90});
  ASSERT_EQ(inside.trouble, Trouble::none) << inside.reason;
  EXPECT_EQ(inside.sfr, whole(edge).sfr);
}

TEST(Iso12233, WarnsOfLowContrastAndEmptyBins) {
  EXPECT_FALSE(says(whole(made_edge(120, 110, 5.0)).warnings, "contrast"));
  EXPECT_TRUE(says(whole(made_edge(120, 110, 5.0, 0.5, 0.6)).warnings, "contrast"));
  const Iso12233Result diagonal = whole(made_edge(120, 80, 44.999));
  ASSERT_EQ(diagonal.trouble, Trouble::none) << diagonal.reason;
  EXPECT_TRUE(says(diagonal.warnings, "bins"));
}

// What the default method sees of clipping: a limit that is stated, both sides cut off in noise, sides that end
// abruptly.
TEST(Iso12233, WarnsOfClipping) {
  const mtf::Image clear = made_edge(120, 110, 5.0, 0.1, 0.9);
  EXPECT_FALSE(says(whole(clear).warnings, "clipped"));
  EXPECT_EQ(whole(clear).clipped_share, 0.0);
  const auto cut = [](mtf::Image image, float low, float high, bool noise) {
    std::uint32_t bits = 1;
    for (std::int64_t i = 0; i < image.size(); ++i) {
      bits = 1664525U * bits + 1013904223U;
      const float more = noise ? 0.02F * (static_cast<float>(bits >> 8U) / 8388608.0F - 1.0F) : 0.0F;
      image.data()[i] = std::clamp(image.data()[i] + more, low, high);
    }
    return image;
  };
  const Iso12233Options stated{.image = {.saturation = 0.7, .floor = 0.3}};
  const Iso12233Result hard = whole(cut(clear.clone(), 0.3F, 0.7F, false), stated);
  ASSERT_EQ(hard.trouble, Trouble::none) << hard.reason;
  EXPECT_TRUE(says(hard.warnings, "are clipped"));
  EXPECT_GT(hard.clipped_share, 0.9);
  EXPECT_GT(*hard.mtf50, 1.2 * *whole(clear).mtf50);
  const Iso12233Result few = whole(cut(clear.clone(), 0.0F, 0.91F, true), {.image = {.saturation = 0.91}});
  EXPECT_TRUE(says(few.warnings, "are clipped"));
  EXPECT_GT(few.clipped_share, 0.05);
  EXPECT_TRUE(says(whole(cut(clear.clone(), 0.3F, 0.7F, true)).warnings, "clipped"));
  EXPECT_TRUE(says(whole(cut(made_edge(120, 110, 5.0, 0.2, 0.8), 0.28F, 0.72F, false)).warnings, "clipped"));
}

TEST(Iso12233, NamesWhatCannotBeMeasured) {
  const auto outcome = [](const mtf::Image& image, const Iso12233Options& options = {}) {
    const Iso12233Result result = whole(image, options);
    EXPECT_EQ(result.trouble == Trouble::none, result.reason.empty());
    return result.trouble;
  };
  EXPECT_EQ(outcome(made_edge(120, 110, 0.0)), Trouble::too_short);
  EXPECT_EQ(outcome(made_edge(9, 110, 5.0)), Trouble::too_short);
  EXPECT_EQ(outcome(made_edge(1, 1, 5.0)), Trouble::too_short);
  EXPECT_EQ(outcome(made_edge(120, 110, 5.0, 0.4, 0.4)), Trouble::no_edge);
  mtf::Image masked = made_edge(120, 110, 5.0);
  masked.at(3, 4) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(outcome(masked), Trouble::no_data);
  expect_says(whole(masked).reason, {"(3,4)"});
  masked.at(3, 4) = std::numeric_limits<float>::infinity();
  EXPECT_EQ(outcome(masked), Trouble::no_data);

  mtf::Image noise(100, 90);
  unsigned state = 1;
  for (std::int64_t i = 0; i < noise.size(); ++i)
    noise.data()[i] = static_cast<float>((state = state * 1664525u + 1013904223u) >> 8);
  EXPECT_EQ(outcome(noise), Trouble::no_edge);
  EXPECT_EQ(outcome(noise, {1, false}), Trouble::no_edge);
}

TEST(Iso12233, SurvivesAnyRegion) {
  const mtf::Image image = made_edge(60, 50, 25.0);
  int measured = 0;
  for (std::int64_t y = 0; y < 50; y += 7)
    for (std::int64_t x = 0; x < 60; x += 7)
      for (std::int64_t h = 1; h <= 50 - y; h += 6)
        for (std::int64_t w = 1; w <= 60 - x; w += 6)
          for (const Iso12233Options& options : {Iso12233Options{5, true}, Iso12233Options{1, false}}) {
            const Iso12233Result result = measure_iso12233(image.view(), {x, y, w, h}, options);
            if (result.trouble != Trouble::none) continue;
            ++measured;
            for (const double v : result.sfr) ASSERT_TRUE(std::isfinite(v)) << x << " " << y << " " << w << " " << h;
          }
  EXPECT_GT(measured, 50);
}

TEST(Iso12233, RefusesMisuse) {
  const mtf::Image image = made_edge(60, 50, 5.0);
  const std::int64_t huge = std::numeric_limits<std::int64_t>::max();
  for (const Roi& roi : {Roi{0, 0, 0, 10}, Roi{0, 0, 10, -1}, Roi{-1, 0, 20, 20}, Roi{50, 0, 20, 20},
                         Roi{0, 0, huge, 20}, Roi{huge, 0, 20, 20}})
    EXPECT_THROW(static_cast<void>(measure_iso12233(image.view(), roi)), mtf::UsageError);
  for (const int order : {0, 6, -1}) EXPECT_THROW(static_cast<void>(whole(image, {order, true})), mtf::UsageError);
}

}  // namespace
}  // namespace calib
