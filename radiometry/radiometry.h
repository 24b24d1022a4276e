// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public headers of radiometry; what is not named here is internal (mtf/mtf.h). Scenes, heat, weather and pictures
// need a build with scenes.

// Light of bodies and bands.
#include "radiometry/light/band_response.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/light/constants.h"
#include "radiometry/light/signal.h"
#include "radiometry/light/spectral_signal.h"
#include "radiometry/light/spectrum.h"

// The chain of a sensor and its noise.
#include "radiometry/chain/chain.h"
#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/sensor_settings.h"
#include "radiometry/output_stage.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/noise_3d.h"
#include "radiometry/stages/noise/poisson.h"
#include "radiometry/stages/processing/correction.h"

// What a sensor reaches.
#include "radiometry/performance/acquisition.h"
#include "radiometry/performance/giqe.h"
#include "radiometry/performance/mdtd.h"
#include "radiometry/performance/mrtd.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/performance/target_at_range.h"
#include "radiometry/performance/thermal_detector.h"
#include "radiometry/performance/ttp.h"

// The air.
#include "radiometry/atmosphere/air.h"
#include "radiometry/atmosphere/derivatives.h"
#include "radiometry/atmosphere/range_table.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "radiometry/atmosphere/spectral_path.h"

// Weather, sun and surface temperatures.
#include "radiometry/heat/convection.h"
#include "radiometry/heat/solve.h"
#include "radiometry/thermal/heat_scene.h"
#include "radiometry/thermal/run/heat_run.h"
#include "radiometry/thermal/thermal_scene.h"
#include "radiometry/weather/clear_sky.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather.h"
#include "radiometry/weather/weather_series.h"

// Scenes of facets and their pictures.
#include "radiometry/render/layers/layer_picture.h"
#include "radiometry/render/renderer.h"
#include "radiometry/scene/facets.h"
#include "radiometry/scene/mesh.h"
#include "radiometry/scene/rays.h"
#include "radiometry/scene/views.h"
