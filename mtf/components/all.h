// SPDX-License-Identifier: Apache-2.0
#pragma once

// The closed list of components: the only registry. Included by system_impl.h and tests; others see Component<S>.

#include "mtf/components/curve.h"
#include "mtf/components/diffraction.h"
#include "mtf/components/fir.h"
#include "mtf/components/footprint.h"
#include "mtf/components/gaussian.h"
#include "mtf/components/jitter.h"
#include "mtf/components/linear_motion.h"
#include "mtf/components/lowpass.h"
#include "mtf/components/rms_wavefront.h"

namespace mtf {

template <class S>
struct ComponentVariant {
  std::variant<Diffraction<S>, RmsWavefront<S>, Gaussian<S>, Footprint<S>, Jitter<S>, LinearMotion<S>, RcLowpass<S>,
               Butterworth<S>, CurveOtf<S>, Fir<S>>
      value;
};

}  // namespace mtf
