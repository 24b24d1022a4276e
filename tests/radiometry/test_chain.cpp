// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/light/blackbody.h"
#include "radiometry/stages/noise/noise_3d.h"
#include "tests/expect_error.h"
#include "tests/radiometry/chain_cases.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::kMostSigmas;
using test::make_chain;
using test::mwir_sensor;
using test::mwir_system;
using test::noisy_sensor;
using test::samples;

double radiance_of(double temperature_k) { return band_radiance(Flux::photons, 3.0, 5.0, temperature_k); }

double sum_of(const mtf::Image& image) {
  double sum = 0.0;
  for (const float v : samples(image)) sum += static_cast<double>(v);
  return sum;
}

TEST(Chain, AFlatSceneGivesTheElectronsOfTheBudget) {
  Sensor sensor = mwir_sensor();
  sensor.settings.detector->dark_e_s = 5e6;
  sensor.settings.optics->emissivity = 0.1;
  sensor.settings.optics->temperature_k = 290.0;
  sensor.settings.optics->stop_temperature_k = 120.0;
  const Chain chain = make_chain(mwir_system(), sensor, 96, 64, 7.5);
  for (const double t : {200.0, 300.0, 340.0}) {
    const ChainFrame frame = chain.run(flat(96, 64, static_cast<float>(radiance_of(t))), 0, OutputStage::electrons);
    const double expected = budget_of(mwir_system(), sensor, t).signal.total_e();
    ASSERT_EQ(frame.image.width(), 48);
    for (const float v : samples(frame.image)) EXPECT_NEAR(v / expected, 1.0, 1e-6) << t;
  }
}

// Row, column and pixel noise of many frames against the root sum of squares of the budget: the variance of one pixel
// over the frames, its mean over pixels. 400 frames of 24 x 24; the line noise is shared by a row or column, so the
// estimate has few degrees of freedom of it; its share is small.
TEST(Chain, AFlatSceneHasTheVarianceOfTheBudget) {
  Sensor sensor = noisy_sensor();
  sensor.settings.noise->row_e = sensor.settings.noise->column_e = 0.0;
  const Chain chain = make_chain(mwir_system(), sensor, 24, 24, 15.0);
  const Budget<double> budget = budget_of(mwir_system(), sensor, 300.0);
  const auto radiance = static_cast<float>(radiance_of(300.0));
  constexpr int frames = 400;
  std::vector<double> sum(24 * 24), squares(24 * 24);
  for (int n = 0; n < frames; ++n) {
    const ChainFrame frame = chain.run(flat(24, 24, radiance), static_cast<std::uint32_t>(n), OutputStage::dn);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double electrons = (static_cast<double>(frame.image.data()[i]) - 100.0) * 450.0;
      sum[i] += electrons;
      squares[i] += electrons * electrons;
    }
  }
  double chi2 = 0.0, spatial = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    chi2 += (squares[i] - sum[i] * sum[i] / frames) / (budget.temporal_e * budget.temporal_e);
    mean += sum[i] / frames / static_cast<double>(sum.size());
  }
  for (const double s : sum) spatial += std::pow(s / frames - mean, 2) / static_cast<double>(sum.size() - 1);
  const double dof = (frames - 1.0) * static_cast<double>(sum.size());
  EXPECT_LT(std::abs(chi2 / dof - 1.0), kMostSigmas * std::sqrt(2.0 / dof));
  // The temporal noise that is left in a mean of frames is known; 575 pixels.
  const double expected = std::pow(budget.spatial_e, 2) + std::pow(budget.temporal_e, 2) / frames;
  EXPECT_LT(std::abs(spatial / expected - 1.0), kMostSigmas * std::sqrt(2.0 / 575.0));
  EXPECT_LT(std::abs(mean - budget.signal.total_e()), kMostSigmas * std::sqrt(expected / 576.0));
}

