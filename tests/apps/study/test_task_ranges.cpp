// SPDX-License-Identifier: Apache-2.0

// Ranges of one sensor and probability against range, with what is uncertain of them.

#include "apps/study/task_ranges.h"

#include "apps/sensor/sensor_chain.h"
#include "tests/apps/study/evaluated.h"
#include "tests/apps/study/range_camera.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using namespace study_test;
using study::Acquisition;
using study::TaskRange;

radiometry::Conditions conditions(double contrast_k = 1.0) {
  radiometry::Conditions c;
  c.contrast_k = contrast_k;
  c.target_size_m = 2.3;
  c.frame_rate_hz = 60.0;
  c.magnification = 5.0;
  return c;
}

Acquisition found(const Folder& folder, const std::string& text, const radiometry::Conditions& c = conditions(),
                  const std::vector<double>& range_m = {}, double tolerance = 1e-6) {
  folder.write("camera.toml", text);
  return study::acquisition(apps::read_sensor_file(folder / "camera.toml"), c, range_m, tolerance);
}

const TaskRange& task(const Acquisition& a, const std::string& metric) {
  for (const TaskRange& one : a.tasks)
    if (one.metric == metric) return one;
  ADD_FAILURE() << "no " << metric;
  return a.tasks[0];
}

/// P of x = cycles / (cycles that half of the trials need), E = constant + slope x, as the models are published.
double law(double x, double constant, double slope) {
  const double power = std::pow(x, constant + slope * x);
  return power / (1.0 + power);
}

TEST(Acquisition, RangesAreTheMetricsOfStudies) {
  const Folder folder;
  const Acquisition a = found(folder, camera(kFog + "range = \"1 km\"\n"));
  const auto metrics = ranges_of(folder, study_of(kTime));
  for (const TaskRange& one : a.tasks) {
    EXPECT_EQ(one.range_m, metrics.at(one.metric));
    EXPECT_LE(one.error_m, metrics.at("error") * one.range_m);
    EXPECT_GT(one.error_m, 0.0);
  }
  expect_says(a.lines.back(), {"air: [atmosphere]", "up to each"});
}

// Without air V falls with 1/R from where it is V50, which another program found (test_ranges.cpp); bars are limited by
// Nyquist, 5 cy/mrad on 2.3 m.
TEST(Acquisition, ProbabilitiesAreTheLawsOfWhatIsResolved) {
  const Folder folder;
  const std::vector<double> ranges{500.0, 1500.0, 4000.0, 12000.0, 30000.0};
  const Acquisition a = found(folder, camera(""), conditions(), ranges);
  ASSERT_EQ(a.range_m, ranges);
  const std::array<double, 3> ttp_m{25857.012, 6895.2032, 3978.0019}, n50{0.75, 3.0, 6.0};
  for (std::size_t r = 0; r < ranges.size(); ++r)
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(a.tasks[i].probability[r], law(11500.0 / ranges[r] / n50[i], 2.7, 0.7), 1e-12);
      EXPECT_NEAR(a.tasks[3 + i].probability[r], law(ttp_m[i] / ranges[r], 1.51, 0.24), 1e-5);
      EXPECT_LT(std::abs(a.tasks[3 + i].probability_error[r]), 1e-5);
    }
}

TEST(Acquisition, TheRangeIsWhereTheTaskHasItsProbability) {
  const Folder folder;
  radiometry::Conditions c = conditions();
  c.probability = 0.8;
  const std::string fog = camera(kFog + "range = \"1 km\"\n");
  const Acquisition at = found(folder, fog, c, {}, 1e-4);
  for (const TaskRange& one : at.tasks) {
    const Acquisition there = found(folder, fog, c, {one.range_m}, 1e-4);
    EXPECT_NEAR(task(there, one.metric).probability[0], 0.8, 3e-4) << one.metric;
  }
}

// Beer's law takes contrast alone: what is reached through it is what a vacuum lets a fainter target be seen at.
TEST(Acquisition, ExtinctionIsAFainterTarget) {
  const Folder folder;
  radiometry::Conditions dim = conditions();
  dim.extinction_per_km = 0.5;
  const Acquisition a = found(folder, camera(""), dim);
  for (const char* metric : {"ttp_range_detect", "ttp_range_identify"}) {
    const double range = task(a, metric).range_m;
    const Acquisition faint = found(folder, camera(""), conditions(std::exp(-0.5e-3 * range)));
    EXPECT_NEAR(task(faint, metric).range_m / range, 1.0, 1e-6) << metric;
  }
}

