// SPDX-License-Identifier: Apache-2.0
// Edges without noise: how far measure_edge is from their MTF.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "calib/measure/measure.h"
#include "tests/calib/made_edges.h"
#include "tests/calib/public_edges.h"
#include "tests/expect_error.h"

namespace {

using calib::EdgeMeasurement;
using calib::Trouble;

EdgeMeasurement measure(const mtf::Image& image, const calib::MeasureOptions& options = {}) {
  return calib::measure_edge(image.view(), {0, 0, image.width(), image.height()}, options);
}

double rms_error(const EdgeMeasurement& found, const made::Step& step) {
  double sum = 0.0;
  for (std::size_t i = 0; i <= 100; ++i)
    sum += std::pow(found.mtf[i] - std::abs(step.mtf(found.frequency_cy_px[i])), 2);
  return std::sqrt(sum / 101.0);
}

void expect_close(const EdgeMeasurement& found, const made::Step& step, double mtf50_percent, double rms) {
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  ASSERT_TRUE(found.mtf50.has_value());
  EXPECT_NEAR(100.0 * (found.mtf50->value / step.crossing(0.5) - 1.0), 0.0, mtf50_percent);
  EXPECT_LE(rms_error(found, step), rms);
}

made::Scene scene_at(double angle_deg, double phase_px = 0.23) {
  made::Scene scene;
  scene.angle_deg = angle_deg;
  scene.x = 64.0 + phase_px;
  return scene;
}

}  // namespace

TEST(MeasureTruth, ThePublicSet) {
  const auto all = public_edges::cases();
  if (all.empty()) GTEST_SKIP() << "no shared data";
  for (const auto& one : all) {
    SCOPED_TRACE(one.file);
    calib::MeasureOptions options;
    if (one.bits < 16) options.quantum = 1.0 / 255.0;
    if (one.encoding == "sRGB")  // dL / dv of IEC 61966-2-1, above its straight part
      options.quantum_at = [](double light) { return 2.4 / 1.055 * std::pow(light, 1.4 / 2.4) / 255.0; };
    const EdgeMeasurement found = measure(public_edges::read(one), options);
    ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
    const bool noisy = one.noise_sigma > 0.0, gaussian = one.psf == "gaussian";
    // Undithered 8-bit plateaus are off by up to half a step: 0.2 % of MTF50 when that is accounted for, 0.65 % in the
    // sRGB file for programs that do not.
    const double bar = noisy ? 2.5 : one.bits < 16 ? 0.35 : gaussian ? 0.01 : 0.02;
    EXPECT_NEAR(100.0 * (found.mtf50->value / one.mtf50 - 1.0), 0.0, bar);
    double sum = 0.0, n = 0.0;
    for (std::size_t i = 0; i < one.frequency.size() && one.frequency[i] < 0.501; ++i, n += 1.0) {
      const auto k = static_cast<std::size_t>(std::lround(one.frequency[i] / calib::kCurveStep_cy_px));
      sum += std::pow(found.mtf[k] - one.mtf[i], 2);
    }
    // Of 8 bits, noise that is hidden in a step leaves open whether 0.3 % of the light is scattered far.
    EXPECT_LE(std::sqrt(sum / n), noisy ? 1e-2 : one.bits < 16 ? 1.8e-3 : 4e-4);
    EXPECT_NEAR(std::abs(found.angle_deg.value), one.angle_deg, noisy ? 0.03 : 5e-3);
    EXPECT_NEAR(found.sagitta_px, one.sagitta_px, 0.01);
    const calib::EdgePoint at = calib::locate(found.curve, {one.x, one.y});
    EXPECT_NEAR(at.distance_px, 0.0, noisy ? 0.02 : 2e-3);
  }
}

TEST(MeasureTruth, GaussiansOfAnyWidthAndDirection) {
  for (const double mtf50 : {0.08, 0.15, 0.3, 0.5}) {
    const made::Step step = made::Step::gaussian(mtf50);
    for (const double angle_deg : {2.0, 7.0, 26.565, 44.0, 45.0, 93.0, -60.0, 170.0}) {
      SCOPED_TRACE(std::to_string(mtf50) + " at " + std::to_string(angle_deg));
      expect_close(measure(made::make(step, scene_at(angle_deg))), step, 0.01, 5e-5);
    }
  }
}