// What lies beyond a constant border goes through the same stages as the image, so that a filter of the electronics
// leaves a uniform image uniform.
TEST(Chain, AUniformSceneWithABorderOfItsValueStaysUniform) {
  mtf::System<double> system = mwir_system();
  system.add(mtf::Stage::readout, mtf::test::gaussian(20.0));
  Sensor glare = mwir_sensor();
  glare.settings.glare = VeilingGlare{.fraction = 0.1, .offset = 0.05};
  Sensor bent = mwir_sensor();
  bent.settings.detector->full_well_e = 7.0e6;
  bent.settings.nonlinearity = Nonlinearity{.a2 = -0.1};
  for (const Sensor& sensor : {mwir_sensor(), glare, bent}) {
    const Chain chain = make_chain(system, sensor, 48, 48, 15.0, {}, mtf::Border::constant, 1e-6);
    const double radiance = 4e6 / chain.electrons_per_radiance();
    for (const double times : {1.0, 2.0}) {  // the second fills the well of the last sensor
      const ChainFrame frame =
          chain.run(flat(48, 48, static_cast<float>(times * radiance)), 0, OutputStage::electrons, times * radiance);
      EXPECT_NEAR(frame.image.at(0, 0) / frame.image.at(24, 24), 1.0, 2e-5) << times;
      EXPECT_NEAR(frame.image.at(47, 20) / frame.image.at(24, 24), 1.0, 2e-5) << times;
    }
  }
}

// All pixels are active and a scene sample's light falls on them whole: the sum over pixels is the source times the
// electrons per radiance times the part of a pixel that a sample is.
TEST(Chain, KeepsTheEnergyOfAnIsolatedSource) {
  for (const mtf::Border border : {mtf::Border::reflect, mtf::Border::periodic})
    for (const int ratio : {1, 2, 4}) {
      const std::int64_t side = 48 * ratio;
      const Chain chain = make_chain(mwir_system(), mwir_sensor(), side, side, 15.0 / ratio, {}, border, 1e-5);
      mtf::Image scene = flat(side, side, 0.0F);
      scene.at(side / 2 + 1, side / 3) = 1e20F;
      const double expected = chain.electrons_per_radiance() * 1e20 / (ratio * ratio);
      const ChainFrame frame = chain.run(std::move(scene), 0, OutputStage::electrons);
      EXPECT_NEAR(sum_of(frame.image) / expected, 1.0, 1e-5) << ratio;
    }
}

// Pixels that are filled in part miss some of the light, or count some of it twice: what the sampling folds to zero
// frequency, the sum of H(m/p) over all m with the phase of the source's place in its pixel.
TEST(Chain, KeepsTheEnergyThatFillFactorAndFoldingLeave) {
  mtf::System<double> system = mwir_system();
  system.list(mtf::Stage::presample).clear();
  system.add(mtf::Stage::presample, mtf::Component<double>::make("diffraction"));
  system.add(mtf::Stage::presample, mtf::test::footprint(10.0));
  constexpr std::int64_t ratio = 4, side = 48 * ratio;
  const Chain chain = make_chain(system, mwir_sensor(), side, side, 15.0 / ratio, {}, mtf::Border::periodic, 1e-6);
  for (const std::int64_t at : {90, 91, 92, 93}) {
    mtf::Image scene = flat(side, side, 0.0F);
    scene.at(at, 60) = 1e20F;
    const auto folds = [&](std::int64_t sample) {
      return std::array{-1.0, 0.0, 1.0, 0.5 - (static_cast<double>(sample) + 0.5) / ratio};  // m, and the phase
    };
    const auto fx = folds(at), fy = folds(60);
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const mtf::Freq<double> f{fx[i] * 1e3 / 15.0, fy[k] * 1e3 / 15.0};
        sum += system.otf(f).re * std::cos(2.0 * mtf::kPi * (fx[i] * fx[3] + fy[k] * fy[3]));
      }
    const double expected = chain.electrons_per_radiance() * 1e20 / (ratio * ratio) * sum;
    EXPECT_GT(std::abs(sum - 1.0), 0.003);
    EXPECT_NEAR(sum_of(chain.run(std::move(scene), 0, OutputStage::electrons).image) / expected, 1.0, 1e-5) << at;
  }
}

