// SPDX-License-Identifier: Apache-2.0
#pragma once

// Unsharp mask: the image plus `amount` times its difference to a blurred copy of itself.
//   otf = 1 + amount (1 - B(fx px) B(fy py))
//   size:   B(x) = sin(n pi x)/(n sin(pi x))
//   sigma:  B(x) = sum over m of g(x - m) / sum over m of g(m),  g(x) = exp(-2 pi^2 sigma^2 x^2)
// p = pitch, so that x is in cycles/pixel. The blur is that of the digital image, a box of n x n pixels, n odd, or all
// taps exp(-k^2/(2 sigma^2)); its taps sum to 1, so that B has period 1 and B(0) = 1 exactly. Real, even, keeps the
// mean; amplifies fine detail, and noise with it, up to 1 + amount (4/3 amount for the lobes of a box of three). Not
// separable. By Poisson's sum; below sigma = 0.5 the taps themselves are summed. (Pratt, Digital Image Processing.)

#include "mtf/components/field.h"

namespace mtf {

/// Frequency response of normalised Gaussian taps, and its derivatives. x in cycles/pixel, sigma > 0 in pixels.
struct GaussianTaps {
  double value = 0.0, by_x = 0.0, by_sigma = 0.0;
  GaussianTaps(double x_cy_px, double sigma_px) {
    const double x = std::isfinite(x_cy_px) ? std::remainder(x_cy_px, 1.0) : 0.5;
    double top = 0.0, top_x = 0.0, top_sigma = 0.0, bottom = 0.0, bottom_sigma = 0.0;
    if (sigma_px < 0.5) {
      for (int k = -6; k <= 6; ++k) {  // exp(-k^2 / (2 x 0.25)) < 1e-42 beyond
        const double tap = std::exp(-0.5 * (k / sigma_px) * (k / sigma_px)),
                     slope = tap * k * k / std::pow(sigma_px, 3);
        const double c = cos_pi(2.0 * k * x);
        top += tap * c;
        top_x -= tap * 2.0 * kPi * k * sin_pi(2.0 * k * x);
        top_sigma += slope * c;
        bottom += tap;
        bottom_sigma += slope;
      }
    } else {
      const double c = -4.0 * kPi * kPi * sigma_px;
      for (int m = -3; m <= 3; ++m) {  // |x| <= 1/2, exp(-2 pi^2 x 0.25 x 3.5^2) < 1e-26 beyond
        const double there = gaussian(sigma_px * (x - m)).value, centre = gaussian(sigma_px * m).value;
        top += there;
        top_x += c * sigma_px * (x - m) * there;
        top_sigma += c * (x - m) * (x - m) * there;
        bottom += centre;
        bottom_sigma += c * m * m * centre;
      }
    }
    value = top / bottom;
    by_x = top_x / bottom;
    by_sigma = (top_sigma - value * bottom_sigma) / bottom;
  }
};

template <class S>
struct Unsharp {
  static constexpr std::string_view kind = "unsharp";
  static constexpr std::string_view doc = "unsharp mask with a box or Gaussian blur, on the detector grid";
  static constexpr Stages stages{.postsample = true};
  static constexpr SensorPart part = SensorPart::electronics;

  S amount{};
  int size = 3;
  OptionalIn<S, pixels> sigma_px{};

  static constexpr auto fields() {
    return std::tuple{required(&Unsharp::amount, "amount", 0.0, 100.0, "0.8",
                               "weight of the difference between the image and its blurred copy"),
                      excluding("sigma", optional(&Unsharp::size, "size", 1.0, 1001.0, "3",
                                                  "side of the box that blurs, in pixels; odd")),
                      excluding("size", optional(&Unsharp::sigma_px, "sigma", "px", 0.05, 1000.0, "\"1.5 px\"",
                                                 "standard deviation of Gaussian taps that blur, instead of the box"))};
  }
  Traits traits(const Context<S>& ctx) const {
    return {.even_x = true, .even_y = true, .square = ctx.frame.square(), .gain = true};
  }
  S blur(const S& x) const {
    if (!sigma_px) return dirichlet_of(size, x);
    const GaussianTaps b(value_of(x), value_of(*sigma_px));
    return lift(b.value, b.by_x, x, b.by_sigma, *sigma_px);
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S x = ctx.frame.cy_per_px(f.x, Axis::x), y = ctx.frame.cy_per_px(f.y, Axis::y);
    return {S(1) + amount * (S(1) - blur(x) * blur(y)), S(0)};
  }
  /// 1 - B = sum of taps x (1 - cos 2 pi k x) <= 2 pi^2 x^2 x the variance of the taps, which for the sampled Gaussian
  /// is at most sigma^2; 1 - Bx By <= (1 - Bx) + (1 - By), never above 1 + 1/3, the lobe of three taps.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double variance = sigma_px ? value_of(*sigma_px) * value_of(*sigma_px) : (1.0 * size * size - 1.0) / 12.0;
    const double x = fx * 1e-3 * value_of(ctx.frame.pitch_x_um), y = fy * 1e-3 * value_of(ctx.frame.pitch_y_um);
    return value_of(amount) * std::min(4.0 / 3.0, 2.0 * kPi * kPi * variance * (x * x + y * y));
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (size % 2 == 0) return {{.field = "size", .text = "has to be odd, so that the box has a middle"}};
    if (sigma_px && size != 3) return {{.field = "size", .text = "give either size or sigma"}};
    return {};
  }
};

}  // namespace mtf
