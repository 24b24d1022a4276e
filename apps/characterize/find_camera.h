// SPDX-License-Identifier: Apache-2.0
#pragma once

// From the file of stacks to the camera: what `mtf characterize` and mtfkit.characterize() of Python share.
//   StacksFile file = load_stacks("stacks.toml");
//   const FoundCamera found = find_camera(file, nominal_of(file, ...), read_stacks(file, ...), "sensor.toml", false);

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/characterize/camera_file.h"
#include "apps/characterize/stack_frames.h"
#include "calib/characterize/lag_step.h"

namespace apps {

/// Of frames whose light steps.
struct ReadLag {
  std::string name;
  double frame_time_s = 0.0;
  std::vector<double> means{};  ///< counts
};

/// The stacks of a file, reduced.
struct ReadStacks {
  std::vector<calib::Stack> stacks{};  ///< photons in place of irradiance
  std::optional<ReadLag> lag{};
  int bits = 0;  ///< of the converter
  calib::CharacterizeOptions how;
  std::vector<std::string> warnings{};
};

/// Offset + K e by the counts of the converter: linear in the light.
std::function<double(double)> linear_counts(const calib::PhotonTransfer& transfer);

/// The converter's bits: of the stacks' file, else of the nominal. Throws UsageError where neither has them.
int bits_of(const StacksFile& file, const std::optional<mtf::io::SensorConfig>& nominal);

/// What can be refused before a frame is read, by a check as by a run. Throws as shapes_of() and bits_of(), and
/// UsageError for light that does not go with the detector of the nominal.
std::vector<StackShapes> look_at_stacks(const StacksFile& file, const std::optional<mtf::io::SensorConfig>& nominal,
                                        int threads);

/// `progress`: the share of the files that was read; may be null. Throws as look_at_stacks() and read_stack().
ReadStacks read_stacks(const StacksFile& file, const std::optional<mtf::io::SensorConfig>& nominal, int threads,
                       const std::function<void(double)>& progress);

struct FoundCamera {
  calib::Characterization camera;
  CameraFile sensor;  ///< without text where frames make none: a photon detector before blackbodies
  std::string name;   ///< of the sensor
  int bits = 0;       ///< of the converter
  Json report;        ///< result.json
};

/// `destination`: of the sensor file, whose names of other files count from its folder. `maps`: it names the maps of
/// pattern_planes.h. Throws as calib::characterize() and characterize_blackbodies().
FoundCamera find_camera(const StacksFile& file, std::optional<mtf::io::SensorConfig> nominal, ReadStacks read,
                        const std::string& destination, bool maps);

}  // namespace apps
