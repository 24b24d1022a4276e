// SPDX-License-Identifier: Apache-2.0
#pragma once

// Predicted run times, for choosing between methods: one thread, one channel, on the kind of machine that the constants
// were measured on. Only their ratios matter; Rigor::measure times the best few instead.

#include "mtf/engines/fft/axis.h"
#include "mtf/engines/taps/taps.h"

namespace mtf {

/// Milliseconds of an FFT method.
double fft_cost_ms(const AxisTransform& x, const AxisTransform& y, bool real_otf);

/// Milliseconds of separable taps of a rank, and of `used` taps of a direct kernel.
double separable_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t rank);
double direct_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t used, bool mirrored);

}  // namespace mtf
