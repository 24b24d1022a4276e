// SPDX-License-Identifier: Apache-2.0
#include "mtf/component_impl.h"

namespace mtf {

template class Component<float>;

}  // namespace mtf
