// SPDX-License-Identifier: Apache-2.0
// Edges in images with a defect: the stated 95 % intervals hold as often as they say, are no wider than without the
// defect where it costs no information, and the words name it. tests/bench/bench_coverage.cpp prints the same for many
// sizes and contrasts; MeasureDefectsLong draws what takes longer: further sizes, contrasts and kinds of noise.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "calib/find/find_edges.h"
#include "calib/measure/measure.h"
#include "tests/calib/made_defects.h"
#include "tests/calib/made_edges.h"
#include "tests/expect_error.h"

namespace {

using calib::EdgeMeasurement;
using Defect = std::function<void(mtf::Image&, const made::Scene&)>;

constexpr std::array<double, 4> kFrequencies{0.05, 0.1, 0.25, 0.5};

std::size_t index_of(double f) { return static_cast<std::size_t>(std::lround(f / calib::kCurveStep_cy_px)); }

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Tested {
  made::Step step;
  made::Scene scene;
  Defect defect;
  std::string word;  ///< that a warning of nearly every draw holds
  calib::MeasureOptions options{};
  double widest = 1.1;  ///< median interval, in parts of that without the defect
  bool find = false;    ///< the region is that of find_edges, otherwise the whole image
};

// Of 300 draws 95 % hold, less three standard deviations of that number, and no fewer than without the defect but for a
// few.
void expect_coverage(Tested one) {
  constexpr int kDraws = 300;
  constexpr double kLeastHeld = 0.912, kFewer = 0.03;
  std::mt19937_64 bits(8);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  std::array<int, kFrequencies.size()> held{}, clean_held{};
  std::array<std::vector<double>, kFrequencies.size()> sd, clean_sd;
  int refused = 0, named = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    one.scene.x = 0.5 * static_cast<double>(one.scene.width) + phase(bits);
    one.scene.y = 0.5 * static_cast<double>(one.scene.height) + phase(bits);
    one.scene.seed = bits();
    mtf::Image image = made::make(one.step, one.scene);
    const calib::Roi all{0, 0, image.width(), image.height()};
    const EdgeMeasurement clean = calib::measure_edge(image.view(), all);
    one.defect(image, one.scene);
    calib::Roi roi = all;
    if (one.find) {
      const calib::FoundEdges regions = calib::find_edges(image.view());
      ASSERT_FALSE(regions.edges.empty()) << regions.reason;
      roi = regions.edges.front().roi;
    }
    const EdgeMeasurement found = calib::measure_edge(image.view(), roi, one.options);
    if (found.trouble != calib::Trouble::none) {
      ++refused;
      continue;
    }
    named += says(found.warnings, one.word) ? 1 : 0;
    for (std::size_t k = 0; k < kFrequencies.size(); ++k) {
      const std::size_t i = index_of(kFrequencies[k]);
      const double truth = std::abs(one.step.mtf(kFrequencies[k]));
      held[k] += std::abs(found.mtf[i] - truth) <= 1.96 * found.mtf_sd[i] ? 1 : 0;
      clean_held[k] += std::abs(clean.mtf[i] - truth) <= 1.96 * clean.mtf_sd[i] ? 1 : 0;
      sd[k].push_back(found.mtf_sd[i]);
      clean_sd[k].push_back(clean.mtf_sd[i]);
    }
  }
  EXPECT_LE(refused, kDraws / 100);
  EXPECT_GE(named, one.word.empty() ? 0 : 95 * kDraws / 100);
  for (std::size_t k = 0; k < kFrequencies.size(); ++k) {
    EXPECT_GE(held[k], kLeastHeld * (kDraws - refused)) << kFrequencies[k];
    EXPECT_GE(held[k], clean_held[k] - kFewer * kDraws) << kFrequencies[k];
    EXPECT_LE(median_of(sd[k]), one.widest * median_of(clean_sd[k])) << kFrequencies[k];
  }
}

made::Scene scene_of(std::int64_t width, std::int64_t height, double cnr) {
  return {.width = width, .height = height, .x = {}, .y = {}, .noise_sd = 0.6 / cnr};
}

const made::Step& airy() {
  static const made::Step step = made::camera_step(made::camera_of(8.0), 5.0);
  return step;
}

