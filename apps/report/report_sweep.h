// SPDX-License-Identifier: Apache-2.0
#pragma once

// sweep.json of a sweep's folder as values, checked: what `mtf report` shows of a study.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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

}  // namespace apps
