// SPDX-License-Identifier: Apache-2.0
#pragma once

// Curves of the wavelength that stop inside the band, beyond which they count as 0 (spectrum.h).

#include <span>
#include <string>

#include "radiometry/light/spectrum.h"

namespace radiometry {

/// The part of the band that curves leave open: up to where one has come down to nearly 0, below 1 % of its largest
/// value, and not to where one merely stops.
Interval open_range(const Interval& band, std::span<const Spectrum> factors);
/// A sentence that says which part of the open range counts as 0 because the curve stops inside it before it has come
/// down to nearly 0; "" where none does.
std::string missing_words(const Spectrum& curve, const Interval& open);

}  // namespace radiometry