TEST(Chain, TapsAreWhatTheySay) {
  const Sensor sensor = noisy_sensor();
  const Chain chain = make_chain(mwir_system(), sensor, 32, 32, 15.0);
  const double radiance = radiance_of(300.0);
  const auto at = [&](OutputStage stage) { return chain.run(flat(32, 32, static_cast<float>(radiance)), 3, stage); };
  EXPECT_NEAR(at(OutputStage::radiance).image.at(5, 5) / radiance, 1.0, 1e-6);
  const double cone = 3.14159265358979 / (1.0 + 4.0 * 2.5 * 2.5) * 0.85;
  EXPECT_NEAR(at(OutputStage::irradiance).image.at(5, 5) / (radiance * cone), 1.0, 1e-6);
  const mtf::Image electrons = at(OutputStage::electrons).image, counts = at(OutputStage::dn).image;
  for (std::int64_t i = 0; i < counts.size(); ++i)
    EXPECT_EQ(counts.data()[i], std::floor(electrons.data()[i] / 450.0F + 100.0F + 0.5F));
  EXPECT_EQ(last_output_stage(mwir_system(), sensor), OutputStage::dn);
  EXPECT_EQ(output_unit(sensor, OutputStage::dn), "counts");
  expect_refused({"display", "dn"}, [&] { at(OutputStage::display); });
}

TEST(Chain, SameBitsForAnyThreadsAndSameNoiseForAnyRegion) {
  mtf::System<double> system = mwir_system();
  const Sensor sensor = noisy_sensor();
  const Chain chain = make_chain(system, sensor, 150, 70, 15.0);
  const auto radiance = static_cast<float>(radiance_of(300.0));
  const mtf::Image one = chain.run(flat(150, 70, radiance), 5, OutputStage::dn, 0.0, 1).image;
  const mtf::Image two = chain.run(flat(150, 70, radiance), 5, OutputStage::dn, 0.0, 2).image;
  EXPECT_TRUE(std::equal(one.data(), one.data() + one.size(), two.data()));
  const Chain part = make_chain(system, sensor, 40, 30, 15.0, {37, 21});
  const mtf::Image region = part.run(flat(40, 30, radiance), 5, OutputStage::dn).image;
  for (std::int64_t y = 0; y < 30; ++y)
    for (std::int64_t x = 0; x < 40; ++x) ASSERT_EQ(region.at(x, y), one.at(x + 37, y + 21));
  const mtf::Image next = chain.run(flat(150, 70, radiance), 6, OutputStage::dn).image;
  EXPECT_FALSE(std::equal(one.data(), one.data() + one.size(), next.data()));
}

// Readout filters shape the signal and its shot noise, not the read noise, which comes after them.
TEST(Chain, ReadoutFiltersShotNoiseButNotReadNoise) {
  mtf::System<double> system = mwir_system();
  auto crosstalk = mtf::Component<double>::make("crosstalk");
  mtf::test::set(crosstalk, "side", 0.05);
  system.add(mtf::Stage::readout, crosstalk);
  const auto variance = [&](double read_e, bool shot) {
    Sensor sensor = mwir_sensor();
    sensor.settings.noise = NoiseSettings{.seed = 3, .shot = shot};
    sensor.settings.detector->read_e = read_e;
    const Chain chain = make_chain(system, sensor, 128, 128, 15.0, {}, mtf::Border::periodic);
    const mtf::Image image = chain.run(flat(128, 128, 1e19F), 0, OutputStage::electrons).image;
    return test::moments(samples(image)).variance;
  };
  const double electrons = make_chain(system, mwir_sensor(), 16, 16, 15.0).electrons_per_radiance() * 1e19;
  // 0.8 at the centre and 0.05 on four sides, less the cross terms of none: the sum of squared taps.
  const double taps = 0.8 * 0.8 + 4 * 0.05 * 0.05, relative = kMostSigmas * std::sqrt(2.0 / (128.0 * 128.0));
  EXPECT_NEAR(variance(0.0, true) / (taps * electrons), 1.0, 1.5 * relative);
  EXPECT_NEAR(variance(500.0, false) / 250000.0, 1.0, relative);
}

