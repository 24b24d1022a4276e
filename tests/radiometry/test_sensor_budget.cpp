// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain/sensor_budget.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mtf/math/quadrature.h"
#include "tests/expect_error.h"
#include "tests/radiometry/chain_cases.h"
#include "tests/radiometry/flat_scenes.h"

namespace radiometry {
namespace {

using test::flat_scenes;
using test::make_chain;
using test::mwir_system;
using test::noisy_sensor;

/// A camera that emits, with air in front of it and every kind of noise; 3.4 to 4.8 um.
Sensor warm_sensor() {
  Sensor sensor = noisy_sensor();
  sensor.curves.band = {3.4, 4.8};
  sensor.curves.optics = {make_spectrum("lens", {3.0, 4.0, 5.0}, {0.9, 0.95, 0.8}, 1.0)};
  sensor.curves.cold_filter = {make_spectrum("filter", {3.3, 3.6, 4.6, 4.9}, {0.0, 0.9, 0.9, 0.0}, 1.0)};
  sensor.settings.optics = OpticsSettings{
      .transmission = {.file = "lens"}, .emissivity = 0.1, .temperature_k = 293.0, .stop_temperature_k = 220.0};
  sensor.settings.scene = SceneSettings{.surroundings_k = 280.0};
  sensor.emissivity = constant_spectrum("paint", 0.95, 1.0);
  sensor.path = absorbing_path(constant_spectrum("air", 0.8, 1.0), 285.0);
  sensor.settings.narcissus = Narcissus{.depth = 0.3};
  return sensor;
}

Sensor with_efficiency(Sensor sensor, const Spectrum& curve) {
  sensor.settings.detector->quantum_efficiency = {.file = curve.source};
  sensor.curves.quantum_efficiency = {curve};
  return sensor;
}

std::vector<BudgetRow> all_rows(const Sensor& sensor, double temperature_k) {
  const mtf::System<double> system = mwir_system();
  const Budget<double> budget = budget_of(system, sensor, temperature_k);
  std::vector<BudgetRow> list = rows(budget);
  list.push_back(dstar_row(system, sensor, budget));
  return list;
}

TEST(SensorBudget, a_frame_is_no_shorter_than_its_integration) {
  Sensor sensor = noisy_sensor();
  const mtf::System<double> system = mwir_system();
  sensor.settings.frame = FrameSettings{.frame_time_s = system.frame.integration_time_s};
  EXPECT_GT(budget_of(system, sensor, 300.0).netd_k, 0.0);
  sensor.settings.frame->frame_time_s = 0.99 * system.frame.integration_time_s;
  expect_says(message_of<mtf::UsageError>([&] { budget_of(system, sensor, 300.0); }),
              {"frame.frame_time", "frame.integration_time"});
}

TEST(SensorBudget, a_flat_curve_is_its_number_in_every_row) {
  Sensor number = warm_sensor();
  number.settings.detector->quantum_efficiency = {0.7};
  const Spectrum wide = make_spectrum("wide", {1.0, 4.1, 12.0}, {0.7, 0.7, 0.7}, 1.0),
                 narrow = make_spectrum("narrow", {3.4, 4.8}, {0.7, 0.7}, 1.0);
  for (const bool corrected : {false, true})
    for (const double temperature_k : {288.0, 300.0, 320.0})
      for (const Spectrum& curve : {wide, narrow, constant_spectrum("constant", 0.7, 1.0)}) {
        if (corrected) number.settings.correction = CorrectionSettings{};
        const auto expected = all_rows(number, temperature_k),
                   rows = all_rows(with_efficiency(number, curve), temperature_k);
        ASSERT_EQ(rows.size(), expected.size());
        for (std::size_t i = 0; i < rows.size(); ++i)  // both are sums of some hundred terms in another order
          EXPECT_NEAR(rows[i].value, expected[i].value, 1e-13 * std::abs(expected[i].value))
              << rows[i].name << " at " << temperature_k << " K, " << curve.source;
      }
}

// NEI by its meaning: photons of the scene's spectrum, so many that their electrons equal the noise.
TEST(SensorBudget, nei_is_the_irradiance_of_the_scene_over_its_snr) {
  const Sensor sensor = with_efficiency(warm_sensor(), make_spectrum("qe", {1.0, 3.4, 4.6, 5.2}, {0.3, 0.9, 0.5, 0.0}));
  const Budget<double> budget = budget_of(mwir_system(), sensor, 300.0);
  const mtf::GaussRule& rule = mtf::gauss_legendre(200);
  double photons = 0.0;  // at the detector, before its quantum efficiency
  for (const auto& [lo, hi] : {std::pair{3.4, 3.6}, {3.6, 4.0}, {4.0, 4.6}, {4.6, 4.8}})
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double w = 0.5 * (lo + hi + (hi - lo) * rule.node[i]);
      const double surface = 0.95 * planck(Flux::photons, w, 300.0) + 0.05 * planck(Flux::photons, w, 280.0);
      photons += 0.5 * (hi - lo) * rule.weight[i] * 0.8 * evaluate(sensor.curves.optics[0], w) *
                 evaluate(sensor.curves.cold_filter[0], w) * surface;
    }
  const double irradiance_ph = photons * mtf::kPi / (1.0 + 4.0 * 2.5 * 2.5);
  EXPECT_NEAR(budget.nei_ph * budget.snr / irradiance_ph, 1.0, 1e-12);
}

// Where the scene sends no photon, the NEI of a quantum-efficiency curve has no value.
TEST(SensorBudget, without_light_a_curve_has_no_nei) {
  Sensor sensor = with_efficiency(warm_sensor(), make_spectrum("qe", {3.0, 5.0}, {0.6, 0.8}));
  sensor.settings.scene.reset();
  EXPECT_TRUE(std::isnan(budget_of(mwir_system(), sensor, 0.0).nei_ph));
  EXPECT_TRUE(std::isfinite(budget_of(mwir_system(), sensor, 0.0).temporal_e));
}

// The chain and the budget take the same cone, the same stop and the same emission.
TEST(SensorBudget, a_flat_scene_comes_out_as_the_budget_says_for_either_cone_and_stop) {
  Sensor sensor = with_efficiency(warm_sensor(), make_spectrum("qe", {2.0, 3.4, 4.6, 5.2}, {0.3, 0.9, 0.5, 0.0}));
  sensor.settings.narcissus.reset();
  sensor.settings.noise.reset();
  sensor.settings.nonuniformity.reset();
  sensor.settings.adc.reset();
  std::vector<double> totals;
  for (const Cone cone : {Cone::tangent, Cone::sine})
    for (const StopBand stop_band : {StopBand::band, StopBand::response}) {
      sensor.settings.optics->cone = cone;
      sensor.settings.optics->stop_band = stop_band;
      const Budget<double> budget = budget_of(mwir_system(), sensor, 300.0);
      const SpectralNumbers<double> spectral = spectral_numbers(sensor, sensor.path, 300.0);
      const Chain chain = make_chain(mwir_system(), sensor, 16, 16, 15.0);
      const auto light = static_cast<float>(spectral.radiances.scene + spectral.radiances.path);
      const mtf::Image image = chain.run(test::flat(16, 16, light), 0, OutputStage::electrons).image;
      EXPECT_NEAR(image.at(5, 5) / budget.signal.total_e(), 1.0, 3e-7);  // floats
      totals.push_back(budget.signal.total_e());
    }
  EXPECT_GT(totals[1], 1.001 * totals[0]);
  EXPECT_GT(totals[2], 1.001 * totals[0]);
}

// What the correction of the simulated camera leaves against the closed form, between the signals of the flat frames,
// below and beyond them. 16384 pixels: the rms is known to 1/sqrt(2 x 16384) = 0.6 %, and 40 frames' noise adds to
// that.
TEST(SensorBudget, spatial_noise_is_what_the_corrected_chain_leaves) {
  Sensor sensor = noisy_sensor();
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 0.01, .dsnu_e = 2000.0};
  sensor.settings.noise = NoiseSettings{.seed = 3, .fixed_row_e = 800.0};
  sensor.settings.correction = CorrectionSettings{.low = 0.2, .high = 0.6, .frames = 16, .replace_bad = false};
  for (const double temperature_k : {270.0, 305.0, 320.0}) {
    const Budget<double> budget = budget_of(mwir_system(), sensor, temperature_k);
    EXPECT_EQ(budget.prnu_e, 0.0);
    EXPECT_EQ(budget.dsnu_e, 0.0);
    EXPECT_EQ(budget.spatial_e, budget.correction_e);
    EXPECT_NEAR(flat_scenes(sensor, temperature_k).pattern_e / budget.spatial_e, 1.0, 0.03) << temperature_k;
  }
}

