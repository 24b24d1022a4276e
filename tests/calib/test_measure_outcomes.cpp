// SPDX-License-Identifier: Apache-2.0
// What is not an edge, half an edge or a damaged image: each a named outcome, never a crash, a hang or a NaN.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "calib/measure/edge_facts.h"
#include "calib/measure/measure.h"
#include "mtf/error.h"
#include "tests/calib/made_edges.h"
#include "tests/expect_error.h"

namespace {

using calib::EdgeMeasurement;
using calib::Trouble;

mtf::Image draw(std::int64_t width, std::int64_t height, const std::function<double(double, double)>& value) {
  mtf::Image image(width, height);
  for (std::int64_t j = 0; j < height; ++j)
    for (std::int64_t i = 0; i < width; ++i)
      image.at(i, j) = static_cast<float>(value(static_cast<double>(i), static_cast<double>(j)));
  return image;
}

// All numbers of a result are finite.
EdgeMeasurement measure(const mtf::Image& image, const calib::MeasureOptions& options = {}) {
  const auto found = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()}, options);
  for (const auto* list :
       {&found.mtf, &found.mtf_sd, &found.otf_re, &found.otf_im, &found.esf, &found.esf_sd, &found.lsf})
    for (const double value : *list) EXPECT_TRUE(std::isfinite(value));
  for (const auto* one : {&found.mtf10, &found.mtf30, &found.mtf50, &found.nyquist, &found.rer, &found.overshoot,
                          &found.fwhm_px, &found.mtfa, &found.sampling_efficiency})
    EXPECT_TRUE(!*one || (std::isfinite((*one)->value) && std::isfinite((*one)->sd)));
  for (const double value : {found.dark, found.bright, found.noise_sd, found.noise_gain, found.cnr, found.oversampling,
                             found.chi2_per_dof, found.angle_deg.value, found.angle_deg.sd, found.length_px})
    EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(found.reason.empty(), found.trouble == Trouble::none) << found.reason;
  return found;
}

mtf::Image usual(double noise_sd = 0.01) {
  made::Scene scene;
  scene.noise_sd = noise_sd;
  return made::make(made::Step::gaussian(0.3), scene);
}

template <class Change>
mtf::Image changed(const mtf::Image& image, Change change) {
  mtf::Image copy = image.clone();
  for (std::int64_t j = 0; j < copy.height(); ++j)
    for (std::int64_t i = 0; i < copy.width(); ++i) copy.at(i, j) = change(copy.at(i, j), i, j);
  return copy;
}

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// A step along the grid between noisy sides once gave an MTF of 2e7 +- 3e7.
TEST(MeasureOutcomes, AnMtfThatIsBeyondAllStepsIsRefusedWhateverItsError) {
  EdgeMeasurement edge;
  edge.frequency_cy_px = {0.0, 0.005, 0.5, 0.9};
  edge.mtf = {1.0, 1.0, 0.8, 40.0};
  edge.mtf_sd = {0.0, 0.01, 0.1, 50.0};
  edge.oversampling = 8.0;
  EXPECT_FALSE(calib::judge_response(edge).refused());  // beyond Nyquist the noise may win
  edge.mtf[2] = 12.0;
  edge.mtf_sd[2] = 100.0;
  EXPECT_EQ(calib::judge_response(edge).trouble, Trouble::contaminated);
  edge.oversampling = 2.0;
  EXPECT_EQ(calib::judge_response(edge).trouble, Trouble::too_short);
  expect_says(calib::judge_response(edge).reason, {"the MTF at 0.5"});
}

}  // namespace

TEST(MeasureOutcomes, NoData) {
  for (const std::int64_t size : {1, 2, 3, 4})
    EXPECT_EQ(measure(draw(size, size, [](double i, double) { return i; })).trouble, Trouble::no_data);
  EXPECT_EQ(measure(draw(64, 64, [](double, double) { return NAN; })).trouble, Trouble::no_data);
  EXPECT_EQ(measure(draw(64, 64, [](double i, double) { return i < 32.0 ? INFINITY : -INFINITY; })).trouble,
            Trouble::no_data);
}

