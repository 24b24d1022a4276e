// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images of a live view, its scenes, and what two images differ by.

#include <gtest/gtest.h>

#include <cmath>

#include "apps/simulate/live_simulation.h"
#include "tests/apps/chain_sensor.h"

namespace apps_test {

using mtf::io::SensorConfig;

/// A ramp with detail: its ends differ, so the border shows.
inline Image ramp(double mean, double amplitude) {
  Image plane(64, 48);
  for (std::int64_t y = 0; y < plane.height(); ++y)
    for (std::int64_t x = 0; x < plane.width(); ++x)
      plane.at(x, y) = static_cast<float>(
          mean + amplitude * (static_cast<double>(x) / 64.0 + 0.3 * std::sin(0.7 * static_cast<double>(x * y % 31))));
  return plane;
}

/// Rms difference as a share of the standard deviation of `b`; infinite for images of two sizes.
inline double difference(const Image& a, const Image& b) {
  if (a.width() != b.width() || a.height() != b.height()) return INFINITY;
  const auto n = static_cast<double>(b.size());
  double sum = 0.0, squares = 0.0, mean = 0.0;
  for (std::int64_t i = 0; i < b.size(); ++i) mean += static_cast<double>(b.data()[i]) / n;
  for (std::int64_t i = 0; i < b.size(); ++i) {
    sum += std::pow(static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i]), 2.0);
    squares += std::pow(static_cast<double>(b.data()[i]) - mean, 2.0);
  }
  return std::sqrt(sum / squares);
}

/// Two plans that keep the default tolerance differ by twice that at most.
inline constexpr double kTwoPlans = 2e-4;

class LiveSimulation : public testing::Test {
 protected:
  SensorConfig sensor(const std::string& text) const {
    write_file(scratch / "s.toml", text);
    return apps::read_sensor_file((scratch / "s.toml").string());
  }
  SensorConfig camera(const std::string& more = "") const { return sensor(kSensor + more); }
  /// [scene] of the sensor says what its values are.
  apps::SceneSource file() const {
    mtf::io::write_exr((scratch / "scene.exr").string(), {{"Y", ramp(5.0, 1.0).view()}}, {});
    return {.file = (scratch / "scene.exr").string()};
  }
  static apps::SceneSource temperatures() {
    mtf::io::Scene scene;
    scene.quantity = mtf::io::Quantity::temperature;
    scene.planes.push_back(ramp(300.0, 5.0));
    return {.image = std::move(scene)};
  }
  static Image image(apps::LiveSimulation& live, const SensorConfig& sensor, std::int64_t frame = 0,
                     apps::CorrectionOf correction = apps::CorrectionOf::first_image) {
    return std::move(live.image(sensor, frame, correction).planes.at(0));
  }
  static Image alone(apps::SceneSource scene, const SensorConfig& sensor) {
    apps::LiveSimulation live(std::move(scene));
    return image(live, sensor);
  }
  static double tolerance_alone(apps::SceneSource scene, const SensorConfig& sensor) {
    apps::LiveSimulation live(std::move(scene));
    image(live, sensor);
    return live.plan().options.tolerance;
  }
  const Scratch scratch;
};

}  // namespace apps_test
