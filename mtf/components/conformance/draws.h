// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values for a component from its field table alone: every combination of optional fields that its check accepts, with
// the examples of the table, with values near them, and with values from the whole range of every field, its bounds
// included. The name of a draw is the seed of its numbers, so that the same draws come in every run and a new field
// leaves those without it as they are.

#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/component.h"

namespace mtf::conformance {

/// A small generator whose numbers do not depend on the standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// Streams that depend on nothing but a name and a number.
  explicit Random(std::string_view name, std::uint64_t stream = 0);
  std::uint64_t bits();
  double uniform(double lo, double hi) { return lo + (hi - lo) * (static_cast<double>(bits() >> 11) * 0x1p-53); }
  /// lo <= result < hi, spread evenly over the decades; 0 < lo.
  double decades(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }

 private:
  std::uint64_t state_;
};

/// Where the numbers of a draw come from.
enum class Origin { example, near_example, whole_range, lower_bound, upper_bound };

struct Draw {
  std::string name;         ///< kind, fields that are given, number of the draw: for messages
  std::uint64_t given = 0;  ///< bit i: field i of the table has a value; the others stay as they are
  Origin origin = Origin::example;
  /// Within a factor of three of the examples.
  bool typical() const { return origin == Origin::example || origin == Origin::near_example; }
};

/// The draws that `accepted` takes, in a fixed order. `fields`: of a component of the kind with default values.
std::vector<Draw> draws_of(std::string_view kind, std::span<const FieldRef<double>> fields,
                           const std::function<bool(const Draw&)>& accepted);

/// Gives the fields their values and returns the frame, the shared optics and the wavelength of the draw. Throws
/// UsageError for an example in the field table that the field could not be read from.
Context<double> give_values(const Draw& draw, std::span<const FieldRef<double>> fields);

}  // namespace mtf::conformance