TEST(MeasureOutcomes, NoEdge) {
  std::mt19937_64 bits(3);
  std::normal_distribution<double> normal;
  EXPECT_EQ(measure(draw(64, 64, [](double, double) { return 5.0; })).trouble, Trouble::no_edge);
  for (const std::int64_t size : {10, 20, 100})
    EXPECT_EQ(measure(draw(size, size, [&](double, double) { return normal(bits); })).trouble, Trouble::no_edge);
  EXPECT_EQ(measure(draw(128, 100, [&](double i, double) { return i + normal(bits); })).trouble, Trouble::no_edge);
  EXPECT_EQ(measure(draw(128, 100, [](double i, double) { return i; })).trouble, Trouble::no_edge);
}

TEST(MeasureOutcomes, SeveralEdgesAndOtherStructure) {
  const auto parity = [](double a) { return std::fmod(std::floor(a), 2.0) != 0.0; };
  EXPECT_EQ(measure(draw(128, 100, [&](double i, double j) { return parity(i / 32.0) != parity(j / 32.0); })).trouble,
            Trouble::several_edges);
  EXPECT_EQ(measure(draw(128, 100, [&](double i, double) { return parity(i / 8.0); })).trouble, Trouble::several_edges);
  EXPECT_EQ(measure(draw(128, 100, [](double i, double j) { return i > 60.0 && j > 50.0; })).trouble,
            Trouble::several_edges);
  const mtf::Image spotted = changed(usual(), [](float v, std::int64_t i, std::int64_t j) {
    return (i - 100) * (i - 100) + (j - 50) * (j - 50) < 200 ? 0.45F : v;
  });
  EXPECT_EQ(measure(spotted).trouble, Trouble::contaminated);
}

TEST(MeasureOutcomes, TooShortOrOffTheRegion) {
  for (const std::int64_t height : {1, 2, 6})
    EXPECT_EQ(measure(draw(100, height, [](double i, double j) { return 1.0 / (1.0 + std::exp(50.0 - i - 0.2 * j)); }))
                  .trouble,
              Trouble::too_short);
  made::Scene scene;
  scene.noise_sd = 0.01;
  scene.width = 5;
  EXPECT_EQ(measure(made::make(made::Step::gaussian(0.1), scene)).trouble, Trouble::off_region);
}

TEST(MeasureOutcomes, Clipped) {
  const mtf::Image cut = changed(usual(), [](float v, std::int64_t, std::int64_t) { return std::min(v, 0.7F); });
  EXPECT_EQ(measure(cut).trouble, Trouble::clipped) << "found without being told";
  calib::MeasureOptions options;
  options.saturation = 0.7;
  const EdgeMeasurement told = measure(cut, options);
  EXPECT_EQ(told.trouble, Trouble::clipped);
  EXPECT_GT(told.clipped_share, 0.3);
  options.saturation = 0.83;
  const EdgeMeasurement few = measure(usual(), options);
  EXPECT_EQ(few.trouble, Trouble::none) << few.reason;
  EXPECT_FALSE(few.warnings.empty());
}

TEST(MeasureOutcomes, AnyScaleOfValues) {
  const mtf::Image image = usual();
  const double expected = measure(image).mtf50->value;
  for (const float factor : {1e30F, 3e38F, -1.0F, 1e-30F}) {
    const EdgeMeasurement found =
        measure(changed(image, [factor](float v, std::int64_t, std::int64_t) { return v * factor; }));
    ASSERT_EQ(found.trouble, Trouble::none) << factor << ' ' << found.reason;
    EXPECT_NEAR(found.mtf50->value, expected, 1e-4) << factor;
    EXPECT_LT(found.dark, found.bright);
  }
}

