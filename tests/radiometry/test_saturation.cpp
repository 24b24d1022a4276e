// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/saturation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "radiometry/chain/sensor_numbers.h"
#include "radiometry/light/blackbody.h"
#include "tests/expect_error.h"
#include "tests/radiometry/chain_cases.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::kMostSigmas;
using test::make_chain;
using test::mwir_system;
using test::noisy_sensor;
using test::samples;

double radiance_of(double temperature_k) { return band_radiance(Flux::photons, 3.0, 5.0, temperature_k); }

/// The noisy sensor with a well of `fill` times the electrons of a surface at 300 K.
Sensor sensor_at_fill(double fill) {
  Sensor sensor = noisy_sensor();
  sensor.settings.noise->row_e = sensor.settings.noise->column_e = 0.0;
  sensor.settings.adc = AdcSettings{.bits = 14};
  const double total = budget_of(mwir_system(), sensor, 300.0).signal.total_e();
  sensor.settings.detector->full_well_e = total / fill;
  return sensor;
}

double value_of_row(const Budget<double>& budget, const std::string& name) {
  for (const BudgetRow& row : rows(budget))
    if (row.name == name) return row.value;
  ADD_FAILURE() << name;
  return 0.0;
}

// Upper tail of the normal distribution: Abramowitz and Stegun, table 26.1.
TEST(Saturation, TheShareHeldIsTheTailOfTheScatter) {
  for (const auto& [sigmas, tail] :
       {std::pair{1.0, 0.158655253931457}, {2.0, 0.0227501319481792}, {4.0, 3.16712418331199e-5}}) {
    const PixelScatter pixel{.mean_e = 1e5, .well_e = 300.0, .converter_e = 500.0};
    EXPECT_NEAR(saturation_of(pixel, {}, 1e5 + 300.0 * sigmas).held / tail, 1.0, 1e-12);
    EXPECT_NEAR(saturation_of(pixel, {.most_e = 1e5 + 500.0 * sigmas}, 2e5).held / tail, 1.0, 1e-12);
    EXPECT_NEAR(saturation_of(pixel, {.least_e = 1e5 - 500.0 * sigmas}, 2e5).held / tail, 1.0, 1e-12);
  }
  const PixelScatter exact{.mean_e = 1e5};
  EXPECT_TRUE(saturation_of(exact, {}, 1e5).saturated());
  EXPECT_EQ(saturation_of(exact, {}, 1.0000001e5).held, 0.0);
  EXPECT_EQ(saturation_of({}, {.least_e = 0.0}, 1e5).held, 0.0);  // no light: a little more light changes the value
  EXPECT_EQ(saturation_of(exact, {}, mtf::kInfinity).end, RangeEnd::none);
}

// A mean that meets an end is at it, whatever the last digits say; a note begins beside it.
TEST(Saturation, AMeanThatMeetsTheEndIsSaturated) {
  for (const double off : {0.0, 1e-15, 1e-7}) {
    const Saturation s = saturation_of({.mean_e = 1e7 * (1.0 - off), .well_e = 3200.0, .converter_e = 3300.0}, {}, 1e7);
    EXPECT_TRUE(s.saturated()) << off;
    EXPECT_EQ(words(s).find("saturated: 50 %"), 0U) << words(s);
  }
  const Saturation near = saturation_of({.mean_e = 1e7 - 320.0, .well_e = 3200.0, .converter_e = 3300.0}, {}, 1e7);
  EXPECT_FALSE(near.saturated());
  EXPECT_TRUE(words(near).starts_with("near saturation")) << words(near);
  expect_says(words(near), {"46 %"});
  const Budget<double> b = budget_of(mwir_system(), sensor_at_fill(1.0), 300.0);
  EXPECT_TRUE(std::isnan(b.netd_k));
}

// Moments of min(value, x) by a sum over 5 million points (numpy), good to 1e-10; at 0 sqrt(2 - 2 / pi).
TEST(Saturation, AnEndTakesSlopeAndNoiseAwayAsTheMomentsOfAHeldGaussian) {
  EXPECT_NEAR(held_scatter(0.0).sd / held_scatter(0.0).slope, std::sqrt(2.0 - 2.0 / M_PI), 1e-15);
  for (const auto& [x, sd, ratio] : {std::tuple{1.0, 0.86665322235, 1.03008098214},
                                     {2.0, 0.97989610202, 1.00270783763},
                                     {4.0, 0.99996987336, 1.00000154465}}) {
    EXPECT_NEAR(held_scatter(x).sd, sd, 1e-10);
    EXPECT_NEAR(held_scatter(x).sd / held_scatter(x).slope, ratio, 1e-10);
  }
}

