// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/convection.h"

#include <cmath>

#include "mtf/error.h"
#include "mtf/units.h"

namespace radiometry::heat {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};

void require_not_negative(double value, std::string_view where, std::string_view name) {
  if (!(value >= 0.0) || !std::isfinite(value))
    throw mtf::UsageError(std::string(where) + ": " + std::string(name) + " is " + mtf::format_double(value) +
                          ", has to be a finite number that is not negative");
}

}  // namespace

std::string name_of(const Convection& convection) {
  return std::visit(
      Overloaded{[](const NoConvection&) { return "none"; }, [](const LinearConvection&) { return "linear"; },
                 [](const McAdams&) { return "mcadams"; }, [](const Tarp&) { return "tarp"; }},
      convection);
}

std::optional<Validity> wind_validity(const Convection& convection) {
  constexpr double kStrongest_m_s = 30.0;
  const auto below = [](std::string_view closure, std::string_view beyond) {
    return Validity{closure, "wind", "m/s", 0.0, kStrongest_m_s, beyond};
  };
  if (std::holds_alternative<McAdams>(convection))
    return below("convection mcadams", "it was fitted below 5 m/s, and its film is some 20 % too large at 30 m/s");
  if (std::holds_alternative<Tarp>(convection))
    return below("convection tarp", "it comes from plates in winds of some m/s, and nothing is known of its film");
  return std::nullopt;
}

double forced_coefficient(const Convection& convection, double wind_m_s) {
  return std::visit(
      Overloaded{
          [](const NoConvection&) { return 0.0; },
          [&](const LinearConvection& linear) { return linear.h0_w_m2_k + linear.h1_j_m3_k * wind_m_s; },
          [&](const McAdams&) { return 5.7 + 3.8 * wind_m_s; },
          [&](const Tarp& tarp) { return 2.537 * tarp.roughness * std::sqrt(tarp.perimeter_over_area_m * wind_m_s); }},
      convection);
}

NaturalConvection natural_coefficient(const Convection& convection, double up) {
  if (!std::holds_alternative<Tarp>(convection)) return {};
  if (up == 0.0) return {1.31, 1.31};
  const double aided = 9.482 / (7.283 - std::abs(up)), hindered = 1.810 / (1.382 + std::abs(up));
  return up > 0.0 ? NaturalConvection{aided, hindered} : NaturalConvection{hindered, aided};
}

void require_valid(const Convection& convection, std::string_view where) {
  if (const auto* linear = std::get_if<LinearConvection>(&convection)) {
    require_not_negative(linear->h0_w_m2_k, where, "convection h0");
    require_not_negative(linear->h1_j_m3_k, where, "convection h1");
  } else if (const auto* tarp = std::get_if<Tarp>(&convection)) {
    require_not_negative(tarp->roughness, where, "convection roughness");
    require_not_negative(tarp->perimeter_over_area_m, where, "convection perimeter over area");
  }
}

}  // namespace radiometry::heat
