// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/lane_steps_impl.h"

namespace mtf::lanes {

template void run_step<double, Pass::forward>(const Step<double>&, double*, std::int64_t, const double*,
                                              const std::int32_t*);
template void run_step<double, Pass::gather>(const Step<double>&, double*, std::int64_t, const double*,
                                             const std::int32_t*);
template void run_step<double, Pass::inverse>(const Step<double>&, double*, std::int64_t, const double*,
                                              const std::int32_t*);

}  // namespace mtf::lanes
