// SPDX-License-Identifier: Apache-2.0
#pragma once

// Systems of one component: for every kind of component_kinds() the draws of mtf/components/conformance/draws.h, each
// as a system in its own surroundings. The same list in every run; a new kind or field leaves the cases of the others
// as they are.

#include <cstdlib>
#include <string>
#include <vector>

#include "mtf/components/conformance/subject.h"
#include "mtf/system.h"

namespace mtf::test {

using conformance::Random;

struct Case {
  std::string name;       ///< kind, fields in use, which draw: for messages
  System<double> system;  ///< one component
  Stage stage = Stage::presample;
  std::vector<std::string> given;  ///< optional and shared fields in use
  bool typical = false;            ///< within a factor of three of the examples; otherwise from the whole range
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
std::vector<conformance::Scalar<S>> scalars_of(Component<S>& component) {
  return conformance::scalars_of<S>(component.fields());
}

/// The case as the properties see it; `system`: its own, or the same in another scalar type.
template <class S>
conformance::Subject<S, Component<S>> subject_of(const Case& c, const System<S>& system) {
  return {c.name, c.typical, only_component(system), system.context(),
          conformance::largest_modulus(only_component(c.system), c.system.context())};
}

}  // namespace mtf::test
