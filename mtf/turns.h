// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sine and cosine of many whole and part turns at once, on whatever vectors the machine has.

#include <span>

namespace mtf {

/// sine[i] = sin(2 pi turns[i]), cosine[i] likewise, within 3e-16 for any |turns| up to 2^51; all of one size.
void sin_cos_turns(std::span<const double> turns, std::span<double> sine, std::span<double> cosine);

}  // namespace mtf