void nothing(mtf::Image&, const made::Scene&) {}

void hidden_diffraction(std::int64_t width, std::int64_t height, double cnr) {
  for (const made::Step& step : {made::Step::gaussian(0.3), airy()}) {
    SCOPED_TRACE(std::to_string(width) + " px, contrast / noise " + std::to_string(cnr));
    expect_coverage({step, scene_of(width, height, cnr), nothing, ""});
  }
}

void few_pixels(std::int64_t width, std::int64_t height, double cnr) {
  SCOPED_TRACE(std::to_string(width) + " px, contrast / noise " + std::to_string(cnr));
  expect_coverage({airy(), scene_of(width, height, cnr), nothing, "noise of a pixel"});
}

const made::Step& out_of_focus() {
  static const made::Step step = [] {
    made::Camera camera = made::camera_of(8.0);
    camera.w020 = 1.0;
    return made::camera_step(camera, 5.0);
  }();
  return step;
}

void narrow_defocus(double cnr) {
  expect_coverage({out_of_focus(), scene_of(40, 60, cnr), nothing, "tails of the blur"});
}

void hot_pixels(double more) {
  SCOPED_TRACE(more);
  const Defect hot = [more](mtf::Image& image, const made::Scene& scene) {
    made::heat_pixels(image, 0.002, more, scene.seed);
  };
  expect_coverage({made::Step::gaussian(0.3), scene_of(64, 80, 40.0), hot, "as hot"});
  expect_coverage({airy(), scene_of(64, 80, 12.0), hot, "as hot"});
}

/// A dark side 1.5 standard deviations above zero: one in fifteen of its values is cut off.
void cut_off_at_zero(const made::Step& step, double cnr) {
  const auto cut = [](mtf::Image& image, const made::Scene&) { made::cut_off_below(image, 0.0); };
  for (const std::optional<double> floor : {std::optional<double>(0.0), std::optional<double>()}) {
    made::Scene scene = scene_of(64, 80, cnr);
    scene.dark = 1.5 * scene.noise_sd;
    scene.bright = scene.dark + 0.6;
    expect_coverage({step, scene, cut, "noise is cut off", {.floor = floor}});
  }
}

void shared_noise(const Defect& defect, double cnr, double widest) {
  expect_coverage({airy(), scene_of(64, 80, cnr), defect, "correlated between neighbouring pixels", {}, widest});
}

}  // namespace

// Much noise, or few pixels: how much of the blur is diffraction is hidden, and with it the MTF at low frequencies.
TEST(MeasureDefects, DiffractionThatNoiseHides) {
  const made::Step gaussian = made::Step::gaussian(0.3);
  hidden_diffraction(24, 24, 12.0);
  made::Scene scene = scene_of(24, 24, 12.0);
  const EdgeMeasurement hidden = calib::measure_edge(made::make(gaussian, scene).view(), {0, 0, 24, 24});
  EXPECT_TRUE(says(hidden.warnings, "blur is diffraction"));
  scene = scene_of(128, 100, 12.0);
  const EdgeMeasurement clear = calib::measure_edge(made::make(gaussian, scene).view(), {0, 0, 128, 100});
  EXPECT_TRUE(clear.warnings.empty());
}
TEST(MeasureDefectsLong, DiffractionThatNoiseHides) {
  for (const double cnr : {4.0, 6.0}) hidden_diffraction(64, 80, cnr);
}

// Errors of a tenth and more: the MTF of an edge that comes out too blurred depends little on the blur, but that of the
// true one does.
TEST(MeasureDefects, FewPixelsOfLittleContrast) { few_pixels(24, 24, 4.0); }
TEST(MeasureDefectsLong, FewPixelsOfLittleContrast) {
  few_pixels(24, 24, 6.0);
  few_pixels(40, 60, 4.0);
}

