// SPDX-License-Identifier: Apache-2.0
#pragma once

// 1/f noise of every pixel from frame to frame.
//   S(f) = K/f from `lowest` to `highest`, one-sided, f in cycles per frame; variance K ln(highest/lowest)
// A frame is a sample of it: what lies above half a cycle per frame is folded and looks white. It is a sum over octaves
// i = 1, 2, ... of random numbers 2^i frames apart, joined by the two quarters of a cosine, which keep the variance the
// same in every frame, and of numbers that are new in every frame, which have the rest of the variance (after Voss;
// Gardner, Scientific American 238 (4), 16 (1978)). With K ln 2 in an octave, 1.48 (`highest` of 2 and more) to 1.72
// (1/2) times that in the first and a part in the last, the folded spectrum is kept within 3 % from 5 times `lowest` to
// 0.02 cycles per frame and, from 2 on, 7 % up to the Nyquist frequency; for 1/2 within 9 % up to 1/4 and 32 % above,
// but in each octave within 2.5 % from 15 times `lowest` on; between 1/2 and 2 within 16 % up to 1/4 and 31 % above.
// Below `lowest` it is flat. A number is that of its pixel and frame, by any region, order or number of threads.

#include <cmath>
#include <numbers>

#include "radiometry/fields.h"
#include "radiometry/stages/noise/noise.h"

namespace radiometry {

struct FrameFlicker {
  double strength = 0.0;               ///< K, the square of the unit of the image
  double lowest = 0.0, highest = 0.0;  ///< cycles per frame
};

/// That of a photon detector, as a sensor file has it: by octaves, up to half a cycle per frame.
struct FlickerOctaves {
  double octave_e = 0.0, lowest_cy_frame = 1e-4;

  static constexpr auto fields() {
    return std::tuple{optional(&FlickerOctaves::octave_e, "octave", "e-", 0.0, 1e15, "\"2 e-\"",
                               "rms of the noise in each octave of frequencies, up to half a cycle per frame"),
                      optional(&FlickerOctaves::lowest_cy_frame, "lowest", 1e-9, 0.25, "0.0001",
                               "frequency in cycles per frame below which the spectrum is flat")};
  }

  double octaves() const { return std::log2(0.5 / lowest_cy_frame); }
  FrameFlicker noise() const { return {octave_e * octave_e / std::numbers::ln2, lowest_cy_frame, 0.5}; }
};

double frame_flicker_variance(const FrameFlicker& noise);

/// Variance of the mean of that many successive frames.
double frame_flicker_mean_variance(const FrameFlicker& noise, int frames);

/// Two-sided density in squares of the unit per (cycle per frame), by the sum above; f from 0 to 1/2.
double frame_flicker_density(const FrameFlicker& noise, double f_cy_frame);

/// Adds that of the frame in `key` to a region of the detector, to rows as add_gaussian. Throws UsageError for a
/// strength below 0 and for frequencies that are not 0 < lowest < highest.
void add_frame_flicker(mtf::ImageView<float> image, const FrameFlicker& noise, const NoiseKey& key, Origin origin = {},
                       int threads = 1, std::int64_t every = 1);

}  // namespace radiometry
