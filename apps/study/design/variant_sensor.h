// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sensor of a study for one choice on each of its discrete axes. Its numbers can be set: it holds the system with
// its band weighted by electrons, the spectra of the budget, and the place of each parameter of the study.

#include <string>
#include <vector>

#include "apps/sensor/sensor_chain.h"
#include "apps/study/study.h"
#include "radiometry/chain/sensor_budget.h"

namespace study {

struct VariantSensor {
  mtf::io::SensorConfig config;
  mtf::System<double> system;                ///< band with electron rate
  std::optional<apps::LoadedSensor> loaded;  ///< present for a sensor with [detector]
  std::string no_budget;                     ///< why there is none: "no [detector]", ...
  std::string no_ranges;                     ///< why its air cannot be followed along the range to a target
  std::string no_focus;                      ///< why a target at a range is not as sharp as the system has it
  double flicker_e = 0.0;
  radiometry::SpectralNumbers<double> spectral;  ///< without overrides
  std::vector<double> base;                      ///< value of each parameter, NaN where this sensor has no such number
  std::vector<std::string> problems;             ///< why no sensor file could hold this variant
};

/// Reads the variant, its curves and tables. Throws RuntimeError for files that cannot be read.
VariantSensor load_variant(const Study& study, std::span<const int> levels);

/// The study's surface and target behind a path, see radiometry/chain/sensor_budget.h.
radiometry::SpectralNumbers<double> spectral_numbers(const Conditions& conditions, const radiometry::Sensor& sensor,
                                                     const radiometry::Path& path,
                                                     const radiometry::Overrides<double>& numbers = {});

/// True where the light of a design falls over the image.
inline bool has_vignetting(const VariantSensor& variant) {
  return variant.loaded && variant.loaded->sensor.settings.vignetting;
}

/// True for a number of a table that a design may override; any other needs a variant of its own.
bool is_overridable(std::string_view path);

}  // namespace study
