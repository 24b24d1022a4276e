// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/path_air.h"

#include <algorithm>

#include "mtf/components/aerosol.h"
#include "mtf/components/turbulence.h"

namespace mtf {

bool takes_path_air(const System<double>& system) {
  const auto& list = system.list(Stage::presample);
  return std::any_of(list.begin(), list.end(), [](const Entry<double>& entry) {
    if (const auto* aerosol = entry.component.get_if<Aerosol<double>>())
      return !aerosol->scattering_1_km || !aerosol->path_length_km;
    const auto* turbulence = entry.component.get_if<Turbulence<double>>();
    return turbulence != nullptr && turbulence->cn2 && !turbulence->path_length_m;
  });
}

}  // namespace mtf