// Ranges at Nyquist are proportional to focal length / pitch.
TEST(Acquisition, StatedStandardDeviationsMoveRanges) {
  const Folder folder;
  const Acquisition none = found(folder, camera(""));
  EXPECT_TRUE(none.stated.empty());
  std::string text =
      replaced(camera(""), "focal_length = \"150 mm\"", "focal_length = { value = \"150 mm\", stderr = \"1.5 mm\" }");
  text = replaced(text, "pitch = \"15 um\"", "pitch = { value = \"15 um\", stderr = \"0.3 um\" }");
  text = replaced(text, "read_noise = \"7054.544717 e-\"",
                  "read_noise = { value = \"7054.544717 e-\", stderr = \"500 e-\" }");
  const Acquisition a = found(folder, text, conditions(), {4000.0});
  ASSERT_EQ(a.stated.size(), 3u);
  const TaskRange& bars = task(a, "johnson_range_identify");
  const double by_focal = 0.01, by_pitch = 0.5 * (15.0 / 14.7 - 15.0 / 15.3);
  EXPECT_NEAR(bars.sd_m / bars.range_m, std::hypot(by_focal, by_pitch), 1e-9);
  EXPECT_EQ(bars.range_m, task(none, "johnson_range_identify").range_m);
  EXPECT_TRUE(bars.at_nyquist);
  // More noise, a shorter range by TTP; bars at Nyquist do not feel it.
  for (const study::StatedNumber& one : a.stated)
    if (one.path == "detector.read_noise") {
      EXPECT_EQ(one.moves_m[2], 0.0);
      EXPECT_LT(one.moves_m[5], -1.0);
    }
  const TaskRange& ttp = task(a, "ttp_range_identify");
  EXPECT_GT(ttp.sd_m, 0.0);
  // P falls with range: at the range of a probability its deviation is that of the range along the curve.
  const Acquisition near = found(folder, text, conditions(), {ttp.range_m, 1.001 * ttp.range_m});
  const TaskRange& there = task(near, "ttp_range_identify");
  const double slope = (there.probability[1] - there.probability[0]) / (0.001 * ttp.range_m);
  EXPECT_NEAR(there.probability_sd[0] / (ttp.sd_m * std::abs(slope)), 1.0, 0.02);
}

TEST(Acquisition, ANumberThatCannotBeMovedToOneSideIsMovedToTheOther) {
  const Folder folder;
  const std::string text = replaced(camera(""), "fill_factor = 0.9", "fill_factor = { value = 0.99, stderr = 0.05 }");
  const Acquisition a = found(folder, text);
  ASSERT_EQ(a.stated.size(), 1u);
  EXPECT_EQ(a.stated[0].problem, "");
  EXPECT_GT(task(a, "ttp_range_detect").sd_m, 0.0);
}

// What cannot be moved to either side leaves the deviation unknown, and says why.
TEST(Acquisition, ANumberThatCannotBeMovedSaysWhy) {
  const Folder folder;
  const Acquisition a = found(folder, replaced(camera(""), "integration_time = \"5 ms\"",
                                               "integration_time = { value = \"5 ms\", stderr = \"9 s\" }"));
  ASSERT_EQ(a.stated.size(), 1u);
  EXPECT_FALSE(a.stated[0].problem.empty());
  EXPECT_TRUE(std::isnan(task(a, "ttp_range_detect").sd_m));
}

TEST(AcquisitionLong, ATargetWiderThanTheFieldIsSaid) {
  const Folder folder;
  radiometry::Conditions wide = conditions();
  wide.target_size_m = 30.0;
  const std::string fog = camera(kFog + "range = \"1 km\"\n");
  const Acquisition a = found(folder, fog, wide, {}, 1e-4);
  EXPECT_NEAR(a.filled_m, 30.0 / (512 * 15e-6 / 0.15), 1e-9);  // rows
  EXPECT_EQ(task(a, "ttp_range_identify").fills_field, task(a, "ttp_range_identify").range_m < a.filled_m);
  EXPECT_TRUE(task(a, "ttp_range_identify").fills_field);
  EXPECT_FALSE(task(found(folder, fog, conditions(), {}, 1e-4), "ttp_range_identify").fills_field);
}

