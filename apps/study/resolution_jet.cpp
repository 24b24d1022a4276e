// SPDX-License-Identifier: Apache-2.0
#include "calib/system_jet.h"
#include "mtf/resolution_impl.h"

namespace mtf {

template class ResolutionMeter<calib::Jet4>;

}  // namespace mtf
