// SPDX-License-Identifier: Apache-2.0
#include "mtf/metrics/resolution.h"

#include "mtf/metrics/resolution_impl.h"

namespace mtf {

template class ResolutionMeter<double>;

}  // namespace mtf