// The tails of a lens out of focus extend beyond short sides, where only the reference says how large they are.
TEST(MeasureDefects, DefocusInNarrowRegions) {
  narrow_defocus(12.0);
  for (const double y : {30.0, 30.3, 30.6}) {
    made::Scene scene = scene_of(40, 60, 1e12);
    scene.y = y;
    const EdgeMeasurement found = calib::measure_edge(made::make(out_of_focus(), scene).view(), {0, 0, 40, 60});
    ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
    EXPECT_TRUE(says(found.warnings, "tails of the blur"));
    for (const double f : kFrequencies) {
      const double truth = std::abs(out_of_focus().mtf(f));
      EXPECT_NEAR(found.mtf[index_of(f)], truth, 1.96 * found.mtf_sd[index_of(f)]) << f;
      EXPECT_LT(found.mtf_sd[index_of(f)], 0.02) << f;
    }
  }
}

TEST(MeasureDefectsLong, DefocusInNarrowRegions) { narrow_defocus(30.0); }

TEST(MeasureDefects, HotPixels) { hot_pixels(0.3); }
TEST(MeasureDefectsLong, HotPixels) {
  for (const double more : {1.0, -2.0}) hot_pixels(more);
}

TEST(MeasureDefects, HotPixelsOnEdgesWithoutNoise) {
  for (const double more : {0.3, 1.0}) {
    made::Scene scene = scene_of(128, 100, 1e12);
    scene.seed = 5;
    mtf::Image image = made::make(airy(), scene);
    made::heat_pixels(image, 0.002, more, 5);
    const EdgeMeasurement found = calib::measure_edge(image.view(), {0, 0, 128, 100});
    ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
    EXPECT_TRUE(says(found.warnings, "as hot"));
    for (std::size_t i = 0; i <= 100; ++i)
      EXPECT_NEAR(found.mtf[i], std::abs(airy().mtf(found.frequency_cy_px[i])), 3e-4) << found.frequency_cy_px[i];
  }
}

// The region around an edge does not end at hot pixels, touching ones included.
TEST(MeasureDefects, HotPixelsCutNoRegion) {
  for (const double cnr : {12.0, 40.0, 1e12})
    for (const double more : {0.3, 1.0}) {
      mtf::Image image = made::make(made::Step::gaussian(0.3), scene_of(128, 100, cnr));
      made::heat_pixels(image, 0.002, more, 7);
      image.at(20, 30) += static_cast<float>(more);
      image.at(21, 31) += static_cast<float>(more);
      const calib::FoundEdges found = calib::find_edges(image.view());
      ASSERT_EQ(found.edges.size(), 1U) << found.reason;
      EXPECT_EQ(found.edges.front().roi, (calib::Roi{0, 0, 128, 100})) << cnr << ' ' << more;
    }
}

// A pixel that is many orders of magnitude away sets no scale for the search.
TEST(MeasureDefects, OneWildPixelHidesNoEdge) {
  for (const double cnr : {12.0, 1e12})
    for (const float wild : {1e30F, -3e38F, 1e3F}) {
      mtf::Image image = made::make(made::Step::gaussian(0.3), scene_of(128, 100, cnr));
      image.at(40, 30) = wild;
      const calib::FoundEdges found = calib::find_edges(image.view());
      ASSERT_EQ(found.edges.size(), 1U) << found.reason;
      EXPECT_EQ(found.edges.front().roi, (calib::Roi{0, 0, 128, 100})) << cnr << ' ' << wild;
      const EdgeMeasurement edge = calib::measure_edge(image.view(), found.edges.front().roi);
      ASSERT_EQ(edge.trouble, calib::Trouble::none) << edge.reason;
      EXPECT_NEAR(edge.mtf50->value, 0.3, 5.0 * edge.mtf50->sd);
    }
}

TEST(MeasureDefects, NoiseCutOffAtZero) { cut_off_at_zero(airy(), 30.0); }
TEST(MeasureDefectsLong, NoiseCutOffAtZero) { cut_off_at_zero(made::Step::gaussian(0.3), 12.0); }

