// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far temperatures of counts (radiometry/light/raw_counts.h) are uncertain because emissivity, surroundings, air
// and window are not exactly what the camera was told. With standard deviations u_i of these numbers x_i, independent:
//   first order   u^2 = sum of (dT/dx_i u_i)^2, dT/dx_i of the whole formula, the air's transmission with it; the share
//                 of a number is its part of that sum (JCGM 100, 5.1)
//   interval      from 2.5 to 97.5 % of the temperatures by numbers that are drawn from normal distributions as far as
//                 such numbers are possible, so an emissivity up to 1 (JCGM 101); to 0.03 u where first order holds, by
//                 points that fill the space evenly (a Kronecker sequence), the same in every run
// The first order holds where the ends of T +- 1.96 u lie within 0.3 u of those of the interval, which is what rounding
// u to one digit may change (JCGM 101, 8). What the camera itself errs is in neither.

#include <array>
#include <optional>
#include <vector>

#include "radiometry/light/raw_counts.h"

namespace radiometry {

/// What a thermal camera is told of surface, air and window.
struct CountScene {
  double emissivity = 1.0, surroundings_k = 293.15;
  double distance_m = 0.0, air_k = 293.15, humidity = 0.5;
  double window_transmission = 1.0, window_k = 293.15;

  static constexpr auto fields() {
    constexpr auto kelvin = [](auto member, const char* name, const char* doc) {
      return above(optional(member, name, "K", 0.0, 1e5, "\"293 K\"", doc));
    };
    return std::tuple{
        above(optional(&CountScene::emissivity, "emissivity", 0.0, 1.0, "0.95", "of the surface")),
        kelvin(&CountScene::surroundings_k, "surroundings", "that the surface reflects"),
        optional(&CountScene::distance_m, "distance", "m", 0.0, 1e9, "\"5 m\"", "through the air"),
        kelvin(&CountScene::air_k, "air_temperature", "of the air"),
        optional(&CountScene::humidity, "relative_humidity", 0.0, 1.0, "0.5", "of the air"),
        above(optional(&CountScene::window_transmission, "window_transmission", 0.0, 1.0, "0.9", "of the window")),
        kelvin(&CountScene::window_k, "window_temperature", "of the window")};
  }
};
/// One of each of its numbers, in their order.
using CountNumbers = std::array<double, std::tuple_size_v<decltype(CountScene::fields())>>;

/// Air of those constants; without them it counts nothing. Its transmission is NaN where it has none.
Thermometry thermometry_of(const CountScene& scene, std::optional<CountAir> constants);

struct CountUncertainty {
  double temperature_k = 0.0;  ///< NaN where the count has none
  double sd_k = 0.0;           ///< of first order
  CountNumbers change_k{};     ///< dT/dx u of each number
  /// Ends of 95 %; NaN where some of the temperatures there are none.
  double low_k = 0.0, high_k = 0.0;
  bool first_order = true;  ///< whether it holds

  double share(std::size_t number) const { return change_k[number] * change_k[number] / (sd_k * sd_k); }
};

class CountErrors {
 public:
  /// `sd`: of each number, 0 where it is exact. Throws UsageError where they are so large that hardly any of the
  /// numbers that they allow are possible.
  CountErrors(const CountCamera& camera, const CountScene& told, const std::optional<CountAir>& air,
              const CountNumbers& sd);

  CountUncertainty of(double count) const;

 private:
  CountCamera camera_;
  CountScene told_;
  std::optional<CountAir> air_;
  CountNumbers sd_;
  std::vector<Thermometry> drawn_{};
};

}  // namespace radiometry