// Angles at which the pixels' distances repeat, and blurs narrower than the gaps between them.
TEST(MeasureTruth, ResonantAngles) {
  for (const double mtf50 : {0.6246, 0.937}) {
    const made::Step step = made::Step::gaussian(mtf50);
    for (const double angle_deg : {14.0362, 18.4349, 26.565, 33.69, 33.6901}) {
      for (const double phase_px : {0.0, 0.13, 0.3, 0.5}) {
        SCOPED_TRACE(std::to_string(mtf50) + " at " + std::to_string(angle_deg) + ", " + std::to_string(phase_px));
        const EdgeMeasurement found = measure(made::make(step, scene_at(angle_deg, phase_px)));
        // Two distances a pixel may be too few for a blur of a fifth of one; then the outcome says so.
        if (mtf50 > 0.9 && found.oversampling < 3.0 && found.trouble != Trouble::none) continue;
        ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
        ASSERT_TRUE(found.mtf50.has_value());
        EXPECT_NEAR(found.mtf50->value, mtf50, std::max(1e-3 * mtf50, 5.0 * found.mtf50->sd));
      }
    }
  }
}

// At 45 degrees only one and a half distances a pixel occur, which the standard deviation has to include.
TEST(MeasureTruth, FewDistancesAreUncertain) {
  const made::Step step = made::Step::gaussian(0.6246);
  int refused = 0;
  for (int k = 0; k < 24; ++k) {
    made::Scene scene = scene_at(k % 2 == 0 ? 45.0 : 0.0, k / 24.0);
    scene.noise_sd = k % 3 == 0 ? 0.002 : 0.01;
    scene.seed = static_cast<std::uint64_t>(k) + 1;
    const EdgeMeasurement found = measure(made::make(step, scene));
    if (found.trouble != Trouble::none) {  // an edge between two columns may say nothing of the blur: MTF 4000 +- 10000
      EXPECT_EQ(found.trouble, Trouble::too_short) << found.reason;
      expect_says(found.reason, {"tilt the edge"});
      ++refused;
      continue;
    }
    EXPECT_FALSE(found.warnings.empty());
    EXPECT_TRUE(!found.mtf50 || std::abs(found.mtf50->value - 0.6246) < 5.0 * found.mtf50->sd)
        << k << ' ' << found.mtf50->value << ' ' << found.mtf50->sd;
  }
  EXPECT_LE(refused, 1);
}

TEST(MeasureTruth, Cameras) {
  for (const double f_number : {2.8, 4.0, 8.0, 11.0, 16.0}) {
    for (const double angle_deg : {4.0, 17.0, 30.0, -40.0}) {
      SCOPED_TRACE(std::to_string(f_number) + " at " + std::to_string(angle_deg));
      const made::Step step = made::camera_step(made::camera_of(f_number), angle_deg);
      expect_close(measure(made::make(step, scene_at(angle_deg))), step, 0.02, 1e-4);
    }
  }
}

TEST(MeasureTruth, AberrationsAndFilters) {
  made::Camera defocus = made::camera_of(8.0), spherical = defocus, filter = made::camera_of(5.6);
  defocus.w020 = 0.3;
  spherical.w020 = -0.3;
  spherical.w040 = 0.5;
  filter.olpf = 0.25;
  for (const made::Camera& camera : {defocus, spherical, filter}) {
    for (const double angle_deg : {5.0, 22.0}) {
      const made::Step step = made::camera_step(camera, angle_deg);
      expect_close(measure(made::make(step, scene_at(angle_deg))), step, 0.15, 1e-3);
    }
  }
}

// Blurs unlike the reference: with contrast beyond a first zero, along a motion, with contrast above 1.
TEST(MeasureTruth, ShapesFarFromTheReference) {
  made::Camera camera = made::camera_of(8.0);
  const made::Step sharp = made::camera_step(camera, 6.0);
  camera.w020 = 1.0;
  const auto motion = [&sharp](double f) {
    const double x = 3.0 * std::numbers::pi * f;
    return sharp.mtf(f) * (x == 0.0 ? 1.0 : std::sin(x) / x);
  };
  const auto sharpened = [&sharp](double f) { return sharp.mtf(f) * (2.0 - std::exp(-8.0 * f * f)); };
  const double top = 1.0 / camera.s;
  for (const made::Step& step : {made::camera_step(camera, 6.0), made::Step(motion, top, 120.0),
                                 made::Step(sharpened, top, 120.0), made::Step::gaussian(0.03)})
    expect_close(measure(made::make(step, scene_at(6.0))), step, 0.15, 1e-3);
}

