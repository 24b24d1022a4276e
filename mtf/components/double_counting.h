// SPDX-License-Identifier: Apache-2.0
#pragma once

// Combinations of components that count the same physics twice. Warnings, not errors: such a pair can be meant, each
// with its own share of the effect.

#include <array>
#include <string_view>

namespace mtf {

/// A component of `one` beside a component of `other`; where `other` is empty, any two of `one`. Kinds, or
/// "kind:word" for a kind with that word chosen in one of its fields.
struct DoubleCounting {
  std::array<std::string_view, 3> one;
  std::array<std::string_view, 3> other;
  std::string_view why;  ///< the reason and the remedy
};

inline constexpr std::array kDoubleCounting{
    DoubleCounting{{"diffusion"},
                   {"crosstalk"},
                   "a measured crosstalk holds the diffusion already and counts it twice; leave one out unless this "
                   "one is capacitance alone"},
    DoubleCounting{{"footprint", "circular_footprint", "polygon_footprint"},
                   {},
                   "a pixel has one footprint, counted twice here; keep one, or sum several pixels with binning"},
    DoubleCounting{{"defocus", "wavefront"},
                   {"rms_wavefront", "random_wavefront"},
                   "the rms holds the aberrations given by coefficients and counts them twice; leave one out unless "
                   "the rms is what the coefficients leave over"},
    DoubleCounting{{"rms_wavefront"},
                   {"random_wavefront"},
                   "two statistics of one wavefront error count it twice; leave one out unless each has its own share"},
    DoubleCounting{
        {"turbulence"}, {}, "a path has one turbulence, counted twice here; give the whole path to one of them"},
    DoubleCounting{
        {"aerosol"},
        {},
        "a path scatters once, counted twice here; give its whole optical depth to one, as contrast or as blur"},
    DoubleCounting{{"diffusion"}, {}, "a detector has one diffusion, counted twice here; keep one"},
    DoubleCounting{{"linear_motion"},
                   {"accelerated_motion"},
                   "the velocity of the accelerated motion is a linear motion, counted twice; leave one out unless "
                   "they are two movements"},
    DoubleCounting{{"interpolation:nearest"},
                   {"sample_and_hold"},
                   "an image enlarged by repetition is held already and counts it twice; leave one out"},
};

}  // namespace mtf
