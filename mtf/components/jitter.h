// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random line-of-sight motion, Gaussian.
//   otf = exp(-2 pi^2 (sx^2 fx^2 + sy^2 fy^2))
// s = rms displacement of one axis (one sigma), at the focal plane. Real, positive, separable; radial when sx = sy.
// Valid for many independent positions in one integration time. (Kopeika, A System Engineering Approach to Imaging, ch.
// 14.)

#include "mtf/components/gaussian.h"

namespace mtf {

template <class S>
struct Jitter {
  static constexpr std::string_view kind = "jitter";
  static constexpr std::string_view doc = "random line-of-sight motion, rms per axis";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::motion;

  AxisPair<S> rms{};

  static constexpr auto fields() {
    return std::tuple{Field{
        required_row("rms", Dimension::extent, "", 0.0, 1e9, "\"8 urad\"", "rms displacement of one axis, one sigma"),
        &Jitter::rms}};
  }
  Traits traits(const Context<S>& ctx) const { return GaussianOtf<S>::traits(rms, ctx); }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return GaussianOtf<S>::otf(rms, f, ctx); }
  double cutoff_cy_mm(const Context<S>&) const { return kInfinity; }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    return GaussianOtf<S>::deviation(rms, fx, fy, ctx);
  }
  std::vector<Problem> check(const Context<S>&) const { return {}; }
};

}  // namespace mtf