TEST(MeasureTruth, BentEdges) {
  const made::Step step = made::Step::gaussian(0.3);
  made::Scene scene = scene_at(5.0);
  scene.sagitta_px = 1.5;
  const mtf::Image image = made::make(step, scene);
  const EdgeMeasurement chosen = measure(image);
  expect_close(chosen, step, 0.05, 2e-4);
  EXPECT_EQ(chosen.curve.order(), 2);
  // The edge is a little longer than the height of the image.
  EXPECT_NEAR(chosen.sagitta_px, 1.5 / std::pow(std::cos(5.0 * std::numbers::pi / 180.0), 2), 0.01);
  calib::MeasureOptions circle;
  circle.circle = true;
  expect_close(measure(image, circle), step, 0.05, 2e-4);
  calib::MeasureOptions fifth;
  fifth.order = 5;
  expect_close(measure(image, fifth), step, 0.05, 2e-4);
  calib::MeasureOptions line;
  line.order = 1;
  EXPECT_EQ(measure(image, line).trouble, Trouble::contaminated) << "a line is told that it does not fit";
}

TEST(MeasureTruth, UnevenLightIsTakenOut) {
  const made::Step step = made::Step::gaussian(0.3);
  made::Scene scene = scene_at(5.0);
  scene.gradient_bright = 2e-3;
  scene.gradient_dark = -1e-3;
  const EdgeMeasurement found = measure(made::make(step, scene));
  expect_close(found, step, 0.05, 2e-4);
  EXPECT_NEAR(found.dark, 0.2, 1e-4);
  EXPECT_NEAR(found.bright, 0.8, 1e-4);
}

// Vignetting is not linear in the distance, and the correction must not take it for blur.
TEST(MeasureTruth, ShadingIsNotBlur) {
  const made::Step step = made::Step::gaussian(0.3748);
  for (const double cnr : {20.0, 60.0, 200.0}) {
    for (const double shading : {0.01, 0.03, 0.1, 0.3, 0.5}) {
      SCOPED_TRACE(std::to_string(cnr) + ", " + std::to_string(shading));
      made::Scene scene = scene_at(5.0);
      scene.noise_sd = 0.6 / cnr;
      mtf::Image image = made::make(step, scene);
      for (std::int64_t j = 0; j < image.height(); ++j)
        for (std::int64_t i = 0; i < image.width(); ++i)
          image.at(i, j) *= static_cast<float>(1.0 - shading * std::pow((static_cast<double>(i) - 64.0) / 64.0, 2));
      const EdgeMeasurement found = measure(image);
      ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
      EXPECT_NEAR(found.mtf50->value, 0.3748, 5.0 * found.mtf50->sd);
      EXPECT_NEAR(std::abs(found.angle_deg.value), 5.0, 0.2);
      EXPECT_GT(found.mtf50->sd, 1e-4);
      EXPECT_TRUE(shading < 0.02 || cnr < 60.0 || !found.warnings.empty());
    }
  }
}

// A Gaussian of sigma s behind a low-pass, an exponential of the length t, in closed form: relative edge response and
// overshoot count from where the edge is half way up, which here is not where its phase is least.
TEST(MeasureTruth, EdgeFiguresOfATailOnOneSide) {
  constexpr double s = 0.7, t = 1.6;
  const auto phi = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  const auto esf = [&](double d) { return phi(d / s) - std::exp(0.5 * s * s / (t * t) - d / t) * phi(d / s - s / t); };
  const made::Step step = made::Step::closed(esf, [](double f) {
    return std::exp(-2.0 * std::pow(std::numbers::pi * s * f, 2)) / std::hypot(1.0, 2.0 * std::numbers::pi * t * f);
  });
  double dark = -5.0, bright = 5.0;
  for (int i = 0; i < 60; ++i) (esf(0.5 * (dark + bright)) < 0.5 ? dark : bright) = 0.5 * (dark + bright);
  made::Scene scene = scene_at(5.0);
  scene.noise_sd = 0.002;
  for (scene.seed = 1; scene.seed <= 8; ++scene.seed) {
    const EdgeMeasurement found = measure(made::make(step, scene));
    ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
    EXPECT_NEAR(found.rer->value, esf(dark + 0.5) - esf(dark - 0.5), 4.0 * found.rer->sd);
    EXPECT_LT(found.rer->sd, 2e-3);
    EXPECT_NEAR(found.overshoot->value, esf(dark + 3.0) - 1.0, 4.0 * found.overshoot->sd);
    EXPECT_LT(found.overshoot->sd, 4e-3);
  }
}

