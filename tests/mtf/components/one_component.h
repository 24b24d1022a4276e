// SPDX-License-Identifier: Apache-2.0
#pragma once

// One component on a plain detector, for tests of its values.

#include <array>
#include <cmath>

#include "tests/mtf/builders.h"

namespace mtf::test {

/// The frequencies of the golden values, cycles/mm; the last is 0.5 / 17 um.
inline constexpr std::array<double, 4> kGoldenFrequencies{5.0, 10.0, 20.0, 29.41176470588235};
/// Half a unit of the tenth digit.
inline constexpr double kTenDigits = 5.01e-11;

inline System<double> detector(double pitch_x_um = 17.0, double pitch_y_um = 17.0) {
  System<double> s;
  s.frame = {100.0, pitch_x_um, pitch_y_um, 0.01, 0, 0};
  s.optics.f_number = 1.0;
  s.optics.wavelength_um = 4.0;
  return s;
}

inline Complex<double> otf_at(const Component<double>& component, double fx, double fy,
                              const System<double>& system = detector()) {
  return component.otf({fx, fy}, system.context());
}

inline double modulus(const Complex<double>& h) { return std::hypot(h.re, h.im); }

/// Whether check() has an error about that field.
inline bool refused(const Component<double>& component, std::string_view field,
                    const System<double>& system = detector()) {
  for (const Problem& p : component.check(system.context()))
    if (p.error && p.field == field) return true;
  return false;
}

}  // namespace mtf::test