TEST(Saturation, AFullWellRefusesTheFiguresAndKeepsTheTermsThatStayTrue) {
  for (const double fill : {1.0001, 1.09, 30.0}) {
    const Budget<double> b = budget_of(mwir_system(), sensor_at_fill(fill), 300.0);
    EXPECT_NEAR(b.well_fill, fill, 1e-12 * fill);
    EXPECT_EQ(b.saturation.end, RangeEnd::full_well);
    for (const BudgetRow& row : rows(b)) {
      static const std::set<std::string> refused{
          "signal_per_k", "scene_shot", "background_shot", "dark_shot", "temporal", "prnu",         "spatial",
          "snr",          "shot_netd",  "spatial_netd",    "netd",      "nei",      "quantisation", "rounding"};
      EXPECT_EQ(std::isnan(row.value), refused.contains(row.name)) << row.name;
      EXPECT_EQ(row.refused.find("saturated") != std::string::npos, refused.contains(row.name)) << row.name;
    }
    EXPECT_EQ(value_of_row(b, "read"), 600.0);
    EXPECT_TRUE(std::isnan(dstar_of(mwir_system(), sensor_at_fill(fill), b)));
    expect_says(words(b.saturation), {"frame.integration_time"});
  }
  EXPECT_EQ(words(budget_of(mwir_system(), sensor_at_fill(0.9), 300.0).saturation), "");
}

// The time that the message names is one at which the well is not full.
TEST(Saturation, TheShorterTimeItNamesIsShortEnough) {
  for (const double fill : {1.001, 1.0917, 1.999, 9.99, 123.4, 1e5}) {
    const std::string text = words(saturation_of({.mean_e = fill * 1e6, .well_e = 1e3, .converter_e = 1e3}, {}, 1e6));
    const std::string start = "to less than ";
    const double factor = std::stod(text.substr(text.find(start) + start.size()));
    EXPECT_LE(factor * fill, 1.0 + 1e-12) << text;
    EXPECT_GT(factor * fill, 0.89) << text;
  }
}

TEST(Saturation, DarkCurrentAloneMayBeTooMuch) {
  Sensor sensor = sensor_at_fill(0.5);
  sensor.settings.detector->dark_e_s = 1e12;
  const Budget<double> b = budget_of(mwir_system(), sensor, 300.0);
  EXPECT_TRUE(std::isnan(b.floor_e));
  EXPECT_TRUE(std::isnan(b.dynamic_range));
}

// digitise() itself says where a converter holds its counts.
TEST(Saturation, TheEndsOfTheConverterAreWhereItHoldsCounts) {
  for (const Rounding rounding : {Rounding::nearest, Rounding::down})
    for (const double offset : {-300.0, 0.0, 250.25})
      for (const double a2 : {0.0, -0.2}) {
        Sensor sensor = test::mwir_sensor();
        sensor.settings.adc =
            AdcSettings{.bits = 10, .electrons_per_count = 500.0, .offset_counts = offset, .rounding = rounding};
        if (a2 != 0.0) sensor.settings.nonlinearity = Nonlinearity{.a2 = a2};
        const Pixel<double> pixel = pixel_of(mwir_system(), sensor);
        const PixelRange range = range_numbers(sensor.settings, pixel);
        const auto held = [&](double electrons) {
          mtf::Image one = flat(1, 1, static_cast<float>(electrons));
          if (a2 != 0.0) apply_response(one.view(), Response({.a2 = a2}, pixel.full_well_e));
          return digitise(one.view(), adc_of(sensor));
        };
        // Floats tell electrons apart to 0.03 here.
        EXPECT_EQ(held(range.most_e - 0.2).high, 0);
        EXPECT_EQ(held(range.most_e + 0.2).high, 1);
        EXPECT_EQ(held(range.least_e - 0.2).low, 1);
        EXPECT_EQ(held(range.least_e + 0.2).low, 0);
      }
}

TEST(Saturation, AConverterWithoutRoomRefusesTooAtEitherEnd) {
  Sensor sensor = noisy_sensor();
  sensor.settings.adc->electrons_per_count = 10.0;
  Budget<double> b = budget_of(mwir_system(), sensor, 300.0);
  EXPECT_EQ(b.saturation.end, RangeEnd::most_count);
  EXPECT_TRUE(std::isnan(b.netd_k));
  EXPECT_GT(b.signal.scene_e, 1e6);
  expect_says(words(b.saturation), {"adc.electrons_per_count"});
  sensor.settings.adc->electrons_per_count = 450.0;
  sensor.settings.adc->offset_counts = -1e4;
  b = budget_of(mwir_system(), sensor, 300.0);
  EXPECT_EQ(b.saturation.end, RangeEnd::least_count);
  EXPECT_TRUE(std::isnan(b.snr));
  expect_says(words(b.saturation), {"raise adc.offset"});
}