TEST(MeasureTruth, FiguresOfAGaussian) {
  const double mtf50 = 0.25, sigma_px = std::sqrt(0.5 * std::numbers::ln2) / (std::numbers::pi * mtf50);
  const made::Step step = made::Step::gaussian(mtf50);
  const EdgeMeasurement found = measure(made::make(step, scene_at(10.0)));
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  EXPECT_NEAR(found.mtf10->value, mtf50 * std::sqrt(std::log2(10.0)), 1e-4);
  EXPECT_NEAR(found.mtf30->value, mtf50 * std::sqrt(std::log2(10.0 / 3.0)), 1e-4);
  EXPECT_NEAR(found.nyquist->value, std::exp2(-4.0), 1e-4);
  EXPECT_NEAR(found.rer->value, std::erf(0.5 / (sigma_px * std::numbers::sqrt2)), 1e-4);
  EXPECT_NEAR(found.fwhm_px->value, sigma_px * std::sqrt(8.0 * std::numbers::ln2), 2e-3);
  EXPECT_NEAR(found.sampling_efficiency->value, 2.0 * found.mtf10->value, 1e-12);
  double area = 0.0;
  for (int i = 0; i < 1000; ++i) area += step.mtf((i + 0.5) * 5e-4) * 5e-4;
  EXPECT_NEAR(found.mtfa->value, 2.0 * area, 1e-4);
  EXPECT_NEAR(found.overshoot->value, 0.0, 2e-3);
  EXPECT_EQ(found.mtf.size(), static_cast<std::size_t>(calib::kCurveSamples));
  EXPECT_NEAR(found.mtf[0], 1.0, 1e-12);
  for (std::size_t i = 0; i < found.distance_px.size(); ++i)
    EXPECT_NEAR(found.esf[i], step.at(found.distance_px[i]), 1e-4) << found.distance_px[i];
}

// A lens with coma has a complex OTF: here a shift of a part of the light, as of a ghost two pixels away.
TEST(MeasureTruth, PhasesOfLopsidedBlurs) {
  const made::Step step = made::Step::gaussian(0.3);
  const made::Scene near = scene_at(5.0);
  made::Scene shifted = near;
  const double angle_rad = 5.0 * std::numbers::pi / 180.0;
  shifted.x = *near.x + 2.0 * std::cos(angle_rad);
  shifted.y = 50.0 + 2.0 * std::sin(angle_rad);
  mtf::Image image = made::make(step, near);
  const mtf::Image ghost = made::make(step, shifted);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = 0.8F * image.data()[i] + 0.2F * ghost.data()[i];
  const EdgeMeasurement found = measure(image);
  ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
  for (std::size_t i = 0; i <= 100; i += 5) {
    const double f = found.frequency_cy_px[i], turn = 4.0 * std::numbers::pi * f;
    const double truth = step.mtf(f) * std::hypot(0.8 + 0.2 * std::cos(turn), 0.2 * std::sin(turn));
    EXPECT_NEAR(found.mtf[i], truth, 2e-3) << f;
  }
}

// A Gaussian and a charge that decays, an RC stage or a phosphor: the line spread has a tail on one side only.
TEST(MeasureTruth, OneSidedTails) {
  struct Case {
    double sigma_px, tail_px, percent;
  };
  for (const Case& one : {Case{0.4, 0.3, 0.05}, Case{0.6, 0.6, 0.1}, Case{0.4, 1.5, 1.0}}) {
    SCOPED_TRACE(one.tail_px);
    const auto mtf = [&one](double f) {
      return std::exp(-2.0 * std::pow(std::numbers::pi * one.sigma_px * f, 2)) /
             std::hypot(1.0, 2.0 * std::numbers::pi * one.tail_px * f);
    };
    double low = 0.0, high = 2.0;
    for (int round = 0; round < 60; ++round) {
      const double middle = 0.5 * (low + high);
      (mtf(middle) > 0.5 ? low : high) = middle;
    }
    const auto phi = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
    const made::Scene scene = scene_at(5.0);
    for (const double noise_sd : {0.0, 6e-4, 1e-2}) {
      std::mt19937_64 bits(5);
      std::normal_distribution<double> normal;
      mtf::Image image(scene.width, scene.height);
      for (std::int64_t j = 0; j < image.height(); ++j) {
        for (std::int64_t i = 0; i < image.width(); ++i) {
          const double d = made::distance(scene, static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5);
          const double z = d / one.sigma_px, k = one.sigma_px / one.tail_px;
          const double tail = z - k < -30.0 ? 0.0 : std::exp(0.5 * k * k - d / one.tail_px) * phi(z - k);
          image.at(i, j) = static_cast<float>(0.2 + 0.6 * (phi(z) - tail) + noise_sd * normal(bits));
        }
      }
      const EdgeMeasurement found = measure(image);
      ASSERT_EQ(found.trouble, Trouble::none) << found.reason;
      const double bar = noise_sd > 0.0 ? 5.0 * found.mtf50->sd : 0.01 * one.percent * high;
      EXPECT_NEAR(found.mtf50->value, high, bar);
      for (std::size_t i = 0; i <= 100; ++i)
        EXPECT_NEAR(found.mtf[i], mtf(found.frequency_cy_px[i]), noise_sd > 0.0 ? 0.05 : 0.015);
    }
  }
}
