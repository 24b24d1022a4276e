// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OTF of a system along one direction of the focal plane: of each component, of each list, and of the whole, as
// `mtf curve` prints it.
//
//   const mtf::io::SensorConfig sensor = apps::read_sensor_file("sensor.toml");
//   const apps::OtfCurves curves = apps::otf_curves(sensor.system, {0.0, 0.25, 0.5},
//                                                   apps::make_direction(sensor.system.frame, "cy/px", 45.0));
//   curves.system.otf[1];                  // or, as the columns of the CSV file, apps::table_of(curves)
//
// The direction is `angle_deg` from +x (columns, right) to +y (rows, down). A frequency f denotes the vector f (cos
// a, sin a), component by component in its own unit: cy/px with pixels that are not square means fx = f cos a / pitch_x
// and fy = f sin a / pitch_y, so that 0.5 cy/px is Nyquist along either axis.

#include <optional>
#include <string>
#include <vector>

#include "mtf/system.h"

namespace apps {

struct Direction {
  std::string unit = "cy/mm";  ///< of frequencies: cy/mm, cy/mrad or cy/px
  double angle_deg = 0.0;
  mtf::Freq<double> step{1.0, 0.0};  ///< cycles/mm for one unit of frequency
};

/// Throws UsageError for an angle outside -360 to 360, and for another unit.
Direction make_direction(const mtf::Frame<double>& frame, const std::string& unit, double angle_deg);

/// The system as it is at a field point. Throws UsageError for one that is not finite or farther than 4 half diagonals
/// from the axis, and for numbers that are not valid there.
mtf::System<double> system_at(const mtf::System<double>& system, const mtf::FieldPoint<double>& q);

/// Figures of merit along a direction, in its unit.
struct KeyFigures {
  double nyquist = 0.0;          ///< the frequency at which the first of the axes is at its Nyquist frequency
  std::optional<double> cutoff;  ///< from where on the presample OTF is zero (shortest wavelength of a band)
  std::optional<double> q;       ///< 2 Nyquist / optical cutoff = lambda N / pitch (middle of a band)

  /// The end of a curve that nobody asked to end elsewhere: the cutoff, but at most twice the Nyquist frequency.
  double last_frequency() const;
};

KeyFigures key_figures(const mtf::System<double>& system, const Direction& direction);

/// The values of one component or product.
struct OtfColumn {
  std::string label;
  std::string kind;   ///< "" for products
  std::string stage;  ///< list it belongs to; "system" for the whole
  bool real = true;
  std::vector<mtf::Complex<double>> otf;
  std::vector<double> error;  ///< of the average over the band, absolute, at each frequency
  std::string doc{};          ///< what the component is, with the model it uses; "" for products

  /// The average over the band errs by more than mtf::kBandError somewhere: the errors have to be shown.
  bool has_coarse_average() const;
};

struct OtfCurves {
  std::string name;  ///< of the system
  Direction direction;
  KeyFigures figures;
  std::optional<mtf::FieldPoint<double>> field;  ///< place in the image that was asked for
  std::vector<double> frequency;                 ///< in the unit of the direction
  std::vector<OtfColumn> components;  ///< in the order of the lists; a chromatic one averaged over the band on its own
  std::vector<OtfColumn> stages;      ///< presample, readout, postsample: products, averaged over the band as a whole
  OtfColumn system;

  /// Those that tables show: the components, presample and the other lists that have components, the system.
  std::vector<const OtfColumn*> columns() const;
};

/// Values at `frequency`, in the unit of `direction`; without frequencies 61 of them from 0 to
/// KeyFigures::last_frequency(). Throws UsageError for frequencies beyond 1e9 cy/mm.
OtfCurves otf_curves(const mtf::System<double>& system, std::vector<double> frequency = {},
                     const Direction& direction = {});

/// The lowest frequency at which the MTF of the system falls to 1/2, to 1e-5 of it, in the unit of its curves; none
/// where they stay above, or begin below. A dip between two of their frequencies is not seen.
std::optional<double> mtf50(const mtf::System<double>& system, const OtfCurves& curves);

/// A column of numbers under its name.
struct TableColumn {
  std::string name;
  std::vector<double> values;
};

/// What `mtf curve --format csv` writes: "frequency"; then a column for each of OtfCurves::columns(), called by its
/// label, or LABEL_re and LABEL_im where the OTF is not real; and LABEL_error after one with a coarse average.
std::vector<TableColumn> table_of(const OtfCurves& curves);

/// `count`, 1 or more, evenly spaced numbers from `start` to `stop`, both included; only `start` when count is 1.
std::vector<double> evenly_spaced(double start, double stop, int count);

}  // namespace apps
