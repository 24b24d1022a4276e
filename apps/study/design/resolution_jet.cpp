// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/system_jet.h"
#include "mtf/metrics/resolution_impl.h"

namespace mtf {

template class ResolutionMeter<calib::Jet4>;

}  // namespace mtf
