// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/fit_cases.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fit_cases {

using mtf::Component;
using mtf::Stage;
using mtf::System;

System<double> bare() {
  System<double> s;
  s.name = "test";
  s.frame = {50.0, kPitch_um, kPitch_um, 0.01, 0, 0};
  s.optics.wavelength_um = kWavelength_um;
  return s;
}

System<double> gaussian(double sigma_px) {
  System<double> s = bare();
  auto c = Component<double>::make("gaussian");
  mtf::test::set(c, "sigma", sigma_px, "px");
  s.add(Stage::presample, c);
  return s;
}

System<double> camera(double f_number, double pixel_px) {
  System<double> s = bare();
  s.optics.f_number = f_number;
  s.add(Stage::presample, Component<double>::make("diffraction"));
  auto pixel = Component<double>::make("footprint");
  mtf::test::set(pixel, "width", pixel_px, "px");
  s.add(Stage::presample, pixel);
  return s;
}

System<double> table_sensor(double wfe, double jitter_px, double smear_px) {
  System<double> s = camera(0.93 * kPitch_um / kWavelength_um);
  auto rms = Component<double>::make("rms_wavefront");
  mtf::test::set(rms, "rms", wfe);
  s.add(Stage::presample, rms);
  s.add(Stage::presample, mtf::test::jitter(jitter_px, "px"));
  auto motion = Component<double>::make("linear_motion");
  mtf::test::set(motion, "travel", smear_px, "px");
  s.add(Stage::presample, motion);
  return s;
}

double sigma_of(double mtf50_cy_px) { return std::sqrt(0.5 * std::numbers::ln2) / (std::numbers::pi * mtf50_cy_px); }

calib::EdgeData edge_of(const mtf::Image& image, const made::Scene& scene, const std::string& name) {
  const double angle = scene.angle_deg * std::numbers::pi / 180.0, c = std::cos(angle), s = std::sin(angle);
  calib::EdgeData data{.name = name,
                       .image = image.view(),
                       .roi = {0, 0, image.width(), image.height()},
                       .condition = 0,
                       .start = {},
                       .quantum = scene.quantum};
  calib::EdgeMeasurement& start = data.start;
  start.roi = data.roi;
  start.curve.origin = {scene.x.value_or(0.5 * static_cast<double>(scene.width)) + 0.07 * c,
                        scene.y.value_or(0.5 * static_cast<double>(scene.height)) + 0.07 * s};
  start.curve.angle_rad = angle + 0.001;
  start.curve.half_length_px = scene.half_length_px;
  if (scene.sagitta_px != 0.0) {
    start.curve.shape = calib::EdgeCurve::Shape::polynomial;
    start.curve.coefficient = {0.95 * scene.sagitta_px};
  }
  start.dark = scene.dark + 0.01 * (scene.bright - scene.dark);
  start.bright = scene.bright - 0.005 * (scene.bright - scene.dark);
  start.noise_gain = scene.noise_gain;
  const double middle = 0.5 * (scene.dark + scene.bright);
  start.noise_sd = std::sqrt(scene.noise_sd * scene.noise_sd + scene.noise_gain * middle);
  start.length_px =
      static_cast<double>(std::abs(c) > std::abs(s) ? scene.height : scene.width) / std::max(std::abs(c), std::abs(s));
  return data;
}

calib::FitData data_of(System<double> sensor, calib::EdgeData edge) {
  calib::FitData data;
  data.conditions.push_back(std::move(sensor));
  data.edges.push_back(std::move(edge));
  return data;
}

calib::FitParameter parameter(const std::string& path, const std::string& name) {
  calib::FitParameter p;
  p.path = path;
  p.name = name;
  return p;
}

double mtf_along(const System<double>& system, double angle_deg, double f_cy_px) {
  const double angle = angle_deg * std::numbers::pi / 180.0;
  const auto h = system.otf({system.frame.cy_mm_from_px(f_cy_px * std::cos(angle), mtf::Axis::x),
                             system.frame.cy_mm_from_px(f_cy_px * std::sin(angle), mtf::Axis::y)});
  return std::hypot(h.re, h.im);
}

double mtf50_along(const System<double>& system, double angle_deg) {
  double low = 0.0, high = 0.0;
  while (high < 4.0 && mtf_along(system, angle_deg, high) >= 0.5) low = high, high += 1e-3;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (mtf_along(system, angle_deg, middle) >= 0.5 ? low : high) = middle;
  }
  return low;
}

}  // namespace fit_cases
