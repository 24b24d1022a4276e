// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/count_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "mtf/components/field_access.h"
#include "radiometry/stages/noise/poisson.h"

namespace radiometry {
namespace {

constexpr int kDraws = 1 << 13;
constexpr double kNormal95 = 1.959963984540054;
/// The root of x^(d + 1) = x + 1 for d = 7 numbers: multiples of its powers fill d axes evenly.
constexpr double kEven = 1.0969815577985598;

/// With `by` added to one of its numbers.
CountScene moved(CountScene scene, std::size_t number, double by) {
  std::size_t i = 0;
  for_each_field(scene, [&](const FieldInfo&, double& x) { x += i++ == number ? by : 0.0; });
  return scene;
}

}  // namespace

Thermometry thermometry_of(const CountScene& scene, std::optional<CountAir> constants) {
  if (constants)
    constants->distance_m = scene.distance_m, constants->air_k = scene.air_k, constants->humidity = scene.humidity;
  return {.emissivity = scene.emissivity,
          .reflected_k = scene.surroundings_k,
          .transmission = constants ? transmission_of(*constants) : 1.0,
          .air_k = scene.air_k,
          .window_transmission = scene.window_transmission,
          .window_k = scene.window_k};
}

CountErrors::CountErrors(const CountCamera& camera, const CountScene& told, const std::optional<CountAir>& air,
                         const CountNumbers& sd)
    : camera_(camera), told_(told), air_(air), sd_(sd) {
  for (int n = 1; n <= kDraws; ++n) {
    CountScene numbers = told;
    bool possible = true;
    std::size_t i = 0;
    double power = 1.0;
    for_each_field(numbers, [&](const FieldInfo& info, double& number) {
      power /= kEven;
      const double turns = 0.5 + n * power, u = turns - std::floor(turns);
      if (const double one = sd_[i++]; one > 0.0) number += one * normal_quantile({u, 1.0 - u});
      possible = possible && mtf::in_range(info, number);
    });
    const Thermometry assumed = thermometry_of(numbers, air);
    if (possible && !std::isnan(assumed.transmission)) drawn_.push_back(assumed);
  }
  if (drawn_.size() < kDraws / 20)
    throw mtf::UsageError(
        "of the numbers that the standard deviations allow less than 5 % are possible; state smaller ones");
}

CountUncertainty CountErrors::of(double count) const {
  const auto kelvin = [&](const Thermometry& assumed) { return temperature_of(count, camera_, assumed); };
  CountUncertainty found{.temperature_k = kelvin(thermometry_of(told_, air_))};
  std::size_t i = 0;
  for_each_field(told_, [&](const FieldInfo&, const double& number) {
    const double step = 1e-5 * number;  // whose square a central difference errs by, relative, about
    const auto at = [&](double by) { return kelvin(thermometry_of(moved(told_, i, by), air_)); };
    if (sd_[i] > 0.0) found.change_k[i] = (at(step) - at(-step)) / (2.0 * step) * sd_[i];
    ++i;
  });
  double squares = 0.0;
  for (const double change : found.change_k) squares += change * change;
  found.sd_k = std::sqrt(squares);

  std::vector<double> kelvins(drawn_.size());
  std::ranges::transform(drawn_, kelvins.begin(), kelvin);
  // A surface without light of its own is colder than all others; with F below 1 there are some that are warmer.
  bool known = true;
  for (double& one : kelvins) {
    known = known && !(std::isnan(one) && camera_.f < 1.0);
    if (std::isnan(one)) one = -mtf::kInfinity;
  }
  const auto end = [&](double part) {
    const auto place = kelvins.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(kelvins.size()));
    std::ranges::nth_element(kelvins, place);
    return known && std::isfinite(*place) ? *place : std::nan("");
  };
  found.low_k = end(0.025);
  found.high_k = end(0.975);
  const double half = kNormal95 * found.sd_k, apart = 0.3 * found.sd_k + 1e-9 * found.temperature_k;
  found.first_order = std::isfinite(half) && std::abs(found.temperature_k - half - found.low_k) <= apart &&
                      std::abs(found.temperature_k + half - found.high_k) <= apart;
  return found;
}

}  // namespace radiometry
