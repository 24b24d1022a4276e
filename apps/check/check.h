// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks of the numbers on this machine and build: what `mtf check` runs, and the test suite too. A check compares many
// values with references that come from elsewhere (tables of high precision, slow sums in double) and holds each to the
// error that is promised for it. To add one: an entry in the list of its family (families.h), and its table in
// notebooks-data/reference.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/check/table.h"

namespace apps::check {

struct CheckResult {
  std::string component;   ///< what was checked: "diffraction", "engine", ...
  std::string name;        ///< which case of it
  std::string promise;     ///< the error allowed, in words
  std::int64_t count = 0;  ///< comparisons made
  double worst_abs = 0.0;  ///< largest |value - exact|; infinity when a value was not finite
  double worst_rel = 0.0;  ///< largest |value - exact| / |exact| where |exact| is a normal double
  bool passed = true;      ///< every comparison within its own allowance, and at least one made
  std::string failure{};   ///< the worst one that was not, "" when there is none
};

/// Collects comparisons.
class Tally {
 public:
  /// |value - exact| <= allowed. NaN never passes. `where` names the comparison in a failure.
  void compare(double value, long double exact, long double allowed, std::string_view where);
  /// A comparison whose error was taken elsewhere: `scale` makes it relative.
  void error(long double error, long double scale, long double allowed, std::string_view where);

  std::int64_t count() const { return count_; }
  double worst_abs() const { return worst_abs_; }
  double worst_rel() const { return worst_rel_; }
  const std::string& failure() const { return failure_; }

 private:
  bool note(long double error, long double scale, long double allowed);

  std::int64_t count_ = 0;
  double worst_abs_ = 0.0, worst_rel_ = 0.0;
  long double worst_excess_ = 1.0L;  ///< error / allowed of the failure shown
  std::string failure_;
};

struct Check {
  std::string component;
  std::string name;
  std::string promise;
  std::function<void(const Tables&, Tally&)> run;
};

/// All checks, in the order they are shown.
std::vector<Check> all_checks();

CheckResult run(const Check& check, const Tables& tables);

}  // namespace apps::check
