// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene's values, whatever they stand for, as the weighted photon radiance that passes through a chain
// (radiometry/light/scene_radiance.h).

#include <string>

#include "apps/sensor/sensor_chain.h"
#include "apps/simulate/scene_source.h"
#include "mtf/io/scene.h"

namespace apps {

/// The planes of `scene` become the one of its radiance; returns what a constant border is worth in that unit.
/// `source`: of the channels of emissivity and depth that [scene] names. Throws UsageError for a scene of several
/// channels that are no spectrum, and for values that cannot be (how many, and the first one).
double to_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, mtf::io::Scene& scene,
                const SceneSource& source, int threads);

}  // namespace apps
