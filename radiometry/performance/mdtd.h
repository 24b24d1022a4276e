// SPDX-License-Identifier: Apache-2.0
#pragma once

// MDTD, the temperature difference at which a square of the width W on a large uniform background is just detected. As
// for bars (mrtd.h), the eye averages noise over the target and over its own integration time and compares the mean of
// the target's image with what is left:
//   MDTD(W) = SNR_th sqrt(N) / (I_x I_y),   I = W x integral of sinc^2(W f) H(f) df
//   N = (tvh^2 E_t + vh^2) E_x E_y + (th^2 E_t + h^2) E_x + (tv^2 E_t + v^2) E_y
// with E_t, E_x and E_y of mrtd.h for w = W along both axes. I is the mean, over the square, of its blurred image, 1
// for a large one; a square far smaller than the blur is a point source, whose MDTD rises with 1/W^2. Noise of rows and
// of columns counts, as a square resembles neither. H is the OTF about the centroid of the point spread, with its sign:
// where it is below 0, its part of the image darkens the square. (Lloyd, Thermal Imaging Systems, ch. 5, gives the
// definition, the mean image and the spatial and temporal integration; the components of the noise are those of
// FLIR92.) H is taken as separable. Sampling is not in it: a square of a few pixels falls between them now and then.

#include "radiometry/performance/mrtd.h"

namespace radiometry {

/// In K, for W in mrad, above 0. The OTF of the system and the MTFs that filter noise are callables double -> S of
/// cycles/mrad; the system's counts up to `band_cy_mrad`. 0 without noise, infinite where no light of the square comes
/// through. Throws UsageError for values out of range. `bar_aspect` has no part in it.
template <class S, class SystemX, class SystemY, class NoiseX, class NoiseY>
S mdtd_k(const MrtdInput<S>& in, double w_mrad, const S& band_cy_mrad, const SystemX& system_x, const SystemY& system_y,
         const NoiseX& noise_x, const NoiseY& noise_y) {
  using std::sqrt;
  require_valid("mdtd", in);
  if (!(w_mrad > 0.0 && w_mrad < mtf::kInfinity))
    throw mtf::UsageError("mdtd: a target of " + mtf::format_double(w_mrad) +
                          " mrad; it has to be above 0, and finite");
  const auto averaged = [&](const S& spacing_mrad, const S& given, const auto& noise_mtf) {
    const S band = mtf::value_of(given) > 0.0 ? given : S(S(0.5) / spacing_mrad);
    return S(spacing_mrad * averaged_bandwidth(w_mrad, band, noise_mtf));
  };
  const S e_x = averaged(in.spacing_x_mrad, in.noise_band_x_cy_mrad, noise_x);
  const S e_y = averaged(in.spacing_y_mrad, in.noise_band_y_cy_mrad, noise_y);
  const S e_t = kept_by_eye(in);
  const S variance = (in.tvh_k * in.tvh_k * e_t + in.vh_k * in.vh_k) * e_x * e_y +
                     (in.th_k * in.th_k * e_t + in.h_k * in.h_k) * e_x +
                     (in.tv_k * in.tv_k * e_t + in.v_k * in.v_k) * e_y;
  if (!(mtf::value_of(variance) > 0.0)) return S(0);
  const S image = S(w_mrad * w_mrad) * averaged_over(w_mrad, band_cy_mrad, system_x) *
                  averaged_over(w_mrad, band_cy_mrad, system_y);
  if (!(mtf::value_of(image) > 0.0)) return S(mtf::kInfinity);
  return in.snr_threshold * sqrt(variance) / image;
}

}  // namespace radiometry
