// SPDX-License-Identifier: Apache-2.0
#pragma once

// Frame, optics, band and frequencies from quantities, for systems that are made in code:
//   system.frame = make_frame({.focal_length = 100_mm, .pitch = 15_um, .integration_time = 4_ms});
// The types themselves hold plain numbers, each with its unit in its name.

#include <optional>

#include "mtf/band.h"
#include "mtf/frame.h"

namespace mtf {

struct FrameQuantities {
  Length focal_length;
  Length pitch;  ///< along x, and along y too without a pitch_y
  std::optional<Length> pitch_y{};
  Duration integration_time = seconds(0.0);
  int columns = 0, rows = 0;  ///< detector format; 0 = as many whole pitches as the scene holds
};

inline Frame<double> make_frame(const FrameQuantities& given) {
  return {given.focal_length / millimetres(1.0),
          given.pitch / micrometres(1.0),
          given.pitch_y.value_or(given.pitch) / micrometres(1.0),
          given.integration_time / seconds(1.0),
          given.columns,
          given.rows};
}

struct OpticsQuantities {
  std::optional<double> f_number{};
  std::optional<Length> aperture{};     ///< entrance pupil diameter, in place of the f-number
  std::optional<double> obscuration{};  ///< linear ratio, inner / outer diameter
  std::optional<Length> wavelength{};
};

inline Optics<double> make_optics(const OpticsQuantities& given) {
  Optics<double> optics{given.f_number, {}, given.obscuration, {}};
  if (given.aperture) optics.aperture_mm = *given.aperture / millimetres(1.0);
  if (given.wavelength) optics.wavelength_um = *given.wavelength / micrometres(1.0);
  return optics;
}

/// A band with the same electron rate at every wavelength.
inline Band make_band(const Length& lo, const Length& hi) { return {lo / micrometres(1.0), hi / micrometres(1.0)}; }

/// A spatial frequency of the focal plane; those per mrad and per pixel become so by the frame.
inline Freq<double> make_frequency(const Frame<double>& frame, const Frequency& x, const Frequency& y) {
  return {SpatialFrequency<double>(x).cy_mm(frame, Axis::x), SpatialFrequency<double>(y).cy_mm(frame, Axis::y)};
}

}  // namespace mtf
