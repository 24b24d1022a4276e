// SPDX-License-Identifier: Apache-2.0
#pragma once

// The text files of the demo scene, beside vehicle.obj (groups firing_part, driving_part, power_top, others) and
// terrain.obj: the scene file, its weather and the schedule of the engine bay. The materials are typical values of the
// literature, named in the file.

#include <string>

namespace apps::scene {

/// scene.toml. It names vehicle.obj, terrain.obj, weather.csv, engine.csv.
std::string demo_scene_text();
/// weather.csv: the clear days of demo_weather.h over the time of the scene.
std::string demo_weather_text();
/// engine.csv: temperature of the air in the engine bay, two runs a day.
std::string demo_engine_text();

}  // namespace apps::scene