// 1/f noise that goes on from frame to frame: in one frame it counts whole, and the means of flat frames keep more of
// it than one over their number. Frames far apart share what these means have left; 16384 pixels know that to 1.5 %.
TEST(SensorBudget, slow_noise_counts_in_frames_and_outlasts_the_flat_ones) {
  Sensor sensor = noisy_sensor();
  sensor.settings.nonuniformity.reset();
  sensor.settings.noise = NoiseSettings{.seed = 4};
  sensor.settings.frame_flicker = FlickerOctaves{.octave_e = 2e4, .lowest_cy_frame = 1e-3};
  const SpectralNumbers<double> spectral = spectral_numbers(sensor, sensor.path, 305.0);
  const auto light = static_cast<float>(spectral.radiances.scene + spectral.radiances.path);
  const auto frame = [&](std::uint32_t number, OutputStage stage) {
    return make_chain(mwir_system(), sensor, 128, 128, 15.0).run(test::flat(128, 128, light), number, stage).image;
  };
  const auto shared_e = [](const mtf::Image& a, const mtf::Image& b) {
    double products = 0.0, of_a = 0.0, of_b = 0.0;
    for (std::int64_t i = 0; i < a.size(); ++i) {
      const auto x = static_cast<double>(a.data()[i]), y = static_cast<double>(b.data()[i]);
      products += x * y, of_a += x, of_b += y;
    }
    const auto n = static_cast<double>(a.size());
    return 450.0 * std::sqrt(products / n - of_a / n * (of_b / n));
  };
  const mtf::Image one = frame(0, OutputStage::dn);
  EXPECT_NEAR(shared_e(one, one) / budget_of(mwir_system(), sensor, 305.0).temporal_e, 1.0, 0.03);
  sensor.settings.correction = CorrectionSettings{.low = 0.2, .high = 0.6, .frames = 16, .replace_bad = false};
  const Budget<double> budget = budget_of(mwir_system(), sensor, 305.0);
  EXPECT_NEAR(
      shared_e(frame(1000000, OutputStage::display), frame(2000000, OutputStage::display)) / budget.correction_e, 1.0,
      0.06);
  EXPECT_GT(budget.correction_e, 2.0 * budget.temporal_e / std::sqrt(16.0));
  sensor.settings.microscan = Microscan{};
  expect_refused({"[frame_flicker]", "[microscan]"}, [&] { require_consistent(mwir_system(), sensor); });
}