TEST(MeasureOutcomes, MasksAndBayerPlanes) {
  const mtf::Image image = usual();
  const std::vector<std::function<bool(std::int64_t, std::int64_t)>> masks{
      [](std::int64_t i, std::int64_t j) { return i % 2 == 0 && j % 2 == 0; },
      [](std::int64_t i, std::int64_t j) { return i % 2 == 1 && j % 2 == 0; },
      [](std::int64_t i, std::int64_t j) { return (i + j) % 2 == 1; },
      [](std::int64_t i, std::int64_t j) { return (i * 7 + j * 13) % 5 < 2; },
      [](std::int64_t, std::int64_t j) { return j < 40 || j > 60; }};
  for (const auto& kept : masks) {
    const EdgeMeasurement found =
        measure(changed(image, [&kept](float v, std::int64_t i, std::int64_t j) { return kept(i, j) ? v : kNone; }));
    ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
    EXPECT_NEAR(found.mtf50->value, 0.3, 4.0 * found.mtf50->sd);
  }
}

TEST(MeasureOutcomes, HotPixelsAreLeftOut) {
  std::mt19937_64 bits(3);
  mtf::Image image = usual();
  for (int k = 0; k < 60; ++k)
    image.at(static_cast<std::int64_t>(bits() % 128), static_cast<std::int64_t>(bits() % 100)) = 5.0F;
  const EdgeMeasurement found = measure(image);
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  EXPECT_NEAR(found.mtf50->value, 0.3, 4.0 * found.mtf50->sd);
  EXPECT_FALSE(found.warnings.empty());
}

TEST(MeasureOutcomes, FewBitsDivideByNothing) {
  made::Scene scene;
  for (const double quantum : {1.0 / 255.0, 1.0 / 15.0, 0.3}) {
    scene.quantum = quantum;
    const mtf::Image image = made::make(made::Step::gaussian(0.3), scene);
    calib::MeasureOptions options;
    options.quantum = quantum;
    EXPECT_GT(measure(image, options).noise_sd, 0.2 * quantum);
    measure(image);
  }
}

TEST(MeasureOutcomes, LargeRegions) {
  made::Scene scene;
  scene.width = scene.height = 1500;
  scene.noise_sd = 0.01;
  for (const double angle_deg : {5.0, 60.0}) {
    scene.angle_deg = angle_deg;
    const EdgeMeasurement found = measure(made::make(made::Step::gaussian(0.3), scene));
    ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
    EXPECT_NEAR(found.mtf50->value, 0.3, 1.5e-3);
  }
}

TEST(MeasureOutcomes, PhotonNoiseIsSeen) {
  made::Scene scene;
  scene.noise_sd = 2e-3;
  scene.noise_gain = 4e-4;
  const EdgeMeasurement found = measure(made::make(made::Step::gaussian(0.3), scene));
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  EXPECT_NEAR(found.noise_gain, 4e-4, 1e-4);
  EXPECT_NEAR(found.noise_sd, std::sqrt(4e-6 + 4e-4 * 0.5), 1e-3);
}

TEST(MeasureOutcomes, MisuseIsRefused) {
  const mtf::Image image = usual();
  EXPECT_THROW(calib::measure_edge(image.view(), {0, 0, 0, 10}), mtf::UsageError);
  EXPECT_THROW(calib::measure_edge(image.view(), {100, 0, 50, 10}), mtf::UsageError);
  EXPECT_THROW(calib::measure_edge(image.view(), {-1, 0, 50, 10}), mtf::UsageError);
  calib::MeasureOptions options;
  options.order = 6;
  EXPECT_THROW(calib::measure_edge(image.view(), {0, 0, 64, 64}, options), mtf::UsageError);
  options = {};
  options.noise_sd = -1.0;
  EXPECT_THROW(calib::measure_edge(image.view(), {0, 0, 64, 64}, options), mtf::UsageError);
}

// Sides are clipped at the floor as at the saturation; plateaus that hold one or two of the possible values are not.
TEST(MeasureOutcomes, CutOffOrCoarselyQuantised) {
  const mtf::Image floor = changed(usual(), [](float v, std::int64_t, std::int64_t) { return std::max(v, 0.3F); });
  EXPECT_EQ(measure(floor).trouble, Trouble::clipped);
  made::Scene scene;
  scene.dark = 100.3;
  scene.bright = 130.45;
  scene.noise_sd = 0.25;
  scene.quantum = 1.0;
  calib::MeasureOptions options;
  options.quantum = 1.0;
  const EdgeMeasurement found = measure(made::make(made::Step::gaussian(0.3), scene), options);
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  EXPECT_NEAR(found.mtf50->value, 0.3, 5.0 * found.mtf50->sd);
}

