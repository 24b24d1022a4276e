// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every component header needs: the field table's row type, and default answers for the contract of
// mtf/component.h.

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include "mtf/component.h"
#include "mtf/special.h"

namespace mtf {

/// FieldInfo plus where the value lives.
template <class Member>
struct Field {
  FieldInfo info;
  Member member;
};
template <class Member>
Field(FieldInfo, Member) -> Field<Member>;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The shared optics of a field marked Presence::shared; a component's own value wins. Evaluated only after check().
template <class S>
S f_number_of(const std::optional<S>& own, const Context<S>& ctx) {
  if (own) return *own;
  if (ctx.optics.f_number) return *ctx.optics.f_number;
  if (ctx.optics.aperture_mm) return ctx.frame.focal_length_mm / *ctx.optics.aperture_mm;
  return S(0);
}

template <class S>
S obscuration_of(const std::optional<S>& own, const Context<S>& ctx) {
  return own ? *own : ctx.optics.obscuration.value_or(S(0));
}

/// nu = f lambda N, the frequency relative to the incoherent cutoff 1/(lambda N).
/// Conditioning: nu carries the relative rounding of three factors, about 3 x 2^-53; near the cutoff the MTF falls as
/// (1 - nu)^1.5, so its relative error there is 1.5 x 3 x 2^-53 / (1 - nu).
template <class S>
S relative_frequency(const S& f_cy_mm, const S& wavelength_um, const S& f_number) {
  return f_cy_mm * (wavelength_um * S(1e-3)) * f_number;
}

/// Bound of |1 - sinc| up to x: monotone to 1, never above 1 + 0.2173 (the deepest side lobe).
inline double sinc_deviation(double x) { return x < 1.0 ? 1.0 - sinc(x).value : 1.2173; }

}  // namespace mtf
