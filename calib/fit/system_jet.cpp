// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/system_jet.h"

#include "mtf/otf/system_impl.h"

namespace mtf {

template struct System<calib::Jet4>;
template System<calib::Jet4> cast<calib::Jet4, double>(const System<double>&);
template System<double> cast<double, calib::Jet4>(const System<calib::Jet4>&);

}  // namespace mtf
