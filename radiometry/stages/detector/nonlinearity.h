// SPDX-License-Identifier: Apache-2.0
#pragma once

// Response of a pixel that is not proportional to its charge.
//   e' = e (1 + a2 u + a3 u^2 + a4 u^3),   u = e / full well
// holds for e from 0 to the full well. Below 0 (noise about a dark signal) e' = e, and above the full well the response
// goes on along its last slope, so that it rises everywhere. The inverse is the correction. (EMVA 1288, release 4, on
// linearity; Janesick, Photon Transfer, ch. 7.)

#include "mtf/image.h"
#include "radiometry/fields.h"

namespace radiometry {

struct Nonlinearity {
  double a2 = 0.0, a3 = 0.0, a4 = 0.0;

  static constexpr auto fields() {
    return std::tuple{
        optional(&Nonlinearity::a2, "a2", -10.0, 10.0, "-0.02",
                 "relative change of the response at full well, growing with the charge"),
        optional(&Nonlinearity::a3, "a3", -10.0, 10.0, "-0.02", "the same, growing with the square of the charge"),
        optional(&Nonlinearity::a4, "a4", -10.0, 10.0, "-0.02", "the same, growing with its cube")};
  }
};

/// What a response adds to a charge and to its own slope of 1: R(x) - x and R'(x) - 1, both exactly 0 where it is
/// linear.
template <class S>
struct Bow {
  S value{}, slope{};

  Bow(const Nonlinearity& response, const S& full_well_e, const S& x) {
    if (!(mtf::value_of(x) > 0.0)) return;
    const S held = mtf::value_of(x) < mtf::value_of(full_well_e) ? x : full_well_e;
    const S u = held / full_well_e, first = S(response.a2) * u, second = S(response.a3) * u * u,
            third = S(response.a4) * u * u * u;
    slope = S(2) * first + S(3) * second + S(4) * third;
    value = held * (first + second + third) + (x - held) * slope;
  }
};

/// A response ready for use. Throws UsageError for coefficients out of bounds or with which it does not rise up to the
/// full well everywhere, and for a full well that is not above 0 and finite.
class Response {
 public:
  Response(const Nonlinearity& nonlinearity, double full_well_e);

  double operator()(double electrons) const;
  double inverse(double response_e) const;

 private:
  /// Of the response, at a part u of the full well.
  double slope(double u) const { return 1.0 + u * (2.0 * a2_ + u * (3.0 * a3_ + u * 4.0 * a4_)); }

  double a2_, a3_, a4_, full_well_e_, at_full_, slope_at_full_;
};

/// image = response(image), NaN stays NaN.
void apply_response(mtf::ImageView<float> image, const Response& response, int threads = 1);
/// The electrons that gave this response.
void linearise(mtf::ImageView<float> image, const Response& response, int threads = 1);

}  // namespace radiometry
