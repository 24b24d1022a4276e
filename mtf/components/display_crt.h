// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spot of a cathode-ray tube, a Gaussian of the screen's luminance.
//   otf = exp(-2 pi^2 (sx^2 fx^2 + sy^2 fy^2))
// s = standard deviation of the spot per axis; from a full width at half maximum, s = FWHM/2.3548. Sizes are given at
// the focal plane, which the screen shows magnified: "0.5 px" is half a pixel of the image as shown. Real, positive,
// separable; radial when sx = sy. (Holst, Electro-Optical Imaging System Performance.)

#include "mtf/components/gaussian.h"

namespace mtf {

template <class S>
struct DisplayCrt {
  static constexpr std::string_view kind = "display_crt";
  static constexpr std::string_view doc = "Gaussian spot of a cathode-ray tube";
  static constexpr Stages stages{.postsample = true};
  static constexpr SensorPart part = SensorPart::display;
  static constexpr bool is_reconstruction = true;

  AxisPair<S> sigma{};

  static constexpr auto fields() {
    return std::tuple{required(&DisplayCrt::sigma, "sigma", 0.0, 1e9, "\"0.4 px\"",
                               "standard deviation of the spot, per axis; px are those of the image")};
  }
  Traits traits(const Context<S>& ctx) const { return GaussianOtf<S>::traits(sigma, ctx); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return GaussianOtf<S>::otf(sigma, f, ctx); }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return GaussianOtf<S>::deviation(sigma, fx, fy, ctx);
  }
};

}  // namespace mtf
