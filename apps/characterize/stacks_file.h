// SPDX-License-Identifier: Apache-2.0
#pragma once

// The file that describes stacks of flat frames (TOML, read as sensor files are):
//   schema = 1
//   nominal = "sensor.toml"         what frames do not tell; may be left out
//   [camera]
//   bits = 12                       of the converter; else those of the nominal
//   [[stack]]
//   frames = "dark/*.png"           PNG, TIFF, OpenEXR, one file a frame; or one NPY cube (frames, rows, columns)
//   exposure = "10 ms"
//   light = false
//   [[stack]]
//   frames = "bright/*.png"
//   exposure = "10 ms"
//   photons = 5200                  mean number at a pixel in an exposure; or irradiance = 0.02 (W/m^2, with [light]
//                                   wavelength), or relative = 3.0; none of them: the light is as the exposure
// Names of files are relative to the folder of this one. EMVA's descriptors give the same (emva_descriptor.h).

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace apps {

/// What the light of stacks is stated in, in the order in which words(LightUnit) names them.
enum class LightUnit { photons, irradiance, relative, exposure };

struct StackEntry {
  std::string name;                ///< as messages call it
  std::vector<std::string> files;  ///< in the order of their names
  double light = 0.0;              ///< in the unit of the file; of irradiance W/m^2; 0 in the dark
  double time_s = 0.0;
};

struct StacksFile {
  std::string file, sha256;
  std::string nominal{};  ///< "" for none
  std::optional<int> bits{};
  double step = 1.0;  ///< of stored values, in counts
  std::optional<double> full_well_e{};
  LightUnit unit = LightUnit::exposure;
  double repeatability = 0.0;
  std::optional<double> wavelength_um{};
  int nonlinearity = 0;
  std::vector<StackEntry> stacks{};
  bool has_times = true;  ///< every stack states its exposure
};

std::string_view name_of(LightUnit unit);

/// Throws RuntimeError where the file cannot be read, UsageError with every error as a "file:line:col: error: ..."
/// line.
StacksFile load_stacks(const std::string& file);

}  // namespace apps
