// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/system_jet.h"
#include "mtf/components/component_impl.h"

namespace mtf {

template class Component<calib::Jet4>;

}  // namespace mtf
