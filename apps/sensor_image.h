// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sensor images as files: names of planes, provenance, and the scaling of 16-bit formats.

#include <optional>
#include <string>
#include <vector>

#include "mtf/io/scene.h"
#include "mtf/sensor_plan.h"

namespace apps {

/// Attributes of an output image (notes: prefix mtf:, units, pitch in m, ifov in rad, band edges in um, config hash,
/// tolerance and predicted error, history).
mtf::io::Metadata provenance(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene,
                             const mtf::SensorPlan& plan, double tolerance);

/// One plane is "Y", three colour planes "R","G","B"; everything else keeps its full name.
std::vector<std::string> output_names(const std::vector<std::string>& names);

struct Written {
  std::optional<mtf::io::IntegerScaling> scaling;  ///< of 16-bit formats
  std::int64_t clamped = 0;
};

/// Writes by extension. 16-bit formats map [low, high] (default: the extremes of the image) to 0..65535.
Written write_sensor_image(const std::string& path, const std::vector<std::string>& names,
                           const std::vector<mtf::Image>& planes, const mtf::io::Metadata& metadata,
                           std::optional<double> low, std::optional<double> high);

}  // namespace apps
