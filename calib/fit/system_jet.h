// SPDX-License-Identifier: Apache-2.0
#pragma once

// Systems whose parameters carry derivatives. Jet4 holds a value and four partial derivatives, the stride of
// ceres::DynamicAutoDiffCostFunction: a fit of n parameters evaluates the system ceil(n / 4) times. The bodies are
// compiled once, in component_jet.cpp and system_jet.cpp.

#include <ceres/jet.h>

#include "mtf/system.h"

namespace calib {

using Jet4 = ceres::Jet<double, 4>;

}  // namespace calib

namespace mtf {

extern template class Component<calib::Jet4>;
extern template struct System<calib::Jet4>;
/// All derivatives zero; the caller seeds those of its parameters.
extern template System<calib::Jet4> cast<calib::Jet4, double>(const System<double>&);
/// The values without their derivatives.
extern template System<double> cast<double, calib::Jet4>(const System<calib::Jet4>&);

}  // namespace mtf
