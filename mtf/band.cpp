// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "mtf/quadrature.h"
#include "mtf/system.h"

namespace mtf {

WavelengthNodes wavelength_nodes(const Band& band, int n) {
  if (band.rate) return (*band.rate)(n);
  GaussRule rule = mean_rule(band.lo_um, band.hi_um, n);
  return {std::move(rule.node), std::move(rule.weight)};
}

}  // namespace mtf
