// SPDX-License-Identifier: Apache-2.0
#include "apps/demo/demo_edge.h"

#include <cmath>
#include <numbers>
#include <random>

#include "mtf/engines/statistics.h"
#include "mtf/io/scene.h"
#include "mtf/plan/sensor_plan.h"

namespace apps {
namespace {

constexpr std::int64_t kPixels = 128, kMargin = 16, kRatio = 8;
constexpr double kAngle_deg = -5.0, kDark = 2.0, kBright = 8.0;
constexpr float kNoise = 0.03F;  // 200 times less than the contrast
/// Of the scene's blur, in its samples: what lies beyond their Nyquist frequency and aliases below the optics' cutoff
/// is 1e-5 and less.
constexpr double kSigma_samples = 1.0;

mtf::Image step_scene(std::int64_t size) {
  const double a = kAngle_deg * std::numbers::pi / 180.0;
  const double nx = std::cos(a), ny = std::sin(a), middle = 0.5 * static_cast<double>(size);
  mtf::Image scene(size, size);
  for (std::int64_t y = 0; y < size; ++y)
    for (std::int64_t x = 0; x < size; ++x) {
      const double d = nx * (static_cast<double>(x) + 0.5 - middle) + ny * (static_cast<double>(y) + 0.5 - middle);
      const double share = 0.5 * std::erfc(-d / (kSigma_samples * std::numbers::sqrt2));
      scene.at(x, y) = static_cast<float>(kDark + (kBright - kDark) * share);
    }
  return scene;
}

}  // namespace

mtf::Image demo_edge(const mtf::io::SensorConfig& sensor, int threads) {
  const std::int64_t size = (kPixels + 2 * kMargin) * kRatio;
  const mtf::Image scene = step_scene(size);
  const double step_um = sensor.system.frame.pitch_x_um / static_cast<double>(kRatio);
  const mtf::SampleGrid grid{size, size, step_um, step_um};

  mtf::io::SceneDefaults blurred = sensor.scene;
  blurred.aperture = mtf::io::Aperture::gaussian;
  blurred.aperture_size.x = {kSigma_samples * step_um, mtf::find_unit("um")};
  mtf::PlanOptions options;
  options.threads = threads;
  options.border = mtf::Border::reflect;
  options.aperture = mtf::io::scene_aperture(blurred, grid);
  options.scene = mtf::summarise(scene.view(), options.border, 0.0);
  const mtf::SensorPlan plan = mtf::compile_sensor(sensor.system, grid, options);
  const mtf::ImageView<const float> view = scene.view();
  const mtf::Image whole = std::move(plan.run(std::span(&view, 1), 0.0, threads).front());

  mtf::Image edge(kPixels, kPixels);
  std::mt19937_64 random(1);
  std::normal_distribution<float> noise(0.0F, kNoise);
  for (std::int64_t y = 0; y < kPixels; ++y)
    for (std::int64_t x = 0; x < kPixels; ++x) edge.at(x, y) = whole.at(x + kMargin, y + kMargin) + noise(random);
  return edge;
}

std::string demo_fit_config(const mtf::io::SensorConfig& sensor) {
  mtf::io::SensorConfig start = sensor;
  auto& list = start.system.list(mtf::Stage::presample);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].component.kind() != "jitter") continue;
    for (const mtf::FieldRef<double>& field : list[i].component.fields()) {
      if (field.info->name != "rms") continue;
      mtf::Extent<double>& rms = std::get<mtf::AxisPair<double>*>(field.value)->x;
      rms.value *= 2.0;  // a guess, as of a sensor that nobody has measured
      start.fits.push_back({.path = "presample[" + std::to_string(i) + "].rms",
                            .fit = true,
                            .unit = std::string(rms.unit->name),
                            .min = 0.0,
                            .max = 5.0 * rms.value,
                            .stderr_value = {},
                            .prior = {}});
    }
  }
  return write_config(start);
}

}  // namespace apps