TEST(Chain, The3dNoiseThatIsPutInIsMeasured) {
  Sensor sensor = mwir_sensor();
  const Noise3d put{.t = 5.0, .v = 20.0, .h = 25.0, .tv = 15.0, .th = 18.0, .vh = 40.0, .tvh = 60.0};
  sensor.settings.noise = NoiseSettings{.seed = 4, .shot = false};
  sensor.settings.noise_3d = put;
  const Chain chain = make_chain(mwir_system(), sensor, 160, 120, 15.0);
  Noise3dEstimator estimator(160, 120);
  for (std::uint32_t n = 0; n < 60; ++n)
    estimator.add(chain.run(flat(160, 120, 1e18F), n, OutputStage::electrons).image.view());
  const Noise3d found = estimator.estimate();
  EXPECT_NEAR(found.tvh, put.tvh, 0.1);
  EXPECT_NEAR(found.vh, put.vh, 0.01 * put.vh);
  EXPECT_NEAR(found.tv, put.tv, 0.03 * put.tv);
  EXPECT_NEAR(found.th, put.th, 0.03 * put.th);
}

// Two flat scenes 1 K apart: the noise over the step of the mean is the NETD of the budget.
TEST(Chain, TheNetdThatIsMeasuredIsThatOfTheBudget) {
  Sensor sensor = noisy_sensor();
  sensor.settings.nonuniformity.reset();
  sensor.settings.noise->row_e = sensor.settings.noise->column_e = 0.0;
  const Chain chain = make_chain(mwir_system(), sensor, 256, 256, 15.0);
  const auto moments_at = [&](double t) {
    const mtf::Image image = chain.run(flat(256, 256, static_cast<float>(radiance_of(t))), 1, OutputStage::dn).image;
    return test::moments(samples(image));
  };
  const test::Moments low = moments_at(299.5), high = moments_at(300.5);
  const double netd = std::sqrt(0.5 * (low.variance + high.variance)) / (high.mean - low.mean);
  const double expected = budget_of(mwir_system(), sensor, 300.0).netd_k;
  // sd of a standard deviation of 2 x 65536 pixels: 0.2 %; of the step, same random numbers in both: less.
  EXPECT_NEAR(netd / expected, 1.0, kMostSigmas * 0.002 + 1e-3);
}

TEST(Chain, ExtremesAreFiniteMonotoneAndSaturate) {
  for (const double well : {1.0, 1e4, 1e12})
    for (const int bits : {1, 8, 32})
      for (const double seconds : {1e-9, 1e-2, 1e3}) {
        mtf::System<double> system = mwir_system();
        system.frame.integration_time_s = seconds;
        Sensor sensor = mwir_sensor();
        sensor.settings.noise = NoiseSettings{.seed = 1};
        sensor.settings.detector->full_well_e = well;
        sensor.settings.adc = AdcSettings{.bits = bits};
        const Chain chain = make_chain(system, sensor, 8, 8, 15.0);
        float before = -1.0F;
        for (const double radiance : {0.0, 1e7, 1e19, radiance_of(300.0), radiance_of(6000.0), 1e31}) {
          const ChainFrame frame = chain.run(flat(8, 8, static_cast<float>(radiance)), 0, OutputStage::dn);
          const float v = frame.image.at(3, 3);
          EXPECT_TRUE(std::isfinite(v));
          EXPECT_GE(v, before);
          before = v;
        }
        if (chain.electrons_per_radiance() * 1e31 > 2.0 * well) {
          EXPECT_EQ(before, static_cast<float>(std::ldexp(1.0, bits) - 1.0));
        }
      }
}

