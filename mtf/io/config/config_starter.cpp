// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config.h"

namespace mtf::io {

std::string starter_config() {
  return R"toml(# A mid-wave infrared staring camera. Change the numbers, then run: mtf config check FILE
# Lengths, angles and times are strings with a unit ("15 um", "8 urad", "10 ms"); ratios are plain numbers.
schema = 2
name = "MWIR staring 640x512"

# The geometry: it converts between object angles, the focal plane and pixels. It adds no blur of its own.
[frame]
focal_length = "100 mm"
pitch = "15 um"               # centre to centre; pitch_x and pitch_y when pixels are not square
format = [640, 512]           # columns, rows: at most these; without it all whole pixels that the scene holds
integration_time = "10 ms"    # needed where something moves, and by [detector]

# Scenes: what an image file does not say itself.
[scene]
sample = "3.75 um"            # spacing of its samples at the focal plane; or ifov = "37.5 urad"; or gsd and range
quantity = "radiance"         # W/(m^2 sr) in band; photon_radiance, spectral_radiance, temperature (K) or counts
# gain = 1.0                  # value = gain x file + offset: required for PNG and TIFF of whole numbers
# offset = 0.0
# encoding = "linear"         # where a PNG or TIFF states a curve: linear (none is undone), srgb, gamma:2.2 or a CSV file
border = "reflect"            # beyond the edge: reflect, replicate, constant (with border_value) or periodic
aperture = "point"            # blur already in the samples, to be divided out: point (none), box, gaussian or curve

# Defaults of every component that has the key; a component's own value wins.
[optics]
f_number = 2.0                # or aperture = "50 mm"
wavelength = "4.0 um"         # one wavelength; remove it when there is a [band]
# obscuration = 0.3           # inner / outer diameter of an annular pupil

# A spectral band instead of the one wavelength: diffraction is then averaged over it.
# [band]
# wavelength = ["3.4 um", "4.8 um"]

# What blurs the scene before it is sampled, in any order. The system is exactly the product of what is listed here;
# `mtf config kinds` lists every kind with its parameters.
[[presample]]
kind = "diffraction"          # takes f_number and wavelength from [optics]

[[presample]]
kind = "footprint"            # the light-sensitive area of a pixel
width = "15 um"               # or fill_factor = 0.9

[[presample]]
kind = "jitter"               # random line-of-sight motion
rms = "2 um"                  # one axis, one sigma; or an angle such as "20 urad"
# rms = { value = "2 um", fit = true, min = "0 um", max = "10 um" }     # to have it fitted to measured edges

# What acts on collected charge while it is read out: [[readout]], such as rc_lowpass with its cutoff and axis.

# Digital filters on the sampled image. This one sharpens; its taps sum to 1.
# [[postsample]]
# kind = "fir"
# taps = [[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]

# From radiance to electrons, noise and NETD (mtf budget): needs [band] above, in place of the one wavelength.
# `mtf config kinds detector` lists the keys; further tables are noise, adc, path, correction and others.
# [detector]
# quantum_efficiency = 0.75
# full_well = "20 Me-"
# read_noise = "500 e-"
# [noise]                     # images have noise only with this table; the budget counts it in any case
# seed = 1
)toml";
}

}  // namespace mtf::io
