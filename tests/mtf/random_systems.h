// SPDX-License-Identifier: Apache-2.0
#pragma once

// Valid systems of 1 to 8 components in all three lists, drawn from the conformance cases: every kind, with typical
// values and values from the whole parameter box, each in the frame and optics of one of them. Seeded.

#include <algorithm>
#include <complex>
#include <map>

#include "mtf/field/sample_ranges.h"
#include "tests/mtf/conformance.h"

namespace mtf::test {

/// The conformance cases, kind by kind, without those that are slow: pupils by quadrature at the ends of their box cost
/// milliseconds a value. Nor those that are out of focus by the range of each sample: plans of these take ranges.
inline const std::vector<std::vector<const Case*>>& quick_cases_by_kind() {
  static const std::vector<std::vector<const Case*>> by_kind = [] {
    std::map<std::string_view, std::vector<const Case*>> groups;
    for (const Case& c : conformance_cases()) {
      const Component<double>& component = only_component(c.system);
      const bool slow = component.is_slow() && !c.typical;
      if (!slow && !entry_by_range(c.system)) groups[component.kind()].push_back(&c);
    }
    std::vector<std::vector<const Case*>> list;
    for (auto& [kind, group] : groups) list.push_back(std::move(group));
    return list;
  }();
  return by_kind;
}

inline bool has_no_errors(const System<double>& system) {
  for (const auto& finding : system.check())
    if (finding.problem.error) return false;
  return true;
}

/// First a kind, so that one with many combinations of fields does not crowd out the others; then one of its cases.
/// Each is the one whose name draws the largest number (rendezvous hashing; Thaler and Ravishankar, IEEE/ACM Trans.
/// Networking 6, 1 (1998)): a new kind or case takes its own share of the draws and leaves the others as they are.
inline const Case& draw_case(Random& random) {
  const auto drawn = [salt = random.bits()](const auto& list, auto name_of) -> decltype(auto) {
    return *std::max_element(list.begin(), list.end(), [&](const auto& a, const auto& b) {
      return Random(name_of(a), salt).bits() < Random(name_of(b), salt).bits();
    });
  };
  const auto& group =
      drawn(quick_cases_by_kind(), [](const auto& g) { return only_component(g.front()->system).kind(); });
  return *drawn(group, [](const Case* c) { return std::string_view(c->name); });
}

/// The system of that number, one wavelength; with a band when asked for.
inline System<double> random_system(int number, bool band = false) {
  Random random(0x5eed0000u + static_cast<std::uint64_t>(number));
  System<double> system = draw_case(random).system;
  for (auto& list : system.stages) list.clear();
  if (band) {
    const double middle = random.decades(0.3, 12.0), half = 0.5 * middle * random.uniform(0.02, 0.6);
    system.optics.wavelength_um.reset();
    system.band = Band{middle - half, middle + half};
    system.band_nodes = 1 + random.below(24);
  }
  for (int wanted = 1 + random.below(8), tries = 0; wanted > 0 && tries < 100; ++tries) {
    const Component<double>& component = only_component(draw_case(random).system);
    const Stage stage = kStages[static_cast<std::size_t>(random.below(3))];
    if (!component.stages().allows(stage)) continue;
    System<double> larger = system;
    larger.add(stage, component);
    if (!has_no_errors(larger)) continue;
    system = std::move(larger);
    --wanted;
  }
  return system;
}

/// The product of the parts of one list, straight from its definition, and the sum of the moduli that went into it: the
/// scale of its rounding.
struct Product {
  std::complex<long double> value = 1.0L;
  long double scale = 1.0L;
  int factors = 0;
};

inline Product product_of_parts(const System<double>& system, std::span<const Stage> stages, const Freq<double>& f) {
  Product product;
  const auto multiply = [&](Product& into, const Component<double>& component, const Context<double>& ctx) {
    const Complex<double> h = component.otf(f, ctx);
    into.value *= std::complex<long double>(h.re, h.im);
    into.scale *= std::hypot(static_cast<long double>(h.re), static_cast<long double>(h.im));
    ++product.factors;
  };
  for (const Stage stage : stages) {
    std::vector<const Component<double>*> chromatic;
    for (const Entry<double>& entry : system.list(stage))
      if (system.band && entry.component.traits(system.context()).chromatic)
        chromatic.push_back(&entry.component);
      else
        multiply(product, entry.component, system.context());
    if (chromatic.empty()) continue;
    const WavelengthNodes nodes = wavelength_nodes(*system.band, system.band_nodes);
    Product mean{0.0L, 0.0L, 0};
    for (std::size_t w = 0; w < nodes.weight.size(); ++w) {
      Product node;
      for (const auto* component : chromatic) multiply(node, *component, system.context(nodes.wavelength_um[w]));
      mean.value += static_cast<long double>(nodes.weight[w]) * node.value;
      mean.scale += static_cast<long double>(nodes.weight[w]) * node.scale;
    }
    product.value *= mean.value;
    product.scale *= mean.scale;
  }
  return product;
}

}  // namespace mtf::test
