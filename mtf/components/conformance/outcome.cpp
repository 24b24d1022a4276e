// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/conformance/outcome.h"

#include <algorithm>

#include "mtf/units.h"

namespace mtf::conformance {

bool all_ok(const std::vector<Outcome>& outcomes) {
  return std::all_of(outcomes.begin(), outcomes.end(), [](const Outcome& outcome) { return outcome.ok(); });
}

std::string describe_failures(const std::vector<Outcome>& outcomes) {
  std::string text;
  for (const Outcome& outcome : outcomes)
    if (!outcome.ok())
      text += outcome.property + ": " + std::to_string(outcome.failed) + " of " + std::to_string(outcome.compared) +
              " comparisons fail; the worst gives " + format_double(outcome.found) + " where at most " +
              format_double(outcome.allowed) + " is allowed: " + outcome.where + "\n";
  return text;
}

}  // namespace mtf::conformance
