// SPDX-License-Identifier: Apache-2.0
#pragma once

// A camera of twelve OTF components with a detector, and every metric of resolution and sensitivity: what speed and
// derivatives are measured on.

#include <string>

namespace study_test {

/// `monochromatic`: the optics have a wavelength of their own, the band is for the detector alone.
inline std::string satellite(bool monochromatic) {
  const std::string own = monochromatic ? "wavelength = \"0.6 um\"\n" : "";
  return R"(schema = 1
name = "satellite camera"
[frame]
focal_length = "4 m"
pitch = "8 um"
format = [4096, 512]
integration_time = "1 ms"
[scene]
emissivity = 2.1e-6  # the sun's light on the ground: as in notebooks-data/studies/satellite.toml
[optics]
f_number = 12.0
transmission = 0.8
[band]
wavelength = ["0.45 um", "0.85 um"]
[detector]
quantum_efficiency = 0.6
full_well = "90000 e-"
read_noise = "25 e-"
dark_current = "1000 e-/s"
[adc]
bits = 12
[[presample]]
kind = "diffraction"
)" + own +
         R"([[presample]]
kind = "rms_wavefront"
rms = 0.05
)" + own +
         R"([[presample]]
kind = "turbulence"
fried_parameter = "100 mm"
)" + own +
         R"([[presample]]
kind = "gaussian"
sigma = "1 um"
[[presample]]
kind = "jitter"
rms = "0.2 urad"
[[presample]]
kind = "linear_motion"
travel = "2 um"
direction = "0 deg"
[[presample]]
kind = "footprint"
width = "8 um"
[[presample]]
kind = "diffusion"
diffusion_length = "5 um"
absorption_length = "10 um"
depletion_depth = "5 um"
[[presample]]
kind = "tdi"
stages = 32
slip = "0.02 um"
[[presample]]
kind = "crosstalk"
side = 0.005
[[readout]]
kind = "charge_transfer"
transfers = 1000
inefficiency = 1e-5
[[postsample]]
kind = "boost"
gain = 1.2
peak = "0.5 cy/px"
)";
}

/// Sobol designs over five numbers; all metrics but the range models.
inline std::string satellite_study(int points, const std::string& tolerance) {
  return "schema = 1\nname = \"satellite\"\nsensor = \"satellite.toml\"\nseed = 1\ntolerance = " + tolerance + R"(
constraints = ["mtf_nyquist > 0.01", "focal_length <= 5 m"]
objectives = ["maximize niirs_giqe5", "minimize f_number * pitch"]
[[axis]]
parameter = "frame.pitch"
from = "5 um"
to = "15 um"
count = 100
[[axis]]
parameter = "optics.f_number"
from = 8.0
to = 16.0
count = 100
[[axis]]
parameter = "jitter.rms"
from = "0.05 urad"
to = "0.5 urad"
count = 10
[[axis]]
parameter = "frame.integration_time"
from = "0.5 ms"
to = "2 ms"
count = 10
[[axis]]
parameter = "detector.read_noise"
from = "10 e-"
to = "50 e-"
count = 3
[sampling]
method = "sobol"
points = )" +
         std::to_string(points) + R"(
[metrics]
list = ["cutoff", "nyquist", "q", "ifov", "gsd", "fov", "optics_mtf_nyquist", "detector_mtf_nyquist", "mtf_nyquist",
        "mtf_at_20_cy_mm", "folded_mtf_nyquist", "mtf50", "mtfa", "rer", "edge_overshoot", "fwhm", "aliasing_ratio",
        "spurious_in_band", "strehl", "ensquared_energy", "signal", "background", "well_fill", "scene_shot_noise",
        "dark_shot_noise", "read_noise", "quantisation_noise", "temporal_noise", "snr", "netd", "nei", "dynamic_range",
        "niirs_giqe3", "niirs_giqe4", "niirs_giqe5"]
[conditions]
temperature = "5800 K"
range = "500 km"
signal_contrast = 0.5
)";
}

}  // namespace study_test
