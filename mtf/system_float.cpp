// SPDX-License-Identifier: Apache-2.0
#include "mtf/system_check.h"

namespace mtf {

template class Component<float>;
template struct System<float>;
template System<float> cast<float, double>(const System<double>&);

}  // namespace mtf
