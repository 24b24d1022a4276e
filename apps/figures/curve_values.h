// SPDX-License-Identifier: Apache-2.0
#pragma once

// OTF values of a system along one direction of the focal plane, in the unit that the user asked for.
//
// The direction is `angle_deg` from +x (columns, right) to +y (rows, down). A frequency f denotes the vector f (cos
// a, sin a), component by component in its own unit: cy/px with pixels that are not square means fx = f cos a / pitch_x
// and fy = f sin a / pitch_y, so that 0.5 cy/px is Nyquist along either axis.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mtf/system.h"

namespace apps {

struct Direction {
  std::string unit;  ///< cy/mm, cy/mrad or cy/px
  double angle_deg = 0.0;
  mtf::Freq<double> step;  ///< cycles/mm for one unit of frequency
};

/// Throws UsageError for an angle outside -360 to 360.
Direction make_direction(const mtf::Frame<double>& frame, const std::string& unit, double angle_deg);

/// One column of values.
struct OtfColumn {
  std::string label;
  std::string kind;   ///< "" for products
  std::string stage;  ///< list it belongs to; "system" for the whole
  bool real = true;
  std::vector<mtf::Complex<double>> otf;
  std::vector<double> error;  ///< of the average over the band, absolute, at each frequency
  std::string doc{};          ///< what the component is, with the model it uses; "" for products
};

struct CurveValues {
  Direction direction;
  std::vector<double> frequency;
  std::vector<OtfColumn> components;  ///< in the order of the lists; a chromatic one averaged over the band on its own
  std::vector<OtfColumn> stages;      ///< presample, readout, postsample: products, averaged over the band as a whole
  OtfColumn system;
};

/// The average over the band errs by more than mtf::kBandError somewhere: the errors have to be shown.
bool has_coarse_average(const OtfColumn& column);

/// Values at `frequency`, in the unit of `direction`. Throws UsageError for frequencies beyond 1e9 cy/mm.
CurveValues curve_values(const mtf::System<double>& system, const Direction& direction, std::vector<double> frequency);

/// Figures of merit along a direction, in its unit.
struct KeyFigures {
  double nyquist = 0.0;          ///< the frequency at which the first of the axes is at its Nyquist frequency
  std::optional<double> cutoff;  ///< from where on the presample OTF is zero (shortest wavelength of a band)
  std::optional<double> q;       ///< 2 Nyquist / optical cutoff = lambda N / pitch (middle of a band)
};

KeyFigures key_figures(const mtf::System<double>& system, const Direction& direction);

}  // namespace apps
