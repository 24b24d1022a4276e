// SPDX-License-Identifier: Apache-2.0

// A component of a user's own is held to the properties of the toolkit's, and one that declares too much is found.

#include "own_component.h"

#include <cstdio>

#include "mtf/io/config/round_trip.h"

namespace {

/// The same, but it claims to be separable, and a plan would filter rows and columns apart.
template <class S>
struct SaidToBeSeparable : SubstrateSpread<S> {
  mtf::Traits traits(const mtf::Context<S>& ctx) const {
    mtf::Traits traits = SubstrateSpread<S>::traits(ctx);
    traits.separable = true;
    return traits;
  }
};

}  // namespace

int main() {
  auto outcomes = mtf::conformance::check<SubstrateSpread>();
  outcomes.push_back(mtf::io::check_round_trip<SubstrateSpread>());
  std::fputs(mtf::conformance::describe_failures(outcomes).c_str(), stdout);
  if (!mtf::conformance::all_ok(outcomes)) return 1;

  for (const mtf::conformance::Outcome& outcome : mtf::conformance::check<SaidToBeSeparable>())
    if (outcome.ok() == outcome.property.starts_with("declared symmetry is true")) return 1;
  return 0;
}
