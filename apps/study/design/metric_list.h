// SPDX-License-Identifier: Apache-2.0
#pragma once

// Every figure of merit that a study may ask for, by name. Definition and source go into each output.

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace study {

struct MetricInfo {
  std::string name;        ///< "mtf_nyquist_x"
  std::string unit;        ///< "cy/px", "mK"; "" for a plain number
  std::string definition;  ///< one sentence
  std::string source;      ///< where the definition comes from
  std::string needs;       ///< what a sensor or study has to hold for it: "", "[detector]", "[conditions] range"
};

/// All that have a fixed name.
std::span<const MetricInfo> metric_catalogue();

/// Finds a metric of the catalogue, or the MTF at a frequency: "mtf_at_20_cy_mm", "mtf_at_0.25_cy_px_y",
/// "mtf_at_5_cy_mrad_x"; each that an OTF changes also with .axis (as without), .mean or .worst: over the image.
std::optional<MetricInfo> find_metric(std::string_view name);

}  // namespace study
