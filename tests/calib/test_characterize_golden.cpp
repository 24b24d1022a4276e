// SPDX-License-Identifier: Apache-2.0

// Estimators of cameras against golden stacks: frames by integers alone, and numbers from the definitions by rational
// and 50-digit arithmetic (expected.json), which no estimator of ours had a part in.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "calib/characterize/components.h"
#include "calib/characterize/photon_transfer.h"
#include "calib/characterize/rounding.h"
#include "calib/characterize/stack_statistics.h"
#include "mtf/io/npy.h"

namespace calib {
namespace {

using Json = nlohmann::json;
using radiometry::CubePart;

constexpr std::array kNames{"t", "v", "h", "tv", "th", "vh", "tvh"};

class Golden : public testing::Test {
 protected:
  void SetUp() override {
    const char* chosen = std::getenv("MTFKIT_SHARED");
    const std::filesystem::path shared = chosen ? chosen : MTFKIT_SOURCE_DIR "/../shared";
    if (!std::filesystem::is_directory(shared / "data")) GTEST_SKIP() << "no shared data";
    folder_ = shared / "data/characterise/golden";
    std::ifstream file(folder_ / "expected.json");
    ASSERT_TRUE(file) << folder_;
    expected_ = Json::parse(file);
  }

  /// One for each level of a cube (level,) frame, row, column.
  std::vector<StackStatistics> stacks(const std::string& name, int threads = 1) const {
    mtf::io::NpyReader file((folder_ / name).string());
    std::vector<std::uint64_t> shape = file.shape();
    if (shape.size() == 3) shape.insert(shape.begin(), 1);
    const auto height = static_cast<std::int64_t>(shape[2]), width = static_cast<std::int64_t>(shape[3]);
    std::vector<StackStatistics> stacks(shape[0], StackStatistics(width, height, {.low = 0.0, .high = 65535.0}));
    mtf::Image frame(width, height);
    const auto size = static_cast<std::size_t>(frame.size());
    for (std::size_t k = 0; k < shape[0]; ++k)
      for (std::size_t t = 0; t < shape[1]; ++t) {
        file.read((k * shape[1] + t) * size, {frame.data(), size});
        stacks[k].add(frame.view(), threads);
      }
    return stacks;
  }

  static double number(const Json& text) { return std::stod(text.get<std::string>()); }

