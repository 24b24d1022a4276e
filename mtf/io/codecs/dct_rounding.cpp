// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/dct_rounding.h"

#include <cmath>

namespace mtf::io {

double dct_rounding_sd(const std::vector<std::uint16_t>& steps) {
  if (steps.empty()) return 0.0;
  double sum = 0.0;
  for (const std::uint16_t step : steps) sum += static_cast<double>(step) * static_cast<double>(step);
  return std::sqrt(sum / (12.0 * static_cast<double>(steps.size())));
}

}  // namespace mtf::io
