// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/lane_steps_impl.h"

namespace mtf::lanes {

template void run_step<float, Pass::forward>(const Step<float>&, float*, std::int64_t, const float*,
                                             const std::int32_t*);
template void run_step<float, Pass::gather>(const Step<float>&, float*, std::int64_t, const float*,
                                            const std::int32_t*);
template void run_step<float, Pass::inverse>(const Step<float>&, float*, std::int64_t, const float*,
                                             const std::int32_t*);

}  // namespace mtf::lanes
