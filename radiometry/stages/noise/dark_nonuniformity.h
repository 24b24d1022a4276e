// SPDX-License-Identifier: Apache-2.0
#pragma once

// Dark current that differs from pixel to pixel (DCNU): the mean dark current times a factor of each pixel, the same in
// all frames,
//   f = exp(s z - s^2 / 2),   s^2 = ln(1 + rms^2),   z standard normal
// log-normal with mean 1 and standard deviation rms exactly, never below 0: a rate that falls exponentially with an
// energy that scatters normally. So it has the tail of warm pixels that detectors have, and unlike an offset (DSNU) it
// grows with the exposure time and with everything that raises the dark current. Each pixel has the shot noise of its
// own dark charge. Silicon has rms of 0.1 to 0.4. (Janesick, Photon Transfer, 2007, on dark current; Gow et al., IEEE
// Trans. Electron Devices 54, 1321 (2007).)

#include <algorithm>
#include <cmath>
#include <span>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/stages/noise/noise.h"

namespace radiometry {

/// The factors of a region. Throws UsageError for rms that is not from 0 to 10, and for an origin out of its range.
inline void dark_current_map(mtf::ImageView<float> map, double rms, std::uint64_t seed, Origin origin = {},
                             int threads = 1) {
  if (!(rms >= 0.0 && rms <= 10.0))
    throw mtf::UsageError("dark-current non-uniformity of " + mtf::format_double(rms) +
                          " rms; it has to be from 0 to 10");
  const double s2 = std::log1p(rms * rms);
  for (std::int64_t y = 0; y < map.height; ++y) std::fill_n(map.row(y), map.width, 0.0F);
  add_gaussian(map, std::sqrt(s2), {seed, 0}, Stream::dcnu, origin, threads);
  for (std::int64_t y = 0; y < map.height; ++y)
    for (float& value : std::span(map.row(y), static_cast<std::size_t>(map.width)))
      value = static_cast<float>(std::exp(static_cast<double>(value) - 0.5 * s2));
}

}  // namespace radiometry
