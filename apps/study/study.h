// SPDX-License-Identifier: Apache-2.0
#pragma once

// A trade study: a base sensor, what varies, what is asked of every design; its file is described in the README beside
// this header, with every key. What metrics take from outside of the sensor: radiometry/performance/conditions.h.
// Axes over `sensor` itself name other sensor files. A discrete axis is one of anything but numbers that the sensor's
// formulas take (plain or with unit): whole numbers, words, flags, texts, files, lists, and lengths where the sensor
// file has an angle. The combinations of their levels are variants, sensors of their own.

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/study/design/metric_list.h"
#include "apps/study/expression.h"
#include "apps/study/statistics/sampling.h"
#include "mtf/io/config/config.h"
#include "radiometry/performance/conditions.h"

namespace study {

using radiometry::Conditions;

/// A number of a design: an axis, the target of a link, something that varies as built, or just read by an expression.
/// Values are held in `unit`, which is that of the sensor's field (FieldInfo::unit; for Extents the unit they are
/// written in there), or for a number of the study's own the unit of its first value.
struct Parameter {
  enum class Role { axis, link, fixed };
  std::string name;           ///< as the study calls it first: "optics.aperture"
  std::string path;           ///< as diagnostics call it: "presample[1].rms"; "" for one of the study's own
  std::string unit;           ///< "" for plain numbers
  UnitScale scale;            ///< of the unit
  double lo = 0.0, hi = 0.0;  ///< allowed range, in the unit
  bool lo_open = false, hi_open = false;
  Role role = Role::fixed;
  double base = 0.0;  ///< value in the base sensor, NaN where it has none (a `fixed` one: read from each variant)
};

enum class Scale { linear, log };

struct Axis {
  int parameter = 0;             ///< index into Study::parameters
  std::vector<double> values{};  ///< of a list: numbers in the unit; of a discrete axis: its numbers, or 0, 1, 2 ...
  std::vector<std::string> levels{};  ///< discrete: the value of each level as text; else empty
  double from = 0.0, to = 0.0;        ///< ends of a range, which has no values
  Scale scale = Scale::linear;
  int count = 0;  ///< points of a range on a grid

  bool discrete() const { return !levels.empty(); }
  /// The number of points on a grid.
  std::int64_t points() const { return values.empty() ? count : static_cast<std::int64_t>(values.size()); }
};

struct Link {
  int parameter = 0;
  Expression expression;
};

struct AsBuilt {
  enum class Law { normal, uniform };
  int parameter = 0;
  Law law = Law::normal;
  double spread = 0.0;  ///< sd, or half width; in the unit, or a fraction of the value
  bool relative = false;
};

struct Constraint {
  std::string text;
  Expression left, right;
  bool less = true;  ///< left < right, else left > right
  bool strict = true;
};

/// Values of both sides of a constraint, in SI; NaN for a design that cannot be.
struct ConstraintValues {
  double left = 0.0, right = 0.0;

  /// The amount by which it holds, below 0 where it does not: right - left of left < right (`less`), else left - right.
  double margin(bool less) const { return less ? right - left : left - right; }
  /// True when both sides are numbers; an infinite side decides nothing.
  bool finite() const { return std::isfinite(left) && std::isfinite(right); }
};

struct Objective {
  std::string text;  ///< without maximize or minimize
  bool maximize = false;
  Expression expression;
  std::string
      unit;  ///< unit of the value as shown: that of the metric or parameter where it is just one, else SI ("m s^-1")
  double si = 1.0;  ///< value in SI / si = value shown
};

enum class Method { grid, latin_hypercube, sobol };

/// A file that sensors of a study name, as it was when the study was read.
struct ReadFile {
  std::string file, sha256;
  std::int64_t bytes = 0, changed_ns = 0;
};

struct Study {
  std::string file, text, sha256;  ///< sha256: hash of this text and of every file that it and its sensors name
  std::string name;
  mtf::io::SensorConfig base;                  ///< `sensor`, or the first level of the axis over it
  std::vector<mtf::io::SensorConfig> sensors;  ///< levels of the axis over `sensor`, empty without one
  double tolerance = 1e-4;
  std::uint64_t seed = 0;
  std::vector<Parameter> parameters;
  std::vector<Axis> axes;
  Method method = Method::grid;
  std::vector<SobolAxis> sobol;  ///< by axis, for that method
  std::int64_t designs = 0;      ///< 1 to 1e9; more is refused when the file is read, with the count
  std::int64_t variants = 1;     ///< combinations of the levels of discrete axes, at most 10 000
  std::vector<Link> links;       ///< in an order in which each follows from those before it
  std::vector<AsBuilt> as_built;
  int draws = 0;                    ///< draws for the yield; 0 without [[as_built]]
  std::vector<MetricInfo> metrics;  ///< listed, then those that only constraints and objectives use
  std::vector<Constraint> constraints;
  std::vector<Objective> objectives;
  Conditions conditions;
  std::vector<mtf::io::Diagnostic> warnings;
  std::vector<ReadFile> read{};

