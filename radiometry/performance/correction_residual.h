// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a two-point correction (correction.h) leaves of the spatial noise, in closed form. A pixel of responsivity 1 + p
// with an offset o and q more dark charge than the mean reads raw(e) = R(e + p (e - d) + q) + o for a mean charge e, d
// of it dark current, R being the response of nonlinearity.h. Its flat frames at the charges c and h are means of n
// frames with noise n_c and n_h. Corrected, less the mean of all pixels, it keeps
//   p (D(e) - (1 - w) D(c) - w D(h)) + q (R'(e) - (1 - w) R'(c) - w R'(h)) - (1 - w) n_c - w n_h,
//   D(x) = R'(x) (x - d),   w = (R(e) - R(c)) / (R(h) - R(c))
// So an offset leaves nothing, PRNU and dark charge only what the bow of the response makes of them (to first order),
// and the flat frames their own noise: sqrt(((1 - w)^2 v_c + w^2 v_h) / n), v the variance of one frame. All is divided
// by R'(e), as charge like the rest of the budget.

#include "radiometry/performance/sensitivity.h"
#include "radiometry/stages/detector/nonlinearity.h"

namespace radiometry {

/// The flat frames, and the pixel that they correct.
template <class S>
struct FlatFrames {
  S low_e{}, high_e{};  ///< charge of the mean pixel in them
  S dark_e{};
  S full_well_e{};
  S variance{};  ///< of one frame beside the shot noise, e-^2, without what is common to all pixels of a frame
  double frames = 1.0;
  S shared{};        ///< covariance of the two means: 1/f noise goes on from one to the other
  bool shot = true;  ///< the charge has shot noise; the volts of a thermal detector have none
  Nonlinearity response{};
};

template <class S>
struct CorrectionResidual {
  S prnu{};     ///< e- per unit of p
  S dcnu{};     ///< per unit of q
  S flats_e{};  ///< of the flat frames, rms
};

/// At a mean charge of the scene.
template <class S>
CorrectionResidual<S> correction_residual(const FlatFrames<S>& flats, const S& charge_e) {
  const auto bow_at = [&](const S& x) { return Bow<S>(flats.response, flats.full_well_e, x); };
  // D(x) - R(x) + d, exactly 0 where the response is linear.
  const auto spread = [&](const Bow<S>& bow, const S& x) { return S(bow.slope * (x - flats.dark_e) - bow.value); };
  const Bow<S> here = bow_at(charge_e), low = bow_at(flats.low_e), high = bow_at(flats.high_e);
  const S w = (charge_e - flats.low_e + here.value - low.value) / (flats.high_e - flats.low_e + high.value - low.value);
  const S rest = S(1) - w, slope = S(1) + here.slope;
  const auto variance = [&](const Bow<S>& bow, const S& charge) {
    const S gain = S(1) + bow.slope;
    return flats.shot ? S(gain * gain * charge + flats.variance) : flats.variance;
  };
  const S flat2 = rest * rest * variance(low, flats.low_e) + w * w * variance(high, flats.high_e);
  return {(spread(here, charge_e) - rest * spread(low, flats.low_e) - w * spread(high, flats.high_e)) / slope,
          (here.slope - rest * low.slope - w * high.slope) / slope,
          detail::root(S(flat2 / S(flats.frames) + S(2) * rest * w * flats.shared)) / slope};
}

/// The spatial terms of the budget as the correction leaves them.
template <class S>
void apply_correction(Budget<S>& budget, const S& prnu, const FlatFrames<S>& flats) {
  using std::abs;
  const CorrectionResidual<S> left = correction_residual(flats, budget.signal.total_e());
  budget.prnu_e = abs(prnu * left.prnu);
  budget.dsnu_e = abs(budget.dcnu_e * left.dcnu);
  budget.correction_e = left.flats_e;
  budget.late_spatial_e = detail::root(S(left.flats_e * left.flats_e + budget.rounding_e * budget.rounding_e));
  set_spatial(budget);
}

}  // namespace radiometry
