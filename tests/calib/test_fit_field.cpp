// SPDX-License-Identifier: Apache-2.0
// Bundles of edges over the field: terms of a lens, what leaves their sign open, and where edges are missing.
#include <gtest/gtest.h>

#include <cmath>

#include "calib/fit/sensors.h"
#include "tests/calib/field_chart.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using field_chart::Lens;
using field_chart::Patch;
using mtf::System;

constexpr int kColumns = 10, kRows = 6;
constexpr double kNoise = 0.006;  // contrast / noise 100

/// What a fit knows about where it starts.
const Lens kStart{.w040 = 0.1, .w131 = 0.3, .w222 = 0.4, .curvature = 0.2, .focus = -0.1, .tilt_x = 0.0, .tilt_y = 0.0};

struct Bundle {
  std::vector<mtf::Image> images;
  FitData data;
  Bundle(std::vector<Patch> all, std::initializer_list<double> focus_settings, std::uint64_t seed = 5) {
    images.reserve(focus_settings.size());
    for (const double more : focus_settings) {
      const System<double> truth = field_chart::sensor_of({}, kColumns, kRows, more);
      images.push_back(field_chart::with_noise(field_chart::image_of(truth, all), kNoise, seed + images.size()));
      data.conditions.push_back(field_chart::sensor_of(kStart, kColumns, kRows, more));
      field_chart::add_edges(data, images.back(), all, kNoise, images.size() - 1);
    }
  }
};

bool holds(const FittedParameter& p, double value, double truth) {
  return p.stderr_value && std::abs(value - truth) < 4.0 * *p.stderr_value;
}

TEST(FitField, OneFocusSettingLeavesTheSignOfEvenTermsOpen) {
  const Bundle bundle(field_chart::patches(kColumns, kRows), {0.0});
  const auto parameters = field_chart::parameters_of_lens();
  const FitResult result = fit(bundle.data, parameters);
  ASSERT_EQ(result.status, FitStatus::converged) << result.reason;
  const std::vector<double> truth = field_chart::values_of({});
  const double sign = std::copysign(1.0, result.parameters[4].value);  // of w040, which is above 0
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const FittedParameter& p = result.parameters[i];
    const bool odd = p.parameter.name == "w131.r";
    EXPECT_EQ(p.knowledge, odd ? Knowledge::determined : Knowledge::ambiguous) << p.parameter.name;
    EXPECT_TRUE(holds(p, p.value, odd ? truth[i] : sign * truth[i])) << p.parameter.name << " " << p.value;
    ASSERT_EQ(p.others.size(), odd ? 0u : 1u);
    for (const OtherValue& other : p.others) EXPECT_NEAR(other.value, -p.value, 0.01 * p.linear_sd);
  }
  ASSERT_EQ(result.alternatives.size(), 1u);
  expect_says(result.alternatives[0].text, {"w020.1, w020.r2", "do not tell", "another focus"});
  ASSERT_EQ(result.other_minima.size(), 1u);  // with the parameters that do not differ
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const FittedParameter& p = result.parameters[i];
    EXPECT_NEAR(result.other_minima[0][i], p.others.empty() ? p.value : p.others[0].value, 1e-12 + 0.01 * p.linear_sd);
  }
}

TEST(FitField, ASecondFocusSettingTellsTheSign) {
  const Bundle bundle(field_chart::patches(kColumns, kRows), {0.0, 0.5});
  const FitResult result = fit(bundle.data, field_chart::parameters_of_lens());
  ASSERT_EQ(result.status, FitStatus::converged) << result.reason;
  const std::vector<double> truth = field_chart::values_of({});
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const FittedParameter& p = result.parameters[i];
    EXPECT_EQ(p.knowledge, Knowledge::determined) << p.parameter.name;
    EXPECT_TRUE(holds(p, p.value, truth[i])) << p.parameter.name << " " << p.value;
  }
  EXPECT_TRUE(result.alternatives.empty());
}

