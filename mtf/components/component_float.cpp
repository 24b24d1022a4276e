// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/component_impl.h"

namespace mtf {

template class Component<float>;

}  // namespace mtf
