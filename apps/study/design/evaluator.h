// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a design to its row of results. Each thread has an Evaluator: it keeps the sensors of the variants that it has
// read and the factors of the previous design, and computes again only what has changed since then.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/study/study.h"

namespace study {

struct Column {
  enum class Role {
    axis,       ///< value of an axis; of a discrete one without numbers the index into `levels`
    link,       ///< value of a linked parameter
    metric,     ///< NaN where the design cannot have it; `gap` says why
    objective,  ///< value of an objective that is not just one metric or parameter
    feasible,   ///< 1 when all constraints hold and all objectives are finite, else 0
    yield,      ///< share of as-built draws that meet all constraints
    error,      ///< estimate of the largest error of the metrics, each as `tolerance` counts it
    pareto      ///< 1 for a design of the Pareto front, else 0: a column of files, which no row has
  };
  std::string name, unit, definition, source;
  Role role = Role::metric;
  std::vector<std::string> levels{};
};

/// The columns in their order: axes, links, metrics, objectives, `feasible` (with constraints), `yield` (with as-built
/// variation), `error`.
std::vector<Column> columns_of(const Study& study);

/// Derivatives by the parameters of the numeric axes, by autodiff; NaN where there is none.
struct Gradient {
  std::vector<std::string> columns, parameters;
  std::vector<double> value;      ///< [column][parameter]: metrics and objectives that have a column, in its unit
  std::vector<double> objective;  ///< [objective][parameter]: all objectives, as shown
  std::vector<double> margin;     ///< [constraint][parameter]: ConstraintValues::margin, in SI
};

class Evaluator {
 public:
  explicit Evaluator(std::shared_ptr<const Study> study);
  ~Evaluator();
  Evaluator(Evaluator&&) noexcept;

  /// One design; row.size() = number of columns. Designs that a sensor cannot be (a value out of its range, a pupil
  /// that does not exist) have NaN metrics, feasible 0, and their reason in last_problem(). Throws RuntimeError for
  /// files that cannot be read only.
  void evaluate(std::int64_t design, std::span<double> row);
  /// The same at any values of the axes, those of discrete axes being indices of levels. `shift`: added to the
  /// parameters of Study::as_built after the links, in their units; empty for none. `yield` stays NaN here.
  void evaluate_at(std::span<const double> axis_values, std::span<double> row, std::span<const double> shift = {});
  /// To `tolerance`, or the study's where that is smaller.
  Gradient gradient_at(std::span<const double> axis_values, double tolerance = 1e-9);
  const std::string& last_problem() const;  ///< "" when the last design was fine
  /// The last design is a sensor, and its objectives and both sides of its constraints are finite.
  bool last_valid() const;
  /// Why a metric of the last design has no number where others have theirs (it is saturated, a model refuses it).
  const std::string& last_refusal() const;
  /// How far numbers of the last design are wrong, or what they rest on: close to saturation, rounding without dither,
  /// a range at Nyquist, components beyond their stated validity; "" without.
  std::string last_caution() const;
  /// The values of the last design that was evaluated: all objectives as shown, and the sides of the constraints.
  std::span<const double> last_objectives() const;
  std::span<const ConstraintValues> last_sides() const;

  /// Why a metric has no number for this study at all ("netd: no [detector]"), by column; "" where it has.
  std::vector<std::string> gaps() const;
  /// Sentences that say what was not computed because no metric needs it, and what neighbouring designs shared.
  std::vector<std::string> skipped() const;

  /// The sensor of a design with all numbers set: what `mtf simulate` would read.
  mtf::io::SensorConfig sensor_at(std::span<const double> axis_values);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace study