// Near an end: the share of held pixels in simulated frames, and how much less their mean rises with the scene, against
// the budget.
TEST(Saturation, NearTheEndTheBudgetSaysWhatFramesDo) {
  for (const double fill : {0.999, 0.997, 0.994}) {
    const Sensor sensor = sensor_at_fill(fill);
    const Budget<double> b = budget_of(mwir_system(), sensor, 300.0);
    ASSERT_FALSE(b.saturation.saturated());
    expect_says(words(b.saturation), {"near saturation"});
    const Chain chain = make_chain(mwir_system(), sensor, 400, 300, 15.0);
    const auto frame = [&](double t) {
      return chain.run(flat(400, 300, static_cast<float>(radiance_of(t))), 0, OutputStage::electrons);
    };
    const double n = 120000.0, share = static_cast<double>(frame(300.0).held.full_well) / n;
    EXPECT_NEAR(share, b.saturation.held,
                kMostSigmas * std::sqrt(b.saturation.held * (1.0 - b.saturation.held) / n) + 1e-4)
        << fill;
    // The same random numbers at both temperatures, a sixth of the scatter apart: 4.5 sigmas of the mean over pixels
    // that rise or do not are 0.0065.
    const double step_k = 0.01, slope = (test::moments(samples(frame(300.0 + step_k).image)).mean -
                                         test::moments(samples(frame(300.0 - step_k).image)).mean) /
                                        (2.0 * step_k);
    EXPECT_NEAR(slope / b.signal_per_k, 1.0 - b.saturation.held, 0.01) << fill;
  }
}

TEST(Saturation, PixelsThatAreMeantToBeStuckAreCountedApart) {
  Sensor sensor = sensor_at_fill(0.5);
  const double well = sensor.settings.detector->full_well_e;
  sensor.settings.defects = Defects{.dead_fraction = 0.002, .hot_fraction = 0.003, .hot_e = 100.0 * well};
  sensor.settings.blinking = Blinking{.fraction = 0.01, .excess_e = 100.0 * well, .dwell_frames = 3.0};
  const Chain chain = make_chain(mwir_system(), sensor, 200, 150, 15.0);
  const auto run = [&](double t, int threads) {
    return chain.run(flat(200, 150, static_cast<float>(radiance_of(t))), 4, OutputStage::dn, 0.0, threads);
  };
  const ChainFrame fine = run(300.0, 1);
  EXPECT_FALSE(fine.held.any());
  EXPECT_EQ(words(fine.held), "");
  EXPECT_GT(fine.held_defects.full_well, 100);
  EXPECT_EQ(fine.held_defects.full_well, fine.well.high);
  EXPECT_EQ(fine.held.pixels + fine.held_defects.pixels, 200 * 150);

  const ChainFrame full = run(400.0, 1), again = run(400.0, 2);
  EXPECT_EQ(full.held.full_well, full.held.pixels);
  EXPECT_EQ(full.held.share(), 1.0);
  EXPECT_EQ(full.held, again.held);
  EXPECT_EQ(full.held_defects, again.held_defects);
  expect_says(words(full.held), {"100 %"});

  sensor.settings.blooming = Blooming{};
  const ChainFrame spilled = make_chain(mwir_system(), sensor, 200, 150, 15.0)
                                 .run(flat(200, 150, static_cast<float>(radiance_of(400.0))), 4, OutputStage::dn);
  EXPECT_EQ(spilled.held, full.held);
}

TEST(Saturation, FlatFramesThatCannotBeHadSayWhy) {
  Sensor sensor = sensor_at_fill(0.5);
  sensor.settings.correction = CorrectionSettings{.frames = 2};
  sensor.settings.detector->dark_e_s = 0.3 * sensor.settings.detector->full_well_e / 2e-3;
  const auto run = [&](double t) {
    return make_chain(mwir_system(), sensor, 16, 16, 15.0)
        .run(flat(16, 16, static_cast<float>(radiance_of(t))), 0, OutputStage::display);
  };
  expect_refused({"[correction]", "low = 0.2", "fill 0.3 of it", "to less than 0.66", "correction.low"},
                 [&] { run(200.0); });
  expect_refused({"[correction]", "saturated too: 100 %", "(256 of 256)", "full well"}, [&] { run(400.0); });
  sensor.settings.detector->dark_e_s *= 4.0;
  expect_refused({"[correction]", "the detector is saturated", "frame.integration_time"}, [&] { run(200.0); });
  sensor.settings.detector->dark_e_s = 0.0;
  sensor.settings.correction->high = 1.0;
  expect_refused({"[correction]", "high = 1 ", "full well", "lower correction.high"}, [&] { run(200.0); });
  // The correction is made for pixels that are bad by design.
  sensor.settings.correction->high = 0.8;
  sensor.settings.defects = Defects{.hot_fraction = 0.2, .hot_e = 100.0 * sensor.settings.detector->full_well_e};
  EXPECT_NO_THROW(run(250.0));
}

}  // namespace
}  // namespace radiometry
