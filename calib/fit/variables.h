// SPDX-License-Identifier: Apache-2.0
#pragma once

// The variables of the minimiser, from the parameters of the fit.
//   value = step x                        in general
//   value = +- step sqrt(x), x >= 0       where H depends on the square of the parameter
//   value = step x modulo the period      of a direction, which has no bounds then
// `step` is such that x = 1 changes the OTF by about 0.05, so that sizes, trust regions and directions are comparable.
// Squares are used because the likelihood of an rms, a width or a defocus is flat at zero, but not that of its square.
// A square knows no sign: that of the value is the side of 0 with the larger range, or that of the start. A prior that
// tells the signs apart leaves the parameter itself as the variable.

#include <span>
#include <vector>

#include "calib/fit/fit.h"
#include "calib/fit/sensors.h"

namespace calib {

/// Change of the OTF, at the frequencies that the data hold, for x = 1.
inline constexpr double kUnitEffect = 0.05;

struct Variable {
  bool squared = false;
  double sign = 1.0;
  double step = 1.0;
  double lo = 0.0, hi = 0.0;  ///< bounds of x
  double start = 0.0;         ///< x
  double period = 0.0;        ///< period of a direction's value, which is given within half of it from 0; 0 = none
  bool direction = false;     ///< an angle over whole turns, whether its range is bounded or not
  bool positive = false;      ///< the parameter cannot be negative: its size is its own scale
  double other_side = 0.0;    ///< of a square: how far values of the other sign, which do the same, are in the range

  /// Values on both sides of 0 are in the range, and are values of x.
  bool has_sign() const { return !squared && !direction && lo < 0.0 && hi > 0.0; }

  double value(double x) const;
  /// d value / dx, finite at x = 0.
  double slope(double x) const;
  double x_of(double value) const;
};

/// Frequencies at which some of the data depend on the parameters.
struct Probe {
  std::size_t place = 0;  ///< Sensors::place
  std::vector<PixelFreq> f;
  const mtf::Unit* unit = nullptr;  ///< unit of f, where that is not cy/px
};

/// Finds steps and squares at the present values. Leaves the sensors at the starting values. Throws UsageError for
/// bounds that leave no value, priors without a width, numbers that are not finite.
std::vector<Variable> make_variables(Sensors& sensors, std::span<const FitParameter> parameters,
                                     std::span<const double> start, std::span<const mtf::FieldInfo> infos,
                                     std::span<const Probe> probes, int threads);

/// Where a size is so large that more of it changes nothing, the minimiser has no gradient to follow: such a starting
/// value is divided by 4, 16, ... until it acts. Others are returned unchanged. `variables`: made at `start`. Leaves
/// the sensors at any values.
std::vector<double> seen_values(Sensors& sensors, std::span<const Variable> variables, std::span<const double> start,
                                std::span<const Probe> probes, int threads);

/// Values of the parameters at x.
std::vector<double> values_at(std::span<const Variable> variables, std::span<const double> x);

}  // namespace calib