// Rows and columns of a responsivity of their own: in the budget with the pixels', in frames as whole lines.
TEST(SensorBudget, prnu_of_rows_and_columns_counts_with_that_of_pixels) {
  Sensor sensor = noisy_sensor();
  const auto prnu_e = [&](const NonuniformitySettings& unequal) {
    sensor.settings.nonuniformity = unequal;
    return budget_of(mwir_system(), sensor, 300.0).prnu_e;
  };
  EXPECT_NEAR(prnu_e({.prnu = 0.006, .prnu_row = 0.003, .prnu_column = 0.002}) / prnu_e({.prnu = 0.007}), 1.0, 1e-12);
  prnu_e({.prnu_row = 0.02});
  sensor.settings.noise = NoiseSettings{.seed = 3, .shot = false};
  sensor.settings.detector->read_e = sensor.settings.detector->dark_e_s = 0.0;
  const Chain chain = make_chain(mwir_system(), sensor, 16, 16, 15.0);
  const mtf::Image image = chain.run(test::flat(16, 16, 1e20F), 0, OutputStage::electrons).image;
  EXPECT_GT(std::abs(image.at(3, 2) / image.at(3, 3) - 1.0F), 1e-4F);
  for (std::int64_t y = 0; y < 16; ++y) EXPECT_NEAR(image.at(3, y) / image.at(11, y), 1.0, 3e-7);
}

// The bow of the response turns PRNU into a pattern again; electrons at the output are those of the budget times the
// slope of the response. To first order in PRNU, here 1 %.
TEST(SensorBudget, prnu_after_correction_is_what_the_bow_of_the_response_makes_of_it) {
  Sensor sensor = noisy_sensor();
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 0.01, .dsnu_e = 300.0};
  sensor.settings.noise = NoiseSettings{.seed = 3};
  sensor.settings.correction = CorrectionSettings{.low = 0.1, .high = 0.8, .frames = 64, .replace_bad = false};
  sensor.settings.nonlinearity = Nonlinearity{.a2 = -0.12, .a3 = 0.03};
  for (const double temperature_k : {302.0, 310.0}) {
    const Budget<double> budget = budget_of(mwir_system(), sensor, temperature_k);
    EXPECT_GT(budget.prnu_e, 2.0 * budget.correction_e);
    const double u = budget.signal.total_e() / 7e6, slope = 1.0 - 2.0 * 0.12 * u + 3.0 * 0.03 * u * u;
    EXPECT_NEAR(flat_scenes(sensor, temperature_k).pattern_e / (slope * budget.spatial_e), 1.0, 0.03) << temperature_k;
  }
  // At the signals of the flat frames nothing is left of it.
  FlatFrames<double> flats{
      .low_e = 7e5, .high_e = 5.6e6, .dark_e = 1e4, .full_well_e = 7e6, .response = *sensor.settings.nonlinearity};
  for (const double charge_e : {flats.low_e, flats.high_e})
    EXPECT_NEAR(correction_residual(flats, charge_e).prnu, 0.0, 1e-9 * charge_e);
}

// Simulating such a camera is refused; its budget has no number there and says why.
TEST(SensorBudget, a_flat_frame_below_the_background_leaves_no_number) {
  Sensor sensor = warm_sensor();
  sensor.settings.correction = CorrectionSettings{.low = 0.001};
  const Budget<double> budget = budget_of(mwir_system(), sensor, 300.0);
  for (const double value :
       {budget.prnu_e, budget.dsnu_e, budget.correction_e, budget.spatial_e, budget.spatial_netd_k})
    EXPECT_TRUE(std::isnan(value));
  EXPECT_TRUE(std::isfinite(budget.netd_k));
  expect_says(spatial_gap(sensor.settings, budget), {"flat frame at 0.001"});
  sensor.settings.correction->low = 0.2;
  EXPECT_EQ(spatial_gap(sensor.settings, budget_of(mwir_system(), sensor, 300.0)), "");
}

}  // namespace
}  // namespace radiometry
