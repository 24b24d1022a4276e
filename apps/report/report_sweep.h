// SPDX-License-Identifier: Apache-2.0
#pragma once

// The folder of a sweep, read and checked: what `mtf report` shows of a study. sweep.json first, as values.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/options.h"
#include "mtf/io/config/config.h"
#include "radiometry/performance/sensitivity.h"

namespace apps {

struct SweepColumn {
  std::string name, unit;
  std::string role;  ///< axis, link, metric, objective, feasible, yield or error
  std::string definition, source;
  std::string gap;  ///< why no design has it, else ""
  std::vector<std::string> levels;
  std::int64_t missing = 0;  ///< designs without a value
};

struct SweepAxis {
  std::string column, scale;
  std::vector<std::string> values;  ///< of a grid or of a discrete axis, as text; empty for ranges that are sampled
};

struct SweepConstraint {
  std::string text;
  std::int64_t met = 0;
  std::vector<std::string> columns;  ///< that it compares
  double limit = 0.0;    ///< of the only one, in its unit, where that stands alone against a number; else NaN
  std::string relation;  ///< of the column to it: <, <=, > or >=
};

struct SweepObjective {
  std::string text, column;
  bool maximize = false;
};

/// A constraint or an end of an axis, and the words of `mtf optimize` for a design that lies at it.
struct SweepLimit {
  std::string text, state;
};

struct SweepBest {
  std::string objective;
  std::int64_t design = 0;
  double value = 0.0;
  std::optional<std::vector<SweepLimit>> limits;  ///< nothing in the folders of earlier versions
};

struct SweepChosen {
  std::int64_t design = 0;
  std::string file, why;
};

struct Derivative {
  std::string column, parameter, unit;
  double value = 0.0;
};

struct SensitivityIndex {
  std::string column, parameter;
  double first = 0.0, first_sd = 0.0, total = 0.0, total_sd = 0.0;
  std::int64_t used = 0;  ///< samples that have the metric
};

struct AccuracyPoint {
  double tolerance = 0.0, promised = 0.0, realised = 0.0, us_per_design = 0.0;
};

struct NamedFile {
  std::string file, sha256;
};

struct Sweep {
  std::filesystem::path folder;
  std::string name, version, commit, date, machine, method, sha256;
  NamedFile study;
  std::vector<NamedFile> sensors;
  std::int64_t designs = 0, evaluated = 0, seed = 0;
  double tolerance = 0.0, worst_error = 0.0;
  double temperature_k = 300.0;         ///< of the surface that the study's pixels image
  std::vector<std::string> conditions;  ///< what figures of observers and ranges hold for
  std::vector<SweepColumn> columns;
  std::vector<SweepAxis> axes;
  std::vector<SweepConstraint> constraints;
  std::vector<SweepObjective> objectives;
  std::int64_t feasible = 0;
  std::int64_t no_sensor = 0;  ///< of the invalid ones
  std::int64_t invalid = 0;    ///< no sensor has these values, or an objective or constraint is not finite
  std::string cause;           ///< the commonest of the invalid designs that were looked at
  std::int64_t of_cause = 0, looked_at = 0;
  std::vector<std::pair<std::string, std::int64_t>> not_finite;  ///< objective or constraint, designs
  std::optional<std::int64_t> nearest;                           ///< to being feasible, when no design is
  std::vector<std::string> violated;                             ///< by that one
  std::vector<SweepBest> best;
  std::vector<std::int64_t> pareto;  ///< rising
  std::int64_t pareto_size = 0;
  std::vector<SweepChosen> chosen;
  std::optional<std::int64_t> slope_design;  ///< where the derivatives were taken
  std::vector<Derivative> derivatives;
  std::int64_t samples = 0;
  std::vector<SensitivityIndex> indices;
  std::int64_t draws = 0;  ///< of the yield
  std::vector<std::pair<std::int64_t, double>> best_yield;
  std::vector<AccuracyPoint> accuracy;
  std::optional<double> seconds, designs_per_second;
  std::int64_t threads = 0, resumed = 0;
  std::vector<std::string> skipped;

  bool single() const { return designs == 1; }
  /// Index of the column of that name, none when there is no such column.
  std::optional<std::size_t> column(const std::string& name) const;
};

/// Reads and checks DIR/sweep.json. Throws UsageError for a folder that no sweep left, one that a sweep has not
/// finished, and another schema; RuntimeError for files that cannot be read.
Sweep read_sweep(const std::filesystem::path& folder);

// designs.csv: read once in pieces, checked against sweep.json, thinned out to fit a page.

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

// The sections of a report as HTML, each complete without scripts.

/// Axes, constraints, objectives and the best designs.
std::string summary_section(const Sweep& sweep, const DesignTable& table);
/// All designs: scatter, parallel coordinates, filters; which of them the page holds.
std::string trade_section(const Sweep& sweep, const DesignTable& table);
/// A metric over two axes.
std::string map_section(const Sweep& sweep);
/// The chosen designs side by side: values, curves, budgets, images. `scene`: the file of the images, "" for the
/// built-in one.
std::string chosen_section(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen,
                           const std::string& scene);
std::string sensitivity_section(const Sweep& sweep, const DesignTable& table);
/// Error against time, what was skipped.
std::string run_section(const Sweep& sweep);
/// Definition, unit and source of every column.
std::string columns_section(const Sweep& sweep);
/// The study and sensor files as text, versions and hashes.
std::string files_section(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen);

/// "name" with its definition on hovering.
std::string column_html(const SweepColumn& column);

}  // namespace apps
