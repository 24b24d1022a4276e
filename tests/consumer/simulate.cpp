// SPDX-License-Identifier: Apache-2.0

// A sensor file and a scene in memory through the installed pipeline: a uniform scene comes out as it went in. The OTF
// of the sensor, by component.

#include <cmath>
#include <cstdio>
#include <fstream>

#include "apps/sensor/otf_curves.h"
#include "apps/simulate/live_simulation.h"
#include "apps/simulate/simulate.h"
#include "mtf/io/config/config.h"

int main() {
  std::ofstream("consumer_sensor.toml") << mtf::io::starter_config();
  const mtf::io::SensorConfig sensor = apps::read_sensor_file("consumer_sensor.toml");

  const apps::OtfCurves curves = apps::otf_curves(sensor.system, {0.0, 20.0});
  for (const apps::TableColumn& column : apps::table_of(curves))
    std::printf("%s %g\n", column.name.c_str(), column.values[1]);
  if (curves.components.size() != 3 || !(curves.system.otf[1].re < curves.components[0].otf[1].re)) return 1;

  mtf::io::Scene scene;
  scene.quantity = mtf::io::Quantity::radiance;
  mtf::Image& plane = scene.planes.emplace_back(256, 256);
  for (std::int64_t i = 0; i < plane.size(); ++i) plane.data()[i] = 3.5F;
  apps::SceneSource source{.image = std::move(scene)};

  const apps::SimulateResult result = apps::simulate(sensor, apps::clone(source));
  const mtf::Image& image = result.images.at(0).planes.at(0);
  apps::LiveSimulation live(std::move(source));
  const mtf::Image again = std::move(live.image(sensor).planes.at(0));
  std::printf("%s [%s]\n", result.report.quantity().c_str(), result.report.unit().c_str());
  return std::abs(image.at(7, 7) - 3.5F) < 1e-4F && std::abs(again.at(7, 7) - 3.5F) < 1e-4F ? 0 : 1;
}