  std::filesystem::path folder_;
  Json expected_;
};

void expect_relative(double value, double expected, double tolerance, const std::string& what) {
  EXPECT_NEAR(value, expected, tolerance * std::abs(expected)) << what;
}

TEST_F(Golden, MeanSquaresAndLimitsOfACube) {
  const Json& a = expected_.at("a_cube");
  const StackStatistics stack = stacks("a_cube.npy").front();
  expect_relative(stack.mean(), number(a.at("mean")), 1e-15, "mean");
  const radiometry::MeanSquares squares = stack.mean_squares();
  for (std::size_t q = 0; q < kNames.size(); ++q) {
    const Json &ms = a.at("mean_squares").at(kNames[q]), &c = a.at("components").at(kNames[q]);
    expect_relative(squares.value[q], number(ms.at("value")), 1e-13, kNames[q]);
    EXPECT_EQ(squares.dof(q), ms.at("df").get<double>());
    const VarianceComponent one = variance_component(squares, static_cast<CubePart>(q));
    // Relative to the mean squares that are subtracted from each other, where the difference is next to nothing.
    const double size = std::abs(number(c.at("sd")));
    EXPECT_NEAR(one.variance, number(c.at("variance")), 1e-10 * size) << kNames[q];
    expect_relative(one.sd, number(c.at("sd")), 1e-10, kNames[q]);
    EXPECT_NEAR(one.low95, number(c.at("lower95")), 1e-10 * size) << kNames[q];
    expect_relative(one.high95, number(c.at("upper95")), 1e-10, kNames[q]);
  }
}

TEST_F(Golden, PhotonTransferFit) {
  const Json& b = expected_.at("b_photon_transfer");
  const std::vector<StackStatistics> all = stacks("b_photon_transfer.npy");
  std::vector<TransferLevel> levels;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const radiometry::MeanSquares squares = all[k].mean_squares();
    const double v = squares.value[radiometry::kTvh];
    expect_relative(all[k].mean(), number(b.at("levels")[k].at("mean")), 1e-14, "mean");
    expect_relative(v, number(b.at("levels")[k].at("tvh")), 1e-12, "variance");
    levels.push_back({.light = b.at("exposures")[k].get<double>(),
                      .mean = all[k].mean(),
                      .mean_variance = v / static_cast<double>(all[k].pixels() * all[k].frames()),
                      .variance = v,
                      .dof = squares.dof(radiometry::kTvh)});
  }
  const PhotonTransfer fit =
      fit_photon_transfer(levels, {.nonlinearity = 1, .full_well_e = b.at("saturation_e").get<double>()});
  ASSERT_TRUE(fit.converged);
  const Json& f = b.at("fit");
  const std::array<std::pair<const char*, const Estimate*>, 5> found{
      {{"K", &fit.gain}, {"read2", &fit.read2}, {"offset", &fit.offset}, {"rate", &fit.rate}, {"a2", fit.a.data()}}};
  for (const auto& [name, estimate] : found) {
    expect_relative(estimate->value, number(f.at(name).at("value")), 1e-7, name);
    expect_relative(estimate->sd, number(f.at(name).at("sd")), 1e-7, name);
  }
  expect_relative(fit.chi2, number(f.at("chi2")), 1e-7, "chi2");
  EXPECT_EQ(fit.dof, f.at("dof").get<int>());
  EXPECT_NEAR(fit.p, 0.004, 0.0005);
}

TEST_F(Golden, CovariancesAreTheSameForAnyThreads) {
  const StackStatistics one = stacks("c_crosstalk.npy").front(), three = stacks("c_crosstalk.npy", 3).front();
  for (const Lag lag : kLags) {
    const Json& c = expected_.at("c_crosstalk").at(std::to_string(lag.rows) + "," + std::to_string(lag.columns));
    const Covariance found = one.covariance(lag);
    expect_relative(found.value, number(c.at("covariance")), 1e-13, "covariance");
    EXPECT_EQ(found.pairs, c.at("pairs").get<double>());
    EXPECT_EQ(found.value, three.covariance(lag).value);
  }
  const double v = number(expected_.at("c_crosstalk").at("0,0").at("covariance"));
  double sum = 0.0;  // the covariance at no distance is the mean of the pixels' variances
  const radiometry::MeanSquares ms = one.mean_squares();
  for (const auto part : {radiometry::kTvh, radiometry::kTv, radiometry::kTh, radiometry::kT})
    sum += ms.value[part] * ms.dof(part);
  expect_relative(sum / (576.0 * 7.0), v, 1e-13, "variance");
}

TEST_F(Golden, RoundingAndItsInverse) {
  for (const Json& row : expected_.at("d_rounding")) {
    const double s = number(row.at("sigma")), q = number(row.at("temporal"));
    expect_relative(rounded_variance(s * s).value, q, 1e-12, "Q");
    EXPECT_NEAR(rounding_pattern(s * s), number(row.at("pattern")), 1e-14 + 1e-10 * number(row.at("pattern"))) << s;
    expect_relative(unrounded_variance(q), s * s, 1e-11, "inverse");
  }
  // Both sums where one takes over from the other.
  EXPECT_NEAR(rounded_variance(0.08).value, rounded_variance(std::nextafter(0.08, 1.0)).value, 1e-15);
  EXPECT_NEAR(rounded_variance(0.08).slope, rounded_variance(std::nextafter(0.08, 1.0)).slope, 1e-12);
}

}  // namespace
}  // namespace calib
