// SPDX-License-Identifier: Apache-2.0
#pragma once

// The file that describes stacks of flat frames (TOML, read as sensor files are); apps/README.md, "A camera from its
// own frames", has every key. Names of files are relative to the folder of this one. EMVA's descriptors give the same
// (emva_descriptor.h).

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/image.h"

namespace apps {

/// What the light of stacks is stated in, in the order in which words(LightUnit) names them.
enum class LightUnit { photons, irradiance, temperature, radiance, relative, exposure };

/// What is known of blackbodies.
struct Blackbodies {
  double temperature_sd_k = 0.0;  ///< of each, independent of the others
  double emissivity = 1.0, emissivity_sd = 0.0;
  double surroundings_k = 295.0;        ///< that they reflect
  std::optional<double> reference_k{};  ///< of the kelvin in SiTF
};

/// How the counts of a file lie that has no header to say it.
struct RawLayout {
  std::uint64_t width = 0, height = 0;
  std::uint64_t columns = 0;  ///< of a row, with those that fill it up
  std::string type;           ///< as mtf::io::NpyReader has it
  std::uint64_t header = 0;   ///< bytes before the first frame
};

struct StackEntry {
  std::string name;                                   ///< as messages call it
  std::vector<std::string> files;                     ///< in the order of their names
  std::vector<mtf::ImageView<const float>> memory{};  ///< in place of files
  std::optional<RawLayout> raw{};
  double light = 0.0;  ///< in the unit of the file; of irradiance W/m^2, of blackbodies K or radiance; 0 in the dark
  double time_s = 0.0;
  double step_s = 0.0;  ///< from frame to frame, where the light steps; else 0
};

struct StacksFile {
  std::string file, sha256;
  std::string nominal{}, nominal_sha256{};  ///< "" for none; the hash is of what was read of it
  std::optional<int> bits{};
  std::array<std::int64_t, 2> size{};  ///< columns and rows; 0 where the file does not say
  double step = 1.0;                   ///< of stored values, in counts
  std::optional<double> full_well_e{};
  LightUnit unit = LightUnit::exposure;
  double repeatability = 0.0;
  std::optional<double> wavelength_um{};
  Blackbodies blackbodies{};
  int nonlinearity = 0, trend = 2;
  std::vector<StackEntry> stacks{};
  bool has_times = true;  ///< every stack states its exposure

  bool tells_photons() const { return unit == LightUnit::photons || unit == LightUnit::irradiance; }
  bool has_blackbodies() const { return unit == LightUnit::temperature || unit == LightUnit::radiance; }
};

std::string_view name_of(LightUnit unit);

/// Frames that lie in memory, by the names that stand for them under `frames`.
using FramesInMemory = std::map<std::string, std::vector<mtf::ImageView<const float>>>;

/// `file`: where the text is from, by whose folder it names files. Throws UsageError with every error as a
/// "file:line:col: error: ..." line.
StacksFile parse_stacks(const std::string& text, const std::string& file, const FramesInMemory& memory = {});
/// The same, of EMVA's descriptors too; RuntimeError where the file cannot be read.
StacksFile load_stacks(const std::string& file);

}  // namespace apps
