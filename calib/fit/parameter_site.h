// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the number that a path of the sensor file names is held, and the bounds that its field gives it.

#include <string_view>
#include <vector>

#include "mtf/system.h"

namespace calib {

template <class S>
struct ParameterSite {
  std::vector<S*> numbers;  ///< empty when there is no such number; two for "frame.pitch"
  mtf::FieldInfo info{};    ///< bounds, in the unit that the number is held in
};

/// See parameter_at in fit.h. The pointers hold until the system is copied or its lists change. For double and Jet4.
template <class S>
ParameterSite<S> parameter_site(mtf::System<S>& system, std::string_view path);

}  // namespace calib
