// SPDX-License-Identifier: Apache-2.0
#include "apps/check/check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/check/families.h"
#include "mtf/units.h"

namespace apps::check {

bool Tally::note(long double error, long double scale, long double allowed) {
  ++count_;
  if (!std::isfinite(error)) error = std::numeric_limits<long double>::infinity();
  worst_abs_ = std::max(worst_abs_, static_cast<double>(error));
  if (std::abs(scale) >= std::numeric_limits<double>::min())
    worst_rel_ = std::max(worst_rel_, static_cast<double>(error / std::abs(scale)));
  if (error <= allowed) return false;
  const long double excess = allowed > 0.0L ? error / allowed : std::numeric_limits<long double>::infinity();
  if (!failure_.empty() && !(excess > worst_excess_)) return false;
  worst_excess_ = excess;
  return true;
}

void Tally::compare(double value, long double exact, long double allowed, std::string_view where) {
  const long double error = std::abs(value - exact);
  if (note(error, exact, allowed))
    failure_ = std::string(where) + ": " + mtf::format_double(value) + " instead of " +
               mtf::format_double(static_cast<double>(exact)) + ", off by " +
               mtf::format_double(static_cast<double>(error)) + " where " +
               mtf::format_double(static_cast<double>(allowed)) + " is allowed";
}

void Tally::error(long double error, long double scale, long double allowed, std::string_view where) {
  if (note(error, scale, allowed))
    failure_ = std::string(where) + ": an error of " + mtf::format_double(static_cast<double>(error)) + " where " +
               mtf::format_double(static_cast<double>(allowed)) + " is allowed";
}

std::vector<Check> all_checks() {
  std::vector<Check> all;
  for (const auto family : {special_checks, pupil_checks, aberration_checks, turbulence_checks, motion_checks,
                            component_checks, engine_checks, radiometry_checks})
    for (Check& check : family()) all.push_back(std::move(check));
  return all;
}

CheckResult run(const Check& check, const Tables& tables) {
  Tally tally;
  check.run(tables, tally);
  return {check.component,
          check.name,
          check.promise,
          tally.count(),
          tally.worst_abs(),
          tally.worst_rel(),
          tally.failure().empty() && tally.count() > 0,
          tally.count() > 0 ? tally.failure() : "nothing was compared"};
}

}  // namespace apps::check
