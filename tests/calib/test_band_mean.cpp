// SPDX-License-Identifier: Apache-2.0
// OTFs averaged over a band against System::otf, and the fit in a band.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "calib/fit/sensors.h"
#include "tests/calib/fit_cases.h"

namespace {

using calib::PixelFreq;
using mtf::Component;
using mtf::System;

System<double> in_a_band(Component<double> pupil, double lo_um, double hi_um) {
  System<double> sensor = fit_cases::camera(8.0);
  sensor.optics.wavelength_um = std::nullopt;
  sensor.band = mtf::Band{lo_um, hi_um};
  sensor.stages[0][0].component = std::move(pupil);
  return sensor;
}

Component<double> with(const char* kind, std::initializer_list<std::pair<const char*, double>> fields) {
  auto component = Component<double>::make(kind);
  for (const auto& [name, value] : fields) mtf::test::set(component, name, value);
  return component;
}

/// H by System::otf, which averages to 1e-12.
std::vector<mtf::Complex<double>> plain(const System<double>& sensor, std::span<const PixelFreq> f) {
  std::vector<mtf::Complex<double>> all;
  for (const PixelFreq& p : f)
    all.push_back(
        sensor.otf({sensor.frame.cy_mm_from_px(p.x, mtf::Axis::x), sensor.frame.cy_mm_from_px(p.y, mtf::Axis::y)}));
  return all;
}

/// Values against System::otf, derivatives by the one parameter against differences of it.
void compare(const System<double>& sensor, const std::string& path, int count, double error) {
  calib::Sensors sensors({&sensor, 1}, {&path, 1});
  std::vector<double> t;
  for (int i = 0; i < count; ++i) t.push_back(2.2 * (i + 0.3) / count);
  const std::vector<PixelFreq> f = calib::along(0.4, t);
  System<double> changed = sensor;
  const double start = *calib::parameter_at(changed, path), h = 1e-4 * std::max(1.0, std::abs(start));
  sensors.set({&start, 1});
  const calib::OtfTable table = sensors.otf(0, f);
  const auto expected = plain(sensor, f);
  calib::set_parameter(changed, path, start + h);
  const auto up = plain(changed, f);
  calib::set_parameter(changed, path, start - h);
  const auto down = plain(changed, f);
  double steepest = 0.0;
  for (const auto& slope : table[1]) steepest = std::max(steepest, std::hypot(slope.re, slope.im));
  ASSERT_GT(steepest, 0.0);
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_NEAR(table[0][i].re, expected[i].re, error) << t[i];
    EXPECT_NEAR(table[0][i].im, expected[i].im, error) << t[i];
    // Near kinks a difference quotient does not approximate the derivative.
    EXPECT_NEAR(table[1][i].re, (up[i].re - down[i].re) / (2.0 * h), 2e-4 * steepest) << t[i];
    EXPECT_NEAR(table[1][i].im, (up[i].im - down[i].im) / (2.0 * h), 2e-4 * steepest) << t[i];
  }
}

}  // namespace

TEST(BandMean, IsThatOfManyWavelengths) {
  const auto defocus = with("defocus", {{"waves", 0.7}, {"wavelength_reference", 0.6}, {"obscuration", 0.3}});
  compare(in_a_band(defocus, 0.45, 0.85), "presample[0].waves", 40, 2e-7);
  const auto coma = with("wavefront", {{"w020", 0.3}, {"w131", 0.4}, {"wavelength_reference", 0.6}});
  compare(in_a_band(coma, 0.45, 0.65), "presample[0].w131", 24, 2e-7);
  compare(in_a_band(Component<double>::make("diffraction"), 0.45, 0.65), "optics.f_number", 40, 2e-7);
}

// With nearly all electrons at the short end the mean differs from the unweighted one.
TEST(BandMean, WeighsByTheElectronRate) {
  const auto density = [](double l) { return l < 0.5 ? 18.0 : 0.1 / 0.35; };
  const auto rate = std::make_shared<const mtf::ElectronRate>(nullptr, density, std::vector{0.45, 0.5, 0.85});
  const auto defocus = with("defocus", {{"waves", 0.7}, {"wavelength_reference", 0.6}, {"obscuration", 0.3}});
  System<double> sensor = in_a_band(defocus, 0.45, 0.85);
  const std::vector<PixelFreq> f = calib::along(0.4, std::vector{0.3});
  const double even = plain(sensor, f)[0].re;
  sensor.band->rate = rate;
  EXPECT_GT(std::abs(plain(sensor, f)[0].re - even), 0.01);
  compare(sensor, "presample[0].waves", 40, 2e-7);
  compare(sensor, "presample[0].waves", 5, 2e-7);
}

TEST(BandMean, FewFrequenciesNeedNoTable) {
  const auto defocus = with("defocus", {{"waves", 0.7}, {"wavelength_reference", 0.6}});
  compare(in_a_band(defocus, 0.45, 0.85), "presample[0].waves", 5, 2e-7);
}

TEST(BandMean, AWideBandAndNoCutoff) {
  const auto defocus = with("defocus", {{"waves", 2.0}, {"wavelength_reference", 0.6}});
  compare(in_a_band(defocus, 0.4, 14.0), "presample[0].waves", 30, 2e-7);
  const auto turbulence = with("turbulence", {{"fried_parameter", 5.0}, {"wavelength_reference", 0.5}});
  compare(in_a_band(turbulence, 0.45, 0.85), "presample[0].fried_parameter", 40, 2e-7);
}

TEST(BandMean, FrequenciesOfAPlane) {
  const auto coma = with("wavefront", {{"w131", 0.3}, {"wavelength_reference", 0.6}});
  const System<double> sensor = in_a_band(coma, 0.5, 0.6);
  const std::string path = "presample[0].w131";
  calib::Sensors sensors({&sensor, 1}, {&path, 1});
  const double value = 0.3;
  sensors.set({&value, 1});
  const std::vector<PixelFreq> f{{0.1, 0.0, 0, 0}, {0.2, 0.3, 0, 0}, {-0.1, 0.4, 0, 0}, {0.0, 0.0, 0, 0}};
  const calib::OtfTable table = sensors.otf(0, f);
  const auto expected = plain(sensor, f);
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_NEAR(table[0][i].re, expected[i].re, 1e-8);
    EXPECT_NEAR(table[0][i].im, expected[i].im, 1e-8);
  }
}
