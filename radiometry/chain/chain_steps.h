// SPDX-License-Identifier: Apache-2.0
#pragma once

// What each stage of the chain does to a frame. Every step takes the frame in the quantity that the step before left:
// radiance to the end of the optics, electrons from collect() to the converter, counts after it.

#include "radiometry/chain/chain_impl.h"

namespace radiometry::step {

void distort(FrameRun& run, mtf::Image& scene);
void sample(FrameRun& run, mtf::Image& scene);  ///< presample OTF, then one sample a pixel or position
void glare(FrameRun& run, mtf::Image& radiance);
void ghost(FrameRun& run, mtf::Image& radiance);

void shutter(FrameRun& run, mtf::Image& radiance);
/// Radiance to mean electrons: cone of light, vignetting, warm optics, stop, narcissus, responsivity and dark current
/// are one factor and one term of each pixel.
void collect(FrameRun& run, mtf::Image& image);
void lag(FrameRun& run, mtf::Image& electrons);
void shutter_offset(FrameRun& run, mtf::Image& volts);
void defects(FrameRun& run, mtf::Image& electrons);
void blinking(FrameRun& run, mtf::Image& electrons);
void shot_noise(FrameRun& run, mtf::Image& electrons);
void full_well(FrameRun& run, mtf::Image& electrons);
void blooming(FrameRun& run, mtf::Image& electrons);
void nonlinearity(FrameRun& run, mtf::Image& electrons);
void readout(FrameRun& run, mtf::Image& electrons);
void offsets(FrameRun& run, mtf::Image& electrons);
void read_noise(FrameRun& run, mtf::Image& electrons);
void flicker(FrameRun& run, mtf::Image& electrons);
void line_noise(FrameRun& run, mtf::Image& electrons);
void noise_3d(FrameRun& run, mtf::Image& electrons);

void convert(FrameRun& run, mtf::Image& electrons);
void correct(FrameRun& run, mtf::Image& counts);
void postsample(FrameRun& run, mtf::Image& image);
void agc(FrameRun& run, mtf::Image& image);

}  // namespace radiometry::step