// On a sharp edge few values lie between the sides: the last one below a clipped side may be far from it by chance.
TEST(MeasureOutcomes, OneSideClippedBesideASharpEdge) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    made::Scene scene;
    scene.height = 60;
    scene.noise_sd = 0.004;
    scene.seed = seed;
    const auto cut = [&](float v, std::int64_t, std::int64_t) {
      return seed % 2 == 0 ? std::min(v, 0.7F) : std::max(v, 0.3F);
    };
    const EdgeMeasurement found = measure(changed(made::make(made::Step::gaussian(0.45), scene), cut));
    EXPECT_EQ(found.trouble, Trouble::clipped) << seed << found.reason;
  }
}

// Both sides clipped far inside their plateaus have no noise, and the rest of the edge is too steep.
TEST(MeasureOutcomes, ClippedOnBothSides) {
  const auto cut = [](float v, std::int64_t, std::int64_t) { return std::clamp(v, 0.28F, 0.72F); };
  for (const double noise_sd : {0.003, 0.01, 0.03})
    for (const std::int64_t height : {40, 100})
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        made::Scene scene;
        scene.height = height;
        scene.noise_sd = noise_sd;
        scene.seed = seed;
        const EdgeMeasurement found = measure(changed(made::make(made::Step::gaussian(0.3), scene), cut));
        EXPECT_EQ(found.trouble, Trouble::clipped) << noise_sd << ' ' << height << ' ' << seed << found.reason;
      }
  const auto words = [](const EdgeMeasurement& found) {
    return std::count_if(found.warnings.begin(), found.warnings.end(),
                         [](const std::string& one) { return says(one, "sides are clipped"); });
  };
  // Without noise it is the abrupt end of the values that tells.
  EXPECT_EQ(words(measure(changed(usual(0.0), cut))), 1);
  for (const bool bright : {true, false}) {
    const auto one = [&](float v, std::int64_t, std::int64_t) {
      return bright ? std::min(v, 0.72F) : std::max(v, 0.28F);
    };
    EXPECT_EQ(words(measure(changed(usual(0.0), one))), 1) << bright;
    made::Scene few;  // values on a sharp edge
    few.height = 80;
    EXPECT_EQ(words(measure(changed(made::make(made::Step::gaussian(0.42), few), one))), 1) << bright;
  }
  for (const double angle_deg : {1.0, 5.0, 20.0, 45.0}) {
    made::Scene scene;
    scene.angle_deg = angle_deg;
    const made::Step narrow = made::Step::gaussian(0.5), wide = made::Step::gaussian(0.1),
                     camera = made::camera_step(made::camera_of(8.0), angle_deg);
    for (const made::Step* step : {&narrow, &wide, &camera}) {
      const EdgeMeasurement found = measure(made::make(*step, scene));
      EXPECT_EQ(found.trouble, Trouble::none) << found.reason;
      EXPECT_EQ(words(found), 0) << angle_deg;
    }
  }
}

TEST(MeasureOutcomes, OneHugePixelIsLeftOut) {
  for (const float hot : {1e4F, 1e10F, -1e30F}) {
    mtf::Image image = usual();
    image.at(20, 20) = hot;
    const EdgeMeasurement found = measure(image);
    ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
    EXPECT_NEAR(found.mtf50->value, 0.3, 4.0 * found.mtf50->sd);
    EXPECT_FALSE(found.warnings.empty());
  }
}

TEST(MeasureOutcomes, NoiseBeyondAnyEdge) {
  calib::MeasureOptions options;
  for (const double sd : {1e3, 1e200, 1e300}) {
    options.noise_sd = sd;
    EXPECT_EQ(measure(usual(), options).trouble, Trouble::no_edge);
  }
}

