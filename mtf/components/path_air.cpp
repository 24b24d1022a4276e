// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/path_air.h"

#include <algorithm>

#include "mtf/components/aerosol.h"
#include "mtf/components/turbulence.h"

namespace mtf {

namespace {

enum class PathOf { none, air, itself };

/// Whose path the component has.
PathOf path_of(const Component<double>& component) {
  if (const auto* aerosol = component.get_if<Aerosol<double>>())
    return aerosol->scattering_1_km && aerosol->path_length_km ? PathOf::itself : PathOf::air;
  if (const auto* turbulence = component.get_if<Turbulence<double>>())
    return turbulence->cn2 && !turbulence->path_length_m ? PathOf::air : PathOf::itself;
  return PathOf::none;
}

}  // namespace

bool takes_path_air(const System<double>& system) {
  const auto& list = system.list(Stage::presample);
  return std::ranges::any_of(list, [](const Entry<double>& entry) { return path_of(entry.component) == PathOf::air; });
}

std::string own_path(const System<double>& system) {
  for (const Entry<double>& entry : system.list(Stage::presample))
    if (path_of(entry.component) == PathOf::itself) return entry.label;
  return "";
}

}  // namespace mtf
