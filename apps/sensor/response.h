// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the weighted radiance of an image was weighted by: images that say it are taken by sensors with the same
// response and by no others.

#include <string>

#include "radiometry/light/spectral_signal.h"

namespace apps {

/// SHA-256 of the band, of what the detector answers to and of all curves, 64 hex digits. Plain numbers (f-number,
/// transmission, quantum efficiency) are no part of it: the camera equation takes them after the weighted radiance.
std::string response_sha256(const radiometry::SpectralCamera& curves);

}  // namespace apps
