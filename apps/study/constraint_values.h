// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace study {

/// Values of both sides of a constraint, in SI; NaN for a design that cannot be.
struct ConstraintValues {
  double left = 0.0, right = 0.0;

  /// The amount by which it holds, below 0 where it does not: right - left of left < right (`less`), else left - right.
  double margin(bool less) const { return less ? right - left : left - right; }
  /// True when both sides are numbers; an infinite side decides nothing.
  bool finite() const { return std::isfinite(left) && std::isfinite(right); }
};

}  // namespace study
