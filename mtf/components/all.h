// SPDX-License-Identifier: Apache-2.0
#pragma once

// The closed list of components: the only registry. Included by component_impl.h, mtf/mtf.h and tests; others see
// Component<S>.

#include "mtf/components/accelerated_motion.h"
#include "mtf/components/aerosol.h"
#include "mtf/components/binning.h"
#include "mtf/components/birefringent_filter.h"
#include "mtf/components/bolometer.h"
#include "mtf/components/boost.h"
#include "mtf/components/charge_transfer.h"
#include "mtf/components/circular_footprint.h"
#include "mtf/components/crosstalk.h"
#include "mtf/components/curve.h"
#include "mtf/components/defocus.h"
#include "mtf/components/diffraction.h"
#include "mtf/components/diffusion.h"
#include "mtf/components/display_crt.h"
#include "mtf/components/display_flat_panel.h"
#include "mtf/components/eye.h"
#include "mtf/components/fir.h"
#include "mtf/components/footprint.h"
#include "mtf/components/gaussian.h"
#include "mtf/components/halo.h"
#include "mtf/components/image_intensifier.h"
#include "mtf/components/interpolation.h"
#include "mtf/components/jitter.h"
#include "mtf/components/linear_motion.h"
#include "mtf/components/lowpass.h"
#include "mtf/components/polygon_footprint.h"
#include "mtf/components/psf.h"
#include "mtf/components/random_wavefront.h"
#include "mtf/components/rc_highpass.h"
#include "mtf/components/rms_wavefront.h"
#include "mtf/components/sample_and_hold.h"
#include "mtf/components/tdi.h"
#include "mtf/components/turbulence.h"
#include "mtf/components/unsharp.h"
#include "mtf/components/vibration.h"
#include "mtf/components/wavefront.h"

namespace mtf {

template <class S>
struct ComponentVariant {
  std::variant<Diffraction<S>, Defocus<S>, Wavefront<S>, RmsWavefront<S>, RandomWavefront<S>, Gaussian<S>,
               Turbulence<S>, Aerosol<S>, Footprint<S>, CircularFootprint<S>, PolygonFootprint<S>, Binning<S>,
               Diffusion<S>, Crosstalk<S>, Tdi<S>, Bolometer<S>, Jitter<S>, LinearMotion<S>, AcceleratedMotion<S>,
               Flow<S>, Vibration<S>, RcLowpass<S>, RcHighpass<S>, Butterworth<S>, CurveOtf<S>, ChargeTransfer<S>,
               Fir<S>, Boost<S>, SampleAndHold<S>, Unsharp<S>, Interpolation<S>, DisplayCrt<S>, DisplayFlatPanel<S>,
               Eye<S>, BirefringentFilter<S>, Halo<S>, ImageIntensifier<S>, Psf<S>>
      value;
};

}  // namespace mtf
