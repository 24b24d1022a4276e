// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stacks of blackbodies: their radiance in the band of the nominal, by the integrals that `mtf budget` takes, and the
// thermal camera that they make as a sensor file. The blackbodies fill the field before the lens: [path] and
// [atmosphere] of the nominal have no part in it.

#include "apps/characterize/camera_file.h"
#include "apps/figures/plot.h"
#include "calib/characterize/thermal.h"

namespace apps {

/// How blackbodies are seen by the nominal.
struct SeenBlackbodies {
  calib::ThermalOptions how{};
  std::string reference{};  ///< whose temperature the kelvin are at
  double coolest_k = 0.0, hottest_k = 0.0;
};

/// `light` of the stacks, that of the file, K or W m^-2 sr^-1, becomes the radiance in the band. Kelvin are those at
/// reference_temperature, else at the nominal's netd_temperature, else at the coolest blackbody.
SeenBlackbodies see_blackbodies(std::vector<calib::Stack>& stacks, const StacksFile& file,
                                const mtf::io::SensorConfig& nominal);

/// Throws UsageError as calib::characterize_thermal().
calib::Characterization characterize_blackbodies(std::vector<calib::Stack> stacks, const SeenBlackbodies& seen);

/// Whether the nominal has a thermal detector.
bool is_thermal(const mtf::io::SensorConfig& nominal);

/// The nominal with SiTF as counts_per_kelvin, offset, NETD of the camera (white noise of pixels alone) and the other
/// components of 3-D noise; what the nominal had for them is taken out. `netd_transmission` is such that all kelvin
/// are those of the camera as it stands. MRTD and MDTD that `mtf budget` predicts of it join the findings. Of a photon
/// detector there is no text: blackbodies do not part its gain from its light.
CameraFile thermal_camera_file(calib::Characterization& camera, const StacksFile& stacks, mtf::io::SensorConfig nominal,
                               int bits, const std::string& destination);

/// The curves of `mtf budget --curves` of the file `twin` at `destination`, for the reference temperature; none where
/// MRTD is not predicted.
std::vector<Figure> predicted_figures(const calib::Characterization& camera, const std::string& twin,
                                      const std::string& destination);

}  // namespace apps
