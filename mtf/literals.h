// SPDX-License-Identifier: Apache-2.0
#pragma once

// Quantities as literals: 15_um, 3.75_um, 20_urad, 0.5_px, 40_cy_mm, 4_ms. A program says `using namespace
// mtf::literals;`. Units without a literal have their function in mtf/quantity.h.

#include "mtf/quantity.h"

namespace mtf::literals {

inline Length operator""_nm(long double value) { return nanometres(static_cast<double>(value)); }
inline Length operator""_nm(unsigned long long value) { return nanometres(static_cast<double>(value)); }
inline Length operator""_um(long double value) { return micrometres(static_cast<double>(value)); }
inline Length operator""_um(unsigned long long value) { return micrometres(static_cast<double>(value)); }
inline Length operator""_mm(long double value) { return millimetres(static_cast<double>(value)); }
inline Length operator""_mm(unsigned long long value) { return millimetres(static_cast<double>(value)); }
inline Length operator""_m(long double value) { return metres(static_cast<double>(value)); }
inline Length operator""_m(unsigned long long value) { return metres(static_cast<double>(value)); }
inline Length operator""_km(long double value) { return kilometres(static_cast<double>(value)); }
inline Length operator""_km(unsigned long long value) { return kilometres(static_cast<double>(value)); }

inline Angle operator""_urad(long double value) { return microradians(static_cast<double>(value)); }
inline Angle operator""_urad(unsigned long long value) { return microradians(static_cast<double>(value)); }
inline Angle operator""_mrad(long double value) { return milliradians(static_cast<double>(value)); }
inline Angle operator""_mrad(unsigned long long value) { return milliradians(static_cast<double>(value)); }
inline Angle operator""_deg(long double value) { return degrees(static_cast<double>(value)); }
inline Angle operator""_deg(unsigned long long value) { return degrees(static_cast<double>(value)); }

inline Pixels operator""_px(long double value) { return pixels(static_cast<double>(value)); }
inline Pixels operator""_px(unsigned long long value) { return pixels(static_cast<double>(value)); }

inline Frequency operator""_cy_mm(long double value) { return cycles_per_mm(static_cast<double>(value)); }
inline Frequency operator""_cy_mm(unsigned long long value) { return cycles_per_mm(static_cast<double>(value)); }
inline Frequency operator""_cy_mrad(long double value) { return cycles_per_mrad(static_cast<double>(value)); }
inline Frequency operator""_cy_mrad(unsigned long long value) { return cycles_per_mrad(static_cast<double>(value)); }
inline Frequency operator""_cy_px(long double value) { return cycles_per_px(static_cast<double>(value)); }
inline Frequency operator""_cy_px(unsigned long long value) { return cycles_per_px(static_cast<double>(value)); }

inline TemporalFrequency operator""_Hz(long double value) { return hertz(static_cast<double>(value)); }
inline TemporalFrequency operator""_Hz(unsigned long long value) { return hertz(static_cast<double>(value)); }
inline TemporalFrequency operator""_kHz(long double value) { return kilohertz(static_cast<double>(value)); }
inline TemporalFrequency operator""_kHz(unsigned long long value) { return kilohertz(static_cast<double>(value)); }
inline TemporalFrequency operator""_MHz(long double value) { return megahertz(static_cast<double>(value)); }
inline TemporalFrequency operator""_MHz(unsigned long long value) { return megahertz(static_cast<double>(value)); }

inline Duration operator""_us(long double value) { return microseconds(static_cast<double>(value)); }
inline Duration operator""_us(unsigned long long value) { return microseconds(static_cast<double>(value)); }
inline Duration operator""_ms(long double value) { return milliseconds(static_cast<double>(value)); }
inline Duration operator""_ms(unsigned long long value) { return milliseconds(static_cast<double>(value)); }
inline Duration operator""_s(long double value) { return seconds(static_cast<double>(value)); }
inline Duration operator""_s(unsigned long long value) { return seconds(static_cast<double>(value)); }

}  // namespace mtf::literals
