// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rows of `mtf budget`.

#include <memory>
#include <string>
#include <vector>

#include "apps/options.h"
#include "apps/sensor/sensor_chain.h"
#include "mtf/metrics/resolution.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/performance/target_at_range.h"

namespace apps {

struct BudgetTable {
  std::vector<radiometry::BudgetRow> rows;
  radiometry::Budget<double> numbers;  ///< that the rows are made of
  std::vector<std::string> notes;      ///< about the numbers
  std::vector<std::string> observer;   ///< observer_lines()
  std::string spatial_gap;             ///< why spatial noise has no number; "" where it has
  std::string air;                     ///< the table that gives the air that the sensor looks through; "" without air
  bool without_path = false;           ///< the scene gives the range of each pixel
};

/// For a surface of that temperature. `loaded`: the chain of `config`. Throws UsageError with the place in the file.
BudgetTable budget_table(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, double temperature_k);

/// The sensor that a budget is asked of.
mtf::io::SensorConfig read_sensor(const BudgetOptions& options, const Global& global);

/// What a person reads beside these rows: the MTF of the system at Nyquist along x and along y, averaged over the band
/// with the electron rate of `loaded`, as `mtf curve` has it; where it changes over the image, its mean and the worst.
std::vector<radiometry::BudgetRow> nyquist_rows(const mtf::System<double>& system, const LoadedSensor& loaded);

/// What the rows do not say: what was assumed, what has no number, saturation where no table says it.
void note_budget(const BudgetOptions& options, const BudgetTable& budget, const Global& global);

/// Why there is no MRTD and MDTD of a sensor with that budget, "" where there is.
std::string observer_gap(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                         const radiometry::Budget<double>& budget);

/// What the observer of MRTD and MDTD sees through a sensor with that budget, with the defaults of a study. `system`
/// has the electron rate of its band, and has to outlive the view.
struct BarView {
  std::shared_ptr<const mtf::Resolution<double>> resolution;
  radiometry::BarObserver<double> observer;
  radiometry::SensorAtRange<double> sensor;
  double cutoff_cy_mrad = 0.0;  ///< as far as squares are counted
};
BarView bar_view(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                 const radiometry::Budget<double>& budget);

/// Rows for people: in groups, those of the value 0 only named, then the largest terms in words. `rows`: those of the
/// budget, and others.
std::string budget_text(const BudgetTable& budget, const std::vector<radiometry::BudgetRow>& rows);

/// Who the observer of MRTD and MDTD is, and what air lies before the sensor.
std::vector<std::string> observer_lines(const mtf::System<double>& system, const radiometry::Sensor& sensor);

}  // namespace apps