// One column of pixels alone sees the step: the fit must not move the edge away from the pixels.
TEST(MeasureOutcomes, UprightSharpEdgesStay) {
  made::Scene scene;
  scene.width = scene.height = 120;
  scene.angle_deg = 0.0;
  scene.noise_sd = 0.002;
  for (int k = 0; k < 20; ++k) {
    scene.x = 60.0 + 0.05 * k;
    scene.seed = static_cast<std::uint64_t>(k) + 1;
    const EdgeMeasurement found = measure(made::make(made::Step::gaussian(0.6246), scene));
    ASSERT_EQ(found.trouble, Trouble::none) << found.reason << k;
    EXPECT_FALSE(found.warnings.empty());
    EXPECT_TRUE(!found.mtf50 || std::abs(found.mtf50->value - 0.6246) < 5.0 * found.mtf50->sd) << k;
  }
}

// Overshoot is far from any smooth step, but all pixels at its distance have it: these are no single bad pixels.
TEST(MeasureOutcomes, SharpenedEdgesKeepTheirOvershoot) {
  constexpr double kSigma2_px2 = 0.39, kRadius2_px2 = 1.0, kAmount = 3.0;
  const auto gauss = [](double variance, double f) {
    return std::exp(-2.0 * std::pow(std::numbers::pi * f, 2) * variance);
  };
  const made::Step step(
      [&](double f) { return gauss(kSigma2_px2, f) * (1.0 + kAmount * (1.0 - gauss(kRadius2_px2, f))); }, 2.0, 120.0);
  const EdgeMeasurement found = measure(made::make(step, {.noise_sd = 0.01}));
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  EXPECT_GT(*std::max_element(found.mtf.begin(), found.mtf.end()), 1.8);
  EXPECT_NEAR(found.mtf50->value / step.crossing(0.5), 1.0, 5.0 * found.mtf50->sd / found.mtf50->value);
  EXPECT_LT(found.mtf50->sd, 0.01);
}

// All rows show the same few distances, so that a step as sharp as that between two columns is a minimum too.
TEST(MeasureOutcomes, UprightEdgesDoNotCollapse) {
  const made::Step step = made::Step::gaussian(0.3);
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    made::Scene scene;
    scene.angle_deg = 0.0;
    scene.x = 64.2 + 0.005 * static_cast<double>(seed);
    scene.noise_sd = 0.01;
    scene.seed = seed;
    const EdgeMeasurement found = measure(made::make(step, scene));
    ASSERT_TRUE(found.mtf50) << *scene.x << ' ' << found.reason;
    EXPECT_NEAR(found.mtf50->value, 0.3, 5.0 * found.mtf50->sd) << *scene.x;
    EXPECT_LT(found.mtf50->sd, 0.03) << *scene.x;
  }
}

TEST(MeasureOutcomes, PixelsWithoutDataAreCounted) {
  mtf::Image image = made::make(made::Step::gaussian(0.3), {.noise_sd = 0.01});
  image.at(3, 4) = std::numeric_limits<float>::quiet_NaN();
  image.at(90, 60) = std::numeric_limits<float>::infinity();
  const EdgeMeasurement found = measure(image);
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  EXPECT_EQ(found.missing, 2);
  ASSERT_EQ(found.warnings.size(), 1U);
  expect_says(found.warnings.front(), {"2 pixels"});
  const EdgeMeasurement expected = calib::measure_edge(image.view(), {0, 0, 128, 100}, {.sparse = true});
  EXPECT_EQ(expected.missing, 2);
  EXPECT_TRUE(expected.warnings.empty());
}

// A glowing line beside a weak step is brighter than both plateaus: this is no edge between two plateaus.
TEST(MeasureOutcomes, RidgesAreNotSteps) {
  made::Scene scene;
  scene.noise_sd = 0.005;
  mtf::Image image = made::make(made::Step::gaussian(0.2), scene);
  for (std::int64_t j = 0; j < image.height(); ++j)
    for (std::int64_t i = 0; i < image.width(); ++i) {
      const double d = made::distance(scene, static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5);
      image.at(i, j) += static_cast<float>(1.5 * std::exp(-0.02 * (d - 4.0) * (d - 4.0)));
    }
  const EdgeMeasurement found = measure(image);
  EXPECT_EQ(found.trouble, Trouble::contaminated) << found.reason;
  expect_says(found.reason, {"a ridge, a glow"});
}