// Beside a spherical aberration of 0.3 waves that is known, a focus is mirrored about nearly the same centre at all 12
// places, so that near it no standard error holds.
TEST(FitField, ConstantTermsAreMirroredAlikeAtAllPlaces) {
  const auto patches = field_chart::patches(4, 3);
  constexpr double noise = 5.0 * kNoise;
  const auto sensor = [](double focus) {
    return field_chart::sensor_of(
        {.w040 = 0.3, .w131 = 0.0, .w222 = 0.0, .curvature = 0.0, .focus = focus, .tilt_x = 0.0, .tilt_y = 0.0}, 4, 3);
  };
  const mtf::Image image = field_chart::with_noise(field_chart::image_of(sensor(-0.26), patches), noise, 5);
  FitData data;
  data.conditions.push_back(sensor(-0.2));
  field_chart::add_edges(data, image, patches, noise, 0);
  const FittedParameter p = fit(data, std::vector{fit_cases::parameter("presample[0].w020")}).parameters[0];
  ASSERT_EQ(p.knowledge, Knowledge::interval) << p.value << " +- " << p.linear_sd;
  EXPECT_LT((*p.interval95)[0], p.value - 2.5 * p.linear_sd);  // beyond the centre, where the curvature does not reach
  EXPECT_GT((*p.interval95)[1], -0.26);
}

TEST(FitField, EdgesOnADiagonalAreNamed) {
  std::vector<Patch> all;
  for (int i = 0; i < kRows; ++i) all.push_back({i + 2, i, i % 2 == 0 ? 5.0 : 95.0});
  const Bundle bundle(all, {0.0, 0.5});
  const FitResult result = fit(bundle.data, field_chart::parameters_of_lens());
  ASSERT_FALSE(result.not_separable.empty());
  expect_says(result.not_separable[0].text, {"w020.x", "w020.y", "2 directions", "3 directions", "3 distances"});
  for (const std::size_t i : {2u, 3u})
    EXPECT_EQ(result.parameters[i].knowledge, Knowledge::not_determined) << result.parameters[i].parameter.name;
}

// Derivatives reach terms and axis through the field point: against differences of System::at.
TEST(FitField, DerivativesByTermsAndAxis) {
  const System<double> sensor = field_chart::sensor_of({}, kColumns, kRows);
  const std::vector<std::string> paths{"presample[0].w020.1",  "presample[0].w020.x", "presample[0].w131.r",
                                       "presample[0].w222.r2", "optical_axis.x",      "optical_axis.y"};
  Sensors sensors({&sensor, 1}, paths);
  const double x = 70.0, y = 150.0;
  const std::size_t place = sensors.place(0, {{x, y}});
  const std::vector<double> f{0.05, 0.2, 0.5, 0.9};
  const OtfTable table = sensors.otf(place, along(0.3, f));
  const auto exact = [&](const System<double>& s, double f_cy_px) {
    const double mm = 1e3 / s.frame.pitch_x_um * f_cy_px;
    return s.at(s.field_point(x, y)).otf({mm * std::cos(0.3), mm * std::sin(0.3)});
  };
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_NEAR(table[0][i].re, exact(sensor, f[i]).re, 1e-12);
    EXPECT_NEAR(table[0][i].im, exact(sensor, f[i]).im, 1e-12);
    for (std::size_t k = 0; k < paths.size(); ++k) {
      System<double> up = sensor, down = sensor;
      const double h = 1e-4 * (k < 4 ? 1.0 : 100.0), value = *parameter_at(up, paths[k]);
      set_parameter(up, paths[k], value + h);
      set_parameter(down, paths[k], value - h);
      const auto a = exact(up, f[i]), b = exact(down, f[i]);
      // Second order of the step: (2 pi)^3 h^2 / 6.
      EXPECT_NEAR(table[k + 1][i].re, (a.re - b.re) / (2.0 * h), 1e-6) << paths[k];
      EXPECT_NEAR(table[k + 1][i].im, (a.im - b.im) / (2.0 * h), 1e-6) << paths[k];
    }
  }
}