TEST(Chain, TheConverterRoundsAsItsTableSays) {
  Sensor sensor = mwir_sensor();
  sensor.settings.adc = AdcSettings{.bits = 14, .electrons_per_count = 450.0, .rounding = Rounding::down};
  const auto counts = [&] {
    return make_chain(mwir_system(), sensor, 16, 16, 15.0).run(flat(16, 16, 1e19F), 0, OutputStage::dn).image.at(3, 3);
  };
  const double exact = make_chain(mwir_system(), sensor, 16, 16, 15.0).electrons_per_radiance() * 1e19 / 450.0;
  EXPECT_EQ(counts(), static_cast<float>(std::floor(exact)));
  sensor.settings.adc->rounding = Rounding::nearest;
  EXPECT_EQ(counts(), static_cast<float>(std::floor(exact + 0.5)));
  // A converter that is filled by the well keeps room for its offset.
  sensor.settings.adc = AdcSettings{.bits = 12, .offset_counts = 200.0};
  EXPECT_NEAR(adc_of(sensor).electrons_per_count * (4095.0 - 200.0), 7e6, 1e-3);
}

mtf::Image waves(std::int64_t width, std::int64_t height, std::int64_t margin) {
  mtf::Image image(width + margin, height + margin);
  for (std::int64_t y = 0; y < image.height(); ++y)
    for (std::int64_t x = 0; x < image.width(); ++x)
      image.at(x, y) = static_cast<float>(
          1e19 * (2.0 + std::sin(0.21 * static_cast<double>(x)) * std::cos(0.17 * static_cast<double>(y))));
  return image;
}

// The pixels stay as they are: every n-th sample of a microscanned image is the image without it. The footprint is
// given as a fill factor, which is one of the pitch.
TEST(Chain, MicroscanSamplesBetweenTheSamePixels) {
  mtf::System<double> system = mwir_system();
  auto footprint = mtf::Component<double>::make("footprint");
  mtf::test::set(footprint, "fill_factor", 1.0);
  system.list(mtf::Stage::presample).pop_back();
  system.list(mtf::Stage::presample).back() = {footprint, "footprint"};
  const auto image = [&](bool scan) {
    Sensor sensor = mwir_sensor();
    if (scan) sensor.settings.microscan = Microscan{.steps = 2};
    return make_chain(system, sensor, 128, 128, 3.75, {}, mtf::Border::reflect, 1e-5)
        .run(waves(128, 128, 0), 0, OutputStage::electrons)
        .image;
  };
  const mtf::Image coarse = image(false), fine = image(true);
  ASSERT_EQ(fine.width(), 64);
  ASSERT_EQ(coarse.width(), 32);
  // A coarse centre lies in the middle of the four fine ones around it, one scene sample away in x and y: their mean
  // has the waves reduced by the cosines of their phase there. Borders are bent.
  const double level = make_chain(system, mwir_sensor(), 16, 16, 3.75).electrons_per_radiance() * 2e19;
  for (std::int64_t y = 6; y < 26; ++y)
    for (std::int64_t x = 6; x < 26; ++x) {
      const double mean = 0.25 * (double{fine.at(2 * x, 2 * y)} + double{fine.at(2 * x + 1, 2 * y)} +
                                  double{fine.at(2 * x, 2 * y + 1)} + double{fine.at(2 * x + 1, 2 * y + 1)});
      const double expected = level + (double{coarse.at(x, y)} - level) * std::cos(0.21) * std::cos(0.17);
      EXPECT_NEAR(mean / expected, 1.0, 2e-4);
    }
}

TEST(Chain, LineNoiseAnd3dNoiseAreIndependent) {
  Sensor sensor = mwir_sensor();
  sensor.settings.noise = NoiseSettings{.seed = 9, .shot = false, .column_e = 100.0};
  sensor.settings.noise_3d = Noise3d{.th = 100.0};
  const Chain chain = make_chain(mwir_system(), sensor, 4096, 2, 15.0);
  const mtf::Image image = chain.run(flat(4096, 2, 1e18F), 0, OutputStage::electrons).image;
  const double variance = test::moments(samples(image).first(4096)).variance;
  EXPECT_NEAR(variance / 2e4, 1.0, kMostSigmas * std::sqrt(2.0 / 4096.0));
}

