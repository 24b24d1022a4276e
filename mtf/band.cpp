// SPDX-License-Identifier: Apache-2.0
#include "mtf/quadrature.h"
#include "mtf/system.h"

namespace mtf {

WavelengthNodes wavelength_nodes(const Band& band, int n) {
  const GaussRule& rule = gauss_legendre(n);
  const double middle = 0.5 * (band.lo_um + band.hi_um), half = 0.5 * (band.hi_um - band.lo_um);
  WavelengthNodes nodes;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    nodes.wavelength_um.push_back(middle - half * rule.node[i]);
    nodes.weight.push_back(0.5 * rule.weight[i]);
  }
  return nodes;
}

}  // namespace mtf
