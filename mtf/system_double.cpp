// SPDX-License-Identifier: Apache-2.0
#include "mtf/system_check.h"

namespace mtf {

template class Component<double>;
template struct System<double>;

std::string_view stage_name(Stage stage) {
  return stage == Stage::presample ? "presample" : stage == Stage::readout ? "readout" : "postsample";
}

Choice choice_of(std::span<const std::string_view> names, std::string_view word) {
  const auto found = std::find(names.begin(), names.end(), word);
  if (found != names.end()) return {static_cast<int>(found - names.begin()), names};
  std::string known;
  for (const std::string_view name : names) known += (known.empty() ? "" : ", ") + std::string(name);
  throw UsageError("\"" + std::string(word) + "\" is none of: " + known);
}

std::vector<std::string_view> component_kinds() {
  std::vector<std::string_view> kinds;
  detail::for_each_type<double>([&]<class C>(std::type_identity<C>) { kinds.push_back(C::kind); });
  return kinds;
}

void require_valid(const System<double>& system) {
  std::string message;
  for (const auto& finding : system.errors())
    message += (message.empty() ? "" : "; ") + finding.where + ": " + finding.problem.text;
  if (!message.empty()) throw UsageError(message);
}

}  // namespace mtf
