// SPDX-License-Identifier: Apache-2.0
#include "mtf/resolution.h"

#include "mtf/resolution_impl.h"

namespace mtf {

template class ResolutionMeter<double>;

}  // namespace mtf
