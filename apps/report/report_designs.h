// SPDX-License-Identifier: Apache-2.0
#pragma once

// designs.csv of a sweep: read once in pieces, checked against sweep.json, thinned out to fit a page.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/options.h"
#include "apps/report/report_sweep.h"
#include "mtf/io/config/config.h"
#include "radiometry/performance/sensitivity.h"

namespace apps {

/// The rows that a report holds, with every cell as the file has it.
struct DesignTable {
  std::vector<std::int64_t> design;             ///< number of each row, rising
  std::vector<std::vector<std::string>> cells;  ///< by row, then by column of the sweep; "" for none
  std::int64_t every = 1;         ///< beside the Pareto front and the named designs one of so many is here
  std::int64_t pareto_every = 1;  ///< and of the front, too
  std::string sha256;             ///< of the file

  bool whole() const { return every == 1; }
  /// Row of a design.
  std::optional<std::size_t> row(std::int64_t design) const;
};

/// What a page may hold.
struct TableLimits {
  std::int64_t rows = 20000;
  std::int64_t bytes = 500'000;  ///< of the rows as the file has them
};

/// Reads DIR/designs.csv. All rows where they fit the limits; else the best, chosen and nearest designs, the Pareto
/// front (where it takes more than half of the room, every pareto_every-th of it) and of all others one in `every`,
/// drawn by a fixed hash of its number. Throws UsageError "file:line: ..." where it does not fit sweep.json,
/// RuntimeError when it cannot be read.
DesignTable read_designs(const Sweep& sweep, const TableLimits& limits = {});

// The chosen designs of a sweep, one by one: curves, noise budget and a simulated image, each computed here
// from chosen/design_N.toml. Where one of them is not possible, a sentence says why; it is no error.

struct ChosenCurve {
  std::string label, stage, doc;
  std::vector<double> mtf;  ///< at ChosenDesign::frequency_cy_mm
  double at_nyquist = 0.0;
};

struct ChosenImage {
  std::string data_uri;  ///< PNG
  std::int64_t width = 0, height = 0;
  double low = 0.0, high = 0.0;  ///< black and white
  std::string unit;
  std::vector<std::string> notes;
};

struct ChosenDesign {
  SweepChosen chosen;
  std::string name, text;  ///< of the sensor file
  std::string problem;     ///< why there is nothing below; "" else
  mtf::io::SensorConfig config;
  double nyquist_cy_mm = 0.0;           ///< along x, as all curves
  std::vector<double> frequency_cy_mm;  ///< 0 to the cutoff or twice Nyquist, the smaller
  std::vector<ChosenCurve> components;
  ChosenCurve system;
  std::vector<radiometry::BudgetRow> budget;
  std::string budget_gap;  ///< why there is none
  std::string saturation;  ///< which of its figures are refused or wrong, and why; "" when all are right
  ChosenImage image;
  std::string image_gap;
};

/// Bytes that an image takes in a page, at most: 160 x 160 grey values that do not compress, in base 64.
inline constexpr std::size_t kMostOfImage = 36'000;

/// Reads every chosen file; curves, and budgets of a surface of the study's temperature.
std::vector<ChosenDesign> load_chosen(const Sweep& sweep);

/// The images of one scene: the file `scene`, or the built-in one when it is empty, which has the same angular size for
/// all designs; `temperature_k`: its mean.
void simulate_chosen(std::vector<ChosenDesign>& designs, const std::string& scene, double temperature_k,
                     const Global& global);

/// A file of the sweep's folder as text. Nothing, and `problem` says why, when it is missing, too large or elsewhere.
std::string text_of(const Sweep& sweep, const std::string& file, std::string& problem);

}  // namespace apps