// Where the optical axis is follows from the detector, not from how much scene there is beyond it.
TEST(Chain, DistortionAndGhostDoNotDependOnAMarginOfTheScene) {
  mtf::System<double> system = mwir_system();
  system.frame.columns = system.frame.rows = 32;
  Sensor sensor = mwir_sensor();
  sensor.settings.distortion = Distortion{.k1 = 0.05};
  sensor.settings.ghost = Ghost{.fraction = 0.1};
  const auto image = [&](std::int64_t margin) {
    return make_chain(system, sensor, 64 + margin, 64 + margin, 7.5)
        .run(waves(64, 64, margin), 0, OutputStage::electrons)
        .image;
  };
  const mtf::Image tight = image(0), loose = image(32);
  ASSERT_EQ(loose.width(), 32);
  for (std::int64_t y = 8; y < 24; ++y)
    for (std::int64_t x = 8; x < 24; ++x) EXPECT_NEAR(loose.at(x, y) / tight.at(x, y), 1.0, 1e-3);
}

TEST(Chain, TwoPointCorrectionTakesTheFixedPatternOut) {
  Sensor sensor = noisy_sensor();
  sensor.settings.noise = NoiseSettings{.seed = 3};
  sensor.settings.nonuniformity->prnu = 0.02;
  const auto scatter = [&] {
    const Chain chain = make_chain(mwir_system(), sensor, 64, 64, 15.0);
    return std::sqrt(
        test::moments(samples(chain.run(flat(64, 64, 1e20F), 0, last_output_stage(mwir_system(), sensor)).image))
            .variance);
  };
  const double before = scatter();
  sensor.settings.correction = CorrectionSettings{.frames = 32};
  const double after = scatter(),
               electrons = make_chain(mwir_system(), sensor, 8, 8, 15.0).electrons_per_radiance() * 1e20;
  const double noise = std::hypot(std::sqrt(electrons + 1e4), 600.0) / 450.0;
  EXPECT_GT(before, 5.0 * noise);
  EXPECT_LT(after, 1.15 * noise);
  sensor.settings.adc->electrons_per_count = 100.0;  // 0.8 of full well does not fit into 14 bits
  expect_refused({"[correction]", "0.8", "converter"}, scatter);
}

TEST(Chain, LagTakesFramesThatAreLeftOutAsTime) {
  Sensor sensor = mwir_sensor();
  sensor.settings.lag = Lag{.time_constant_s = 4e-3};  // two frame times
  const Chain chain = make_chain(mwir_system(), sensor, 8, 8, 15.0);
  ChainState state;
  const auto level = [&](std::uint32_t number, float radiance) {
    return chain.run(flat(8, 8, radiance), number, OutputStage::electrons, 0.0, 1, &state).image.at(2, 2) /
           static_cast<float>(chain.electrons_per_radiance() * 1e19);
  };
  EXPECT_NEAR(level(10, 1e19F), 1.0, 1e-6);
  EXPECT_NEAR(level(13, 2e19F), 2.0 - std::exp(-1.5), 1e-6);
}

TEST(Chain, SaysWhatIsMissing) {
  const auto build = [](const mtf::System<double>& system, const Sensor& sensor) {
    return [=] { make_chain(system, sensor, 16, 16, 15.0); };
  };
  Sensor sensor = mwir_sensor();
  sensor.settings.detector.reset();
  expect_refused({"[detector]"}, build(mwir_system(), sensor));
  mtf::System<double> system = mwir_system();
  system.frame.integration_time_s = 0.0;
  expect_refused({"integration_time"}, build(system, mwir_sensor()));
  sensor = mwir_sensor();
  sensor.settings.detector->full_well_e = mtf::kInfinity;
  sensor.settings.adc = AdcSettings{};
  expect_refused({"electrons_per_count", "full_well"}, build(mwir_system(), sensor));
  sensor = mwir_sensor();
  sensor.settings.nonuniformity = NonuniformitySettings{.responsivity = "map.exr"};
  sensor.responsivity = std::make_shared<const mtf::Image>(flat(15, 16, 1.0F));
  expect_refused({"responsivity", "15x16", "16x16"}, build(mwir_system(), sensor));
}

}  // namespace
}  // namespace radiometry
