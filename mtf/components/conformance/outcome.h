// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the check of one property of a component has found.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "mtf/units.h"

namespace mtf::conformance {

/// One property over all values and frequencies that were tried: how many comparisons were made, how many failed, and
/// the one that failed by most.
struct Outcome {
  std::string property;
  std::size_t compared = 0;
  std::size_t failed = 0;
  std::string where{};   ///< of the worst failure: values of the component, frequency, what was compared
  double found = 0.0;    ///< there: the difference, or the value that has a bound
  double allowed = 0.0;  ///< there
  bool ok() const { return failed == 0; }

  /// Makes one comparison, which a NaN fails. `place` is a function that gives `where`; called for failures.
  void at_most(double value, double limit, const auto& place) {
    ++compared;
    if (value <= limit) return;
    if (failed++ == 0 || std::isnan(value) || value - limit > found - allowed) {
      where = place();
      found = value;
      allowed = limit;
    }
  }
  /// The same for what is true or false: a failure has found 1 and allowed 0.
  void holds(bool is_true, const auto& place) { at_most(is_true ? 0.0 : 1.0, 0.0, place); }
};

inline bool all_ok(const std::vector<Outcome>& outcomes) {
  return std::all_of(outcomes.begin(), outcomes.end(), [](const Outcome& outcome) { return outcome.ok(); });
}

/// A line for each property that fails: "hermitian: 3 of 50 comparisons fail; the worst gives 0.2 where at most 1e-15
/// is allowed: jitter rms #3 at (20, -5) cy/mm". Empty when none does.
inline std::string describe_failures(const std::vector<Outcome>& outcomes) {
  std::string text;
  for (const Outcome& outcome : outcomes)
    if (!outcome.ok())
      text += outcome.property + ": " + std::to_string(outcome.failed) + " of " + std::to_string(outcome.compared) +
              " comparisons fail; the worst gives " + format_double(outcome.found) + " where at most " +
              format_double(outcome.allowed) + " is allowed: " + outcome.where + "\n";
  return text;
}

}  // namespace mtf::conformance