TEST(Acquisition, WhatIsKnownOfTheAirEndsRangesAndProbabilities) {
  const Folder folder;
  folder.write("air.csv", beer_table(0.05, {500.0, 1000.0, 2000.0}, false));
  const std::string text = camera("[path]\ntable = \"air.csv\"\nrange = \"1 km\"\n");
  const Acquisition a = found(folder, text, conditions(), {1000.0, 3000.0}, 1e-4);
  EXPECT_TRUE(std::isnan(task(a, "ttp_range_detect").range_m));
  expect_says(task(a, "ttp_range_detect").reason, {"still succeeds at 2000 m", "air.csv ends"});
  EXPECT_EQ(a.range_m, std::vector<double>{1000.0});
  EXPECT_GT(task(a, "ttp_range_detect").probability[0], 0.9);
  ASSERT_EQ(a.cautions.size(), 1u);
  expect_says(a.cautions[0], {"2000 m", "air.csv ends"});
}

// Far below one pixel a degree it is the eye alone that ends what is resolved: its noise of the display falls with the
// magnification, so that the range becomes proportional to it. Such views had a range of 0.
TEST(Acquisition, AViewThatTheEyeLimitsIsProportionalToTheMagnification) {
  const Folder folder;
  double before = 0.0;
  for (double magnification = 1.0 / 512.0; magnification < 0.1; magnification *= 2.0) {
    radiometry::Conditions c = conditions();
    c.magnification = magnification;
    const double range_m = task(found(folder, camera(""), c, {100.0}), "ttp_range_detect").range_m;
    EXPECT_GT(range_m, 0.0) << magnification;
    if (before > 0.0) {
      EXPECT_NEAR(range_m / before, 2.0, 0.02) << magnification;
    }
    before = range_m;
  }
}

// Nobody knows how a transmission falls to the 0 of a table: what a straight line makes of it has no known error.
TEST(Acquisition, ATransmissionOfZeroIsNoKnowledge) {
  const Folder folder;
  std::string table = "range_m,wavelength_um,transmission,radiance_W_m-2_sr-1_um-1\n";
  for (const auto& [range, transmission] : {std::pair{"4000", "0.9"}, {"6000", "0.8"}, {"90000", "0"}})
    for (const char* wavelength : {"3", "4", "5"})
      table += std::string(range) + "," + wavelength + "," + transmission + ",0\n";
  folder.write("air.csv", table);
  const Acquisition a =
      found(folder, camera("[path]\ntable = \"air.csv\"\nrange = \"5 km\"\n"), conditions(), {5000.0, 20000.0}, 1e-4);
  EXPECT_TRUE(std::isinf(task(a, "ttp_range_detect").error_m));
  EXPECT_LT(task(a, "johnson_range_identify").error_m, 1.0);  // at Nyquist, nearer than 6 km
  EXPECT_LT(task(a, "ttp_range_detect").probability_error[0], 0.1);
  EXPECT_NEAR(task(a, "ttp_range_detect").probability_error[1], task(a, "ttp_range_detect").probability[1], 1e-12);
}

// The background alone fills more of the well than the lower flat frame.
TEST(Acquisition, NoFlatFrameNoRange) {
  const Folder folder;
  const std::string text = camera("[correction]\nlow = 0.0001\nhigh = 0.8\n");
  expect_refused({"flat frame"}, [&] { static_cast<void>(found(folder, text)); });
}

TEST(Acquisition, RefusesWhatHasNoRange) {
  const Folder folder;
  const auto refused = [&](const std::string& text, const radiometry::Conditions& c,
                           std::initializer_list<std::string_view> parts) {
    expect_refused(parts, [&] { static_cast<void>(found(folder, text, c)); });
  };
  radiometry::Conditions c = conditions();
  refused(camera("[path]\ntransmission = 0.8\n"), c, {"holds for one range", "[atmosphere]"});
  folder.write("air.csv", beer_table(0.5, {2000.0}, false));
  refused(camera("[path]\ntable = \"air.csv\"\nrange = \"1 km\"\n"), c, {"holds one range", "mtf atmosphere --table"});
  c.extinction_per_km = 0.2;
  refused(camera(kFog + "range = \"1 km\"\n"), c, {"extinction", "[atmosphere] of", "remove"});
  refused(camera(""), {}, {"contrast"});
  // Without what the observer looks at, bars alone have ranges.
  radiometry::Conditions blind = conditions();
  blind.magnification.reset();
  const Acquisition a = found(folder, camera(""), blind);
  EXPECT_TRUE(std::isfinite(task(a, "johnson_range_detect").range_m));
  expect_says(task(a, "ttp_range_detect").reason, {"display_height and viewing_distance"});
  EXPECT_TRUE(task(a, "ttp_range_detect").probability.empty());
}

}  // namespace
