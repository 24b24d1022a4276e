// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/number_words.h"

#include <algorithm>
#include <array>

namespace apps {
namespace {

struct NumberWords {
  std::string_view name, words;
};

constexpr std::string_view kResponse =
    "Nonlinearity: of e electrons, e (1 + a2 u + a3 u^2 + a4 u^3) are read, with u = e / full well.";
constexpr std::array kNumbers{
    NumberWords{"electrons_per_count",
                "Electrons that raise the value of a pixel by one count: the inverse of the gain."},
    NumberWords{"offset", "Value of a pixel without light."},
    NumberWords{"read_noise", "Temporal noise of a pixel without light and dark current, rms."},
    NumberWords{"rate",
                "Electrons for a unit of light as the stacks state it; of photons at a pixel, quantum efficiency and "
                "transmission together."},
    NumberWords{"a2", kResponse},
    NumberWords{"a3", kResponse},
    NumberWords{"a4", kResponse},
    NumberWords{"dark_current", "Electrons that a pixel collects in a second without light."},
    NumberWords{"dcnu", "Dark-current nonuniformity: relative rms of the dark currents of pixels."},
    NumberWords{"crosstalk_side", "Part of a pixel's charge that each of its four nearest neighbours reads."},
    NumberWords{"crosstalk_corner", "Part of a pixel's charge that each of its four diagonal neighbours reads."},
    NumberWords{"light_flicker",
                "Relative rms of the light from frame to frame, which counts in the errors of the means."},
    NumberWords{"row_noise", "Noise that the pixels of a row share and that changes from frame to frame, rms."},
    NumberWords{"column_noise", "Noise that the pixels of a column share and that changes from frame to frame, rms."},
    NumberWords{"frame_noise", "Noise that all pixels of a frame share, rms."},
    NumberWords{"dsnu",
                "Dark signal nonuniformity: rms of the fixed offsets of pixels, less rows, columns and defects."},
    NumberWords{"fixed_row", "Rms of the fixed offsets of rows in the dark."},
    NumberWords{"fixed_column", "Rms of the fixed offsets of columns in the dark."},
    NumberWords{"prnu",
                "Photoresponse nonuniformity: relative rms of the responses of pixels to light, less rows, columns, "
                "shading and defects."},
    NumberWords{"prnu_row", "Relative rms of the responses of rows."},
    NumberWords{"prnu_column", "Relative rms of the responses of columns."},
    NumberWords{"shading",
                "Relative rms of what changes smoothly over the bright frame: of the light, the optics or the "
                "responses, which frames do not tell apart."},
    NumberWords{"frame_correlation",
                "Correlation of a pixel's noise in successive frames: 0 where frames are independent, more with 1/f "
                "noise, lag or a filter over frames."},
    NumberWords{"noisy_pixels", "Part of the pixels that are noisier than the noise of the others makes any."},
    NumberWords{"hot_fraction", "Part of the pixels that have more dark signal than the pattern of the others makes."},
    NumberWords{"hot_excess", "Mean of the signal that hot pixels have more, of an exponential distribution."},
    NumberWords{"dead_fraction", "Part of the pixels whose response is below half of that of the others."},
    NumberWords{"blinking_fraction", "Part of the pixels that blink: whose dark signal changes between two levels."},
    NumberWords{"blinking_excess",
                "Mean of the difference of the levels of blinking pixels, of an exponential distribution."},
    NumberWords{"blinking_dwell", "Mean time that a blinking pixel stays at a level."},
    NumberWords{"flicker_octave", "Noise of a pixel that is 1/f from frame to frame: rms in each octave of frequency."},
    NumberWords{"flicker_corner", "Frequency, in cycles per frame, at which 1/f noise has the power of white noise."},
    NumberWords{"lag_share", "Part of a step of the light by which the first frame after it falls short."},
    NumberWords{"lag_time_constant", "Time in which what is left of a step falls to 1/e."},
    NumberWords{"sitf", "Signal transfer function: counts for a kelvin of a blackbody at the reference temperature."},
    NumberWords{"netd", "Noise equivalent temperature difference: temporal noise of pixels (tvh) over SiTF."},
    NumberWords{"noise_tvh", "Noise of pixels, from frame to frame (tvh)."},
    NumberWords{"noise_tv", "Noise of rows, from frame to frame (tv)."},
    NumberWords{"noise_th", "Noise of columns, from frame to frame (th)."},
    NumberWords{"noise_t", "Noise of whole frames (t)."},
    NumberWords{"noise_vh", "Noise of pixels, fixed (vh)."},
    NumberWords{"noise_v", "Noise of rows, fixed (v)."},
    NumberWords{"noise_h", "Noise of columns, fixed (h)."},
    NumberWords{"mrtd", "Temperature difference at which an observer just resolves four bars in the picture."},
    NumberWords{"mdtd", "Temperature difference at which an observer just detects a square in the picture."},
    NumberWords{"transmission", "Part of the light that the optics let through."},
    NumberWords{"absorptance", "Part of the light at a pixel that it absorbs."},
    NumberWords{"f_number", "Focal length over the diameter of the entrance pupil."},
    NumberWords{"fill_factor", "Part of a pixel's area that takes light."},
};

}  // namespace

std::string_view number_words(std::string_view name) {
  const auto found = std::ranges::find(kNumbers, name, &NumberWords::name);
  return found == kNumbers.end() ? std::string_view() : found->words;
}

}  // namespace apps
