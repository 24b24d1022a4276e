// SPDX-License-Identifier: Apache-2.0
#pragma once

// Systems of one component, made from the field tables alone: every kind of component_kinds(), every combination of
// optional fields that check() accepts, with the example values, values near them, and values from the whole parameter
// box including its bounds. The same list in every run: the name of each case is the seed of its numbers, so that a new
// kind or field leaves the cases of the others as they are.

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/system.h"

namespace mtf::test {

/// Small generator whose numbers do not depend on the standard library.
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

struct Case {
  std::string name;       ///< kind, fields in use, which draw: for messages
  System<double> system;  ///< one component
  Stage stage = Stage::presample;
  std::vector<std::string> given;  ///< optional and shared fields in use
  bool typical = false;            ///< within a factor of three of the examples; otherwise from the whole box
};

const std::vector<Case>& conformance_cases();

/// `system` is System<S> or const System<S>; the component is const accordingly.
auto& only_component(auto& system) {
  for (const Stage stage : kStages)
    if (!system.list(stage).empty()) return system.list(stage).front().component;
  std::abort();
}

/// Pointers to every scalar that a fit could vary, in a fixed order, with the bounds of its field.
template <class S>
struct Scalar {
  std::string name;
  S* value;
  const FieldInfo* info;
};

template <class S>
std::vector<Scalar<S>> scalars_of(Component<S>& component) {
  std::vector<Scalar<S>> all;
  for (const FieldRef<S>& field : component.fields()) {
    const std::string name(field.info->name);
    const auto push = [&](S& s, const std::string& suffix = "") { all.push_back({name + suffix, &s, field.info}); };
    std::visit(
        [&](auto* v) {
          using T = std::remove_pointer_t<decltype(v)>;
          if constexpr (std::is_same_v<T, S>) {
            push(*v);
          } else if constexpr (std::is_same_v<T, std::optional<S>>) {
            if (*v) push(**v);
          } else if constexpr (std::is_same_v<T, AxisPair<S>>) {
            if (v->given()) push(v->x.value, v->split ? "_x" : "");
            if (v->given() && v->split) push(v->y.value, "_y");
          } else if constexpr (std::is_same_v<T, SpatialFrequency<S>>) {
            if (v->unit != nullptr) push(v->value);
          } else if constexpr (std::is_same_v<T, Coefficients<S>>) {
            for (S& coefficient : *v) push(coefficient, "[]");
          } else if constexpr (std::is_same_v<T, Taps<S>>) {
            for (auto& row : *v)
              for (S& tap : row) push(tap, "[]");
          }
        },
        field.value);
  }
  return all;
}

}  // namespace mtf::test
