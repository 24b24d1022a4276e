// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the plan tests share: scenes from formulas, one-call compile and run, and distances to a reference.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/plan/plan.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/reference.h"

namespace mtf::test {

inline constexpr std::array kBorders{Border::reflect, Border::replicate, Border::constant, Border::periodic};

/// A system with nothing in it: pitch 15 x 12 um, 4 um wavelength, F/2.
inline System<double> bare(double pitch_x_um = 15.0, double pitch_y_um = 12.0) {
  System<double> s;
  s.frame = {100.0, pitch_x_um, pitch_y_um, 0.01, 0, 0};
  s.optics.f_number = 2.0;
  s.optics.wavelength_um = 4.0;
  return s;
}

inline System<double> with(System<double> system, std::initializer_list<Component<double>> presample) {
  for (const Component<double>& component : presample) system.add(Stage::presample, component);
  return system;
}

inline SampleGrid scene_grid(const System<double>& s, std::int64_t width, std::int64_t height, double ratio_x,
                             double ratio_y) {
  return {width, height, s.frame.pitch_x_um / ratio_x, s.frame.pitch_y_um / ratio_y};
}

/// value(column, row) at every sample.
template <class F>
Image image_of(std::int64_t width, std::int64_t height, F value) {
  Image image(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) image.at(x, y) = static_cast<float>(value(x, y));
  return image;
}

inline Image run(const Plan& plan, const Image& scene, double border_value = 0.0, int threads = 1) {
  Image out(plan.out().width, plan.out().height);
  plan.run(scene.view(), out.view(), border_value, threads);
  return out;
}

inline double rms_distance(const Image& image, const std::vector<double>& expected) {
  double squares = 0.0;
  for (std::int64_t i = 0; i < image.size(); ++i)
    squares += std::pow(image.data()[i] - expected[static_cast<std::size_t>(i)], 2);
  return std::sqrt(squares / static_cast<double>(image.size()));
}

inline bool all_finite(const Image& image) {
  for (std::int64_t i = 0; i < image.size(); ++i)
    if (!std::isfinite(image.data()[i])) return false;
  return true;
}

inline bool same_bits(const Image& a, const Image& b) {
  return a.width() == b.width() && a.height() == b.height() &&
         std::equal(a.data(), a.data() + a.size(), b.data(), [](float p, float q) { return p == q; });
}

/// Options for this very scene.
inline PlanOptions options_for(const Image& scene, Border border, double tolerance, double border_value = 0.0) {
  PlanOptions options;
  options.border = border;
  options.tolerance = tolerance;
  options.scene = summarise(scene.view(), border, border_value);
  options.threads = 1;
  return options;
}

/// The number after "use " in a refusal; -1 when there is none.
inline double named_tolerance(const std::string& message) {
  const auto at = message.find("use ");
  return at == std::string::npos ? -1.0 : std::strtod(message.c_str() + at + 4, nullptr);
}

}  // namespace mtf::test
