// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sensor images as files: names of planes, provenance, and how values become whole numbers.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mtf/io/scene.h"
#include "mtf/plan/sensor_plan.h"

namespace apps {

/// Attributes of an output image (notes: prefix mtf:, units, pitch in m, ifov in rad, band edges in um, config hash,
/// tolerance and predicted error, history), with the wavelengths of the scene, and its place on the ground on the grid
/// of the output, of which `region` (x, y, width, height) is kept.
mtf::io::Metadata provenance(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene,
                             const mtf::SensorPlan& plan, double tolerance,
                             const std::optional<std::array<std::int64_t, 4>>& region = {});

/// One plane is "Y", three colour planes "R","G","B"; everything else keeps its full name.
std::vector<std::string> output_names(const std::vector<std::string>& names);

struct Written {
  std::optional<mtf::io::IntegerScaling> scaling;  ///< of PNG and TIFF
  std::int64_t clamped = 0;
};

/// Values at 0 and at the largest number of PNG and TIFF; without them the extremes of the image.
struct IntegerRange {
  std::optional<std::array<double, 2>> ends{};
  int bits = 16;
};

/// Writes by extension.
Written write_sensor_image(const std::string& path, const std::vector<std::string>& names,
                           const std::vector<mtf::Image>& planes, const mtf::io::Metadata& metadata,
                           const IntegerRange& range);

}  // namespace apps