// Many frequencies of one direction come from a series, as well as its error says.
TEST(FitField, ManyFrequenciesAreASeries) {
  for (const double obscuration : {0.0, 0.35}) {
    System<double> sensor = field_chart::sensor_of({}, kColumns, kRows);
    sensor.optics.obscuration = obscuration;
    const std::string path = "presample[0].w131.r";
    Sensors sensors({&sensor, 1}, {&path, 1});
    const std::size_t place = sensors.place(0, {{10.0, 20.0}});
    std::vector<double> f;
    for (int i = 0; i <= 400; ++i) f.push_back(0.004 * i);
    const std::vector<PixelFreq> at = along(0.4, f);
    const OtfTable many = sensors.otf(place, at);
    for (std::size_t i = 0; i < f.size(); i += 7) {
      const OtfTable one = sensors.otf(place, {&at[i], 1});
      EXPECT_NEAR(many[0][i].re, one[0][0].re, 1e-7) << f[i];
      EXPECT_NEAR(many[0][i].im, one[0][0].im, 1e-7) << f[i];
      EXPECT_NEAR(many[1][i].re, one[1][0].re, 1e-5) << f[i];
      EXPECT_NEAR(many[1][i].im, one[1][0].im, 1e-5) << f[i];
      EXPECT_NEAR(many[2][i].re, one[2][0].re, 1e-5) << f[i];
    }
  }
}

// Stated intervals hold as often as they say: a jitter that grows over the field, many draws pooled over its terms.
TEST(FitField, IntervalsHold) {
  const auto sensor = [](double rms_px, double r2, double x) {
    System<double> s = fit_cases::camera(5.6);
    s.frame.columns = field_chart::kPatch * 5, s.frame.rows = field_chart::kPatch * 4;
    s.add(mtf::Stage::presample, mtf::test::jitter(rms_px, "px"));
    mtf::test::let_vary(s, 2, "rms", "r2", r2);
    mtf::test::let_vary(s, 2, "rms", "x", x);
    return s;
  };
  const std::vector<double> truth{0.4, 0.3, 0.1};
  const std::vector<FitParameter> parameters{fit_cases::parameter("presample[2].rms.1"),
                                             fit_cases::parameter("presample[2].rms.r2"),
                                             fit_cases::parameter("presample[2].rms.x")};
  const std::vector<Patch> all = field_chart::patches(5, 4);
  const mtf::Image clean = field_chart::image_of(sensor(truth[0], truth[1], truth[2]), all);
  int held = 0, stated = 0;
  constexpr int kDraws = 60;
  for (int draw = 0; draw < kDraws; ++draw) {
    const mtf::Image image = field_chart::with_noise(clean, kNoise, 100 + static_cast<std::uint64_t>(draw));
    FitData data;
    data.conditions.push_back(sensor(0.3, 0.1, 0.0));
    field_chart::add_edges(data, image, all, kNoise);
    const FitResult result = fit(data, parameters);
    ASSERT_EQ(result.status, FitStatus::converged) << result.reason;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const FittedParameter& p = result.parameters[i];
      ASSERT_TRUE(p.stderr_value) << parameters[i].path;
      held += std::abs(p.value - truth[i]) < 1.96 * *p.stderr_value;
      ++stated;
    }
  }
  // 171 of 180 are expected; 2.5 standard deviations of that count, 2.9 each.
  EXPECT_GE(held, 163) << stated;
  EXPECT_LE(held, 178) << stated;
}

TEST(FitField, ImagesOfAnotherSizeAreRefused) {
  Bundle bundle({{2, 3, 5.0}}, {0.0});
  const auto parameters = field_chart::parameters_of_lens();
  FitData data = bundle.data;
  data.conditions[0].frame.columns = 200;
  expect_refused<mtf::UsageError>({"2,3", "320 x 192", "200 x 192", "frame.format"}, [&] { fit(data, parameters); });
  data.conditions[0].frame.columns = data.conditions[0].frame.rows = 0;
  expect_refused<mtf::UsageError>({"frame.format", "not given"}, [&] { fit(data, parameters); });
  const std::vector twice{fit_cases::parameter("presample[0].w020"), fit_cases::parameter("presample[0].w020.1")};
  expect_refused<mtf::UsageError>({"w020", "twice"}, [&] { fit(bundle.data, twice); });
  const std::vector none{fit_cases::parameter("presample[0].w040.x")};
  expect_refused<mtf::UsageError>({"w040.x", "no such number"}, [&] { fit(bundle.data, none); });
}

}  // namespace
}  // namespace calib