// The same on the bright side; reflections on the dark side are saturated too, but not by its noise, and are left out.
TEST(MeasureDefects, NoiseCutOffAtSaturation) {
  const auto cut = [](mtf::Image& image, const made::Scene& scene) {
    for (std::int64_t i = 30; i < 36; ++i) image.at(i - 25, i) = 9.0F;
    const double saturation = scene.bright + 1.5 * scene.noise_sd;
    for (std::int64_t j = 0; j < image.height(); ++j)
      for (std::int64_t i = 0; i < image.width(); ++i)
        image.at(i, j) = std::min(image.at(i, j), static_cast<float>(saturation));
  };
  made::Scene scene = scene_of(64, 80, 30.0);
  expect_coverage({airy(), scene, cut, "noise is cut off", {.saturation = scene.bright + 1.5 * scene.noise_sd}});
  expect_coverage({airy(), scene, cut, "noise is cut off"});
}

// The tail of another edge's diffraction extends into the region that the finder ends before it. At 20 px the short
// sides cost information about low frequencies: they leave open whether light is scattered far.
TEST(MeasureDefects, ASecondEdgeBesideTheRegion) {
  for (const double apart_px : {20.0, 45.0}) {
    SCOPED_TRACE(apart_px);
    const auto second = [apart_px](mtf::Image& image, const made::Scene& scene) {
      made::add_second_edge(image, scene, airy(), apart_px, -0.6);
    };
    expect_coverage({airy(), scene_of(128, 80, 60.0), second, "another edge", {}, 3.5, true});
    made::Scene scene = scene_of(128, 100, 1e12);
    mtf::Image image = made::make(airy(), scene);
    second(image, scene);
    for (const calib::FoundEdge& region : calib::find_edges(image.view()).edges) {
      const EdgeMeasurement found = calib::measure_edge(image.view(), region.roi);
      ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
      for (std::size_t i = 0; i <= 100; ++i)
        EXPECT_NEAR(found.mtf[i], std::abs(airy().mtf(found.frequency_cy_px[i])), 5e-4) << found.frequency_cy_px[i];
    }
  }
}

// Noise that neighbours share is larger at low frequencies than that of independent pixels of the same deviation: the
// intervals are wider there.
TEST(MeasureDefects, NoiseThatNeighboursShare) {
  shared_noise([](auto& image, const auto& scene) { made::correlate_noise(image, scene, airy(), 0.8); }, 60.0, 3.0);
}
TEST(MeasureDefects, NoiseOfDemosaicing) {
  shared_noise([](auto& image, const auto& scene) { made::interpolate_noise(image, scene, airy()); }, 30.0, 1.5);
}
TEST(MeasureDefects, NoiseOfCompression) {
  shared_noise([](auto& image, const auto& scene) { made::compress_noise(image, scene, airy()); }, 30.0, 1.3);
}

// The noise of independent pixels has no correlation by chance, whatever its size.
TEST(MeasureDefects, IndependentNoiseIsNotSharedByNeighbours) {
  for (const double cnr : {6.0, 30.0, 200.0, 1e5})
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      made::Scene scene = scene_of(64, 80, cnr);
      scene.seed = seed;
      const EdgeMeasurement found = calib::measure_edge(made::make(airy(), scene).view(), {0, 0, 64, 80});
      ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
      EXPECT_FALSE(says(found.warnings, "correlated")) << cnr << ' ' << seed;
    }
}

// Values that are heaped up for other reasons are no noise cut off: plateaus of few values, a side that is all zero.
TEST(MeasureDefects, HeapsOfRoundedValuesAreNotCutOff) {
  made::Scene scene = scene_of(128, 100, 60.0);
  for (const double quantum : {0.6 / 200.0, 0.6 / 100.0, 0.6 / 20.0}) {
    scene.quantum = quantum;
    const mtf::Image image = made::make(made::Step::gaussian(0.3), scene);
    const EdgeMeasurement found = calib::measure_edge(image.view(), {0, 0, 128, 100}, {.quantum = quantum});
    ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
    EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
    EXPECT_EQ(found.clipped_share, 0.0);
  }
  scene = scene_of(128, 100, 1e12);
  scene.dark = 0.0;
  const mtf::Image image = made::make(made::Step::gaussian(0.3), scene);
  const EdgeMeasurement found = calib::measure_edge(image.view(), {0, 0, 128, 100});
  ASSERT_EQ(found.trouble, calib::Trouble::none) << found.reason;
  EXPECT_FALSE(says(found.warnings, "cut off"));
}
