// SPDX-License-Identifier: Apache-2.0
#include "tests/mtf/conformance.h"

#include <algorithm>

namespace mtf::test {
namespace {

Stage first_stage(const Component<double>& component) {
  return *std::find_if(kStages.begin(), kStages.end(), [&](Stage stage) { return component.stages().allows(stage); });
}

Case case_of(const conformance::Draw& draw, Component<double> component) {
  Case c{.name = draw.name, .system = {}, .stage = first_stage(component), .given = {}, .typical = draw.typical()};
  const auto fields = component.fields();
  const Context<double> ctx = conformance::give_values(draw, fields);
  for (std::size_t i = 0; i < fields.size(); ++i)
    if ((draw.given >> i & 1) != 0 && fields[i].info->presence != Presence::required)
      c.given.emplace_back(fields[i].info->name);
  c.system.frame = ctx.frame;
  c.system.optics = ctx.optics;
  c.system.add(c.stage, std::move(component));
  return c;
}

std::vector<Case> make_cases() {
  std::vector<Case> cases;
  for (const std::string_view kind : component_kinds()) {
    const auto make = [&](const conformance::Draw& draw) { return case_of(draw, Component<double>::make(kind)); };
    const auto accepted = [&](const conformance::Draw& draw) { return make(draw).system.errors().empty(); };
    for (const auto& draw : conformance::draws_of(kind, Component<double>::make(kind).fields(), accepted))
      cases.push_back(make(draw));
  }
  return cases;
}

}  // namespace

const std::vector<Case>& conformance_cases() {
  static const std::vector<Case> cases = make_cases();
  return cases;
}

}  // namespace mtf::test