  /// Slots of expressions: parameters, then metrics.
  std::size_t slots() const { return parameters.size() + metrics.size(); }
  const std::string& name_of(int slot) const {
    const auto i = static_cast<std::size_t>(slot);
    return i < parameters.size() ? parameters[i].name : metrics[i - parameters.size()].name;
  }
  const std::string& unit_of(int slot) const {
    const auto i = static_cast<std::size_t>(slot);
    return i < parameters.size() ? parameters[i].unit : metrics[i - parameters.size()].unit;
  }
};

/// What is wrong with a study file, for `mtf config check`; the study is usable only without errors. Never throws for
/// what is in the text. Names of sensor files are relative to the folder of `file`.
struct StudyResult {
  Study study;
  std::vector<mtf::io::Diagnostic> diagnostics;  ///< sorted by position, all errors in one pass
  bool ok() const;
};
StudyResult parse_study(const std::string& text, const std::string& file);

/// Metrics of [metrics] list that no design can have: their columns stay empty.
std::vector<mtf::io::Diagnostic> listed_gaps(const Study& study);

/// What the observers, target and air of a study are, in words, for every output of its ranges. Empty for a study
/// without figures of light, quality or observers. A magnification by a display is that of the study's first sensor.
std::vector<std::string> condition_lines(const Study& study);

/// True for a file whose top level has [[axis]] or `sensor`: a study and no sensor.
bool is_study(const std::string& text);

/// A file that a study is made from, and the value of the study file that names it, or the sensor file that names it.
struct StudyFile {
  std::string file;
  mtf::io::Position position;
  std::string path;  ///< of that value: "sensor", "axis[0].values"
};

/// All sensor files of the study and the files that they name, for each value of each discrete axis; each once, sorted
/// by name. A value that contradicts the first values of the other axes is skipped, as its designs have no sensor.
std::vector<StudyFile> files_of(const Study& study);

/// Designs read the files of their sensors when they are made: throws RuntimeError, naming it, where one is not what it
/// was when the study was read.
void require_unchanged(const Study& study);

/// Reads a file. Throws RuntimeError when it cannot be read, UsageError with all errors as "file:line:col: error: ..."
/// lines.
std::shared_ptr<const Study> load_study(const std::string& file);

/// Values of the axes' parameters (in the order of Study::axes) of a design, in any order of calls; for a discrete axis
/// the index of its level. design < study.designs.
void design_at(const Study& study, std::int64_t design, std::span<double> axis_values);

/// The same map for a point of the unit cube, as sensitivities sample it: each axis at its quantile.
void design_at_quantiles(const Study& study, std::span<const double> unit, std::span<double> axis_values);

/// The sensor file with the discrete axes at those levels (others as in the base), in the order of Study::axes, entries
/// of axes that are not discrete ignored. Throws UsageError for combinations that a sensor file could not hold.
mtf::io::SensorConfig variant(const Study& study, std::span<const int> levels);

}  // namespace study
