// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/raw_counts.h"

#include <algorithm>
#include <cmath>

#include "mtf/units.h"
#include "radiometry/light/pixel_rules.h"

namespace radiometry {

namespace {

/// exp(B / T) - 1 where the counts, offset added, are `signal`.
double excess(const CountCamera& camera, double signal) { return camera.r1 / (camera.r2 * signal) + (camera.f - 1.0); }

}  // namespace

double CountCamera::temperature_k(double count) const {
  const double signal = count + o, over_one = excess(*this, signal);
  return signal > 0.0 && over_one > 0.0 ? b_k / std::log1p(over_one) : std::nan("");
}

double CountCamera::count(double temperature_k) const {
  return temperature_k > 0.0 ? r1 / (r2 * (std::exp(b_k / temperature_k) - f)) - o : -o;
}

double transmission_of(const CountAir& air) {
  const double c = air.air_k - mtf::kZeroCelsius_k;
  const double water = air.humidity * std::exp(1.5587 + c * (6.939e-2 + c * (-2.7816e-4 + c * 6.8455e-7)));
  const auto part = [&](double alpha, double beta) {
    return std::exp(-std::sqrt(air.distance_m) * (alpha + beta * std::sqrt(water)));
  };
  const double t = air.x * part(air.alpha1, air.beta1) + (1.0 - air.x) * part(air.alpha2, air.beta2);
  constexpr double rounding = 1e-12;
  return t > 0.0 && t <= 1.0 + rounding ? std::min(t, 1.0) : std::nan("");
}

namespace {

/// S + O of the surface = slope (S + O) - rest.
struct CountLine {
  double slope, rest;
};

CountLine surface_line(const CountCamera& camera, const Thermometry& a) {
  const auto u = [&](double share, double k) { return share == 0.0 ? 0.0 : share * (camera.count(k) + camera.o); };
  const double before = a.window_transmission * a.transmission;
  return {1.0 / (a.emissivity * before),
          (u(before * (1.0 - a.emissivity), a.reflected_k) +
           u(a.window_transmission * (1.0 - a.transmission), a.air_k) + u(1.0 - a.window_transmission, a.window_k)) /
              (a.emissivity * before)};
}

double temperature_of_signal(const CountCamera& camera, double signal) {
  const double over_one = excess(camera, signal);
  return signal > 0.0 && over_one > 0.0 ? camera.b_k / std::log1p(over_one) : std::nan("");
}

/// dU / dT = U (U R2 F / R1 + 1) B / T^2.
double signal_slope(const CountCamera& camera, double temperature_k) {
  const double u = camera.count(temperature_k) + camera.o;
  return u * (1.0 + u * camera.r2 * camera.f / camera.r1) * camera.b_k / (temperature_k * temperature_k);
}

}  // namespace

double temperature_of(double count, const CountCamera& camera, const Thermometry& assumed) {
  const CountLine line = surface_line(camera, assumed);
  return temperature_of_signal(camera, (count + camera.o) * line.slope - line.rest);
}

CountSensitivity sensitivity_of(double count, const CountCamera& camera, const Thermometry& a) {
  const double t = temperature_of(count, camera, a), per_u = 1.0 / signal_slope(camera, t);
  const auto u = [&](double k) { return camera.count(k) + camera.o; };
  const double seen = a.emissivity * u(t) + (1.0 - a.emissivity) * u(a.reflected_k);  // before the air
  return {.emissivity = per_u * (u(a.reflected_k) - u(t)) / a.emissivity,
          .reflected = -per_u * (1.0 - a.emissivity) / a.emissivity * signal_slope(camera, a.reflected_k),
          .transmission = per_u * (u(a.air_k) - seen) / (a.emissivity * a.transmission),
          .air = -per_u * (1.0 - a.transmission) / (a.emissivity * a.transmission) * signal_slope(camera, a.air_k)};
}

void temperature_of_counts(mtf::ImageView<float> plane, const CountCamera& camera, const Thermometry& assumed,
                           int threads) {
  require_valid("counts", camera);
  for (const auto& [name, value] : {std::pair{"emissivity", assumed.emissivity},
                                    {"transmission of the air", assumed.transmission},
                                    {"transmission of the window", assumed.window_transmission}})
    if (!(value > 0.0 && value <= 1.0))
      throw mtf::UsageError("counts: " + std::string(name) + " " + mtf::format_double(value) +
                            "; it has to be above 0, up to 1");
  const CountLine line = surface_line(camera, assumed);
  const auto possible = [](double share, double k) { return share == 0.0 || k >= 0.0; };
  if (!(line.rest >= 0.0 && std::isfinite(line.rest) && possible(1.0 - assumed.emissivity, assumed.reflected_k) &&
        possible(1.0 - assumed.transmission, assumed.air_k) &&
        possible(1.0 - assumed.window_transmission, assumed.window_k)))
    throw mtf::UsageError("counts: reflected, air or window temperatures, " + mtf::format_double(assumed.reflected_k) +
                          ", " + mtf::format_double(assumed.air_k) + " and " + mtf::format_double(assumed.window_k) +
                          " K: they have to be 0 or above, in kelvin, and temperatures that the constants of the "
                          "camera can give");
  const auto signal = [&](float count) { return (static_cast<double>(count) + camera.o) * line.slope - line.rest; };
  const auto bad = [&](float count) {
    const double s = signal(count);
    return !std::isnan(count) && !(s > 0.0 && excess(camera, s) > 0.0);
  };
  refuse_pixels(plane,
                {"counts", "give no temperature by B / ln(R1 / (R2 (S + O)) + F)",
                 "check the constants, and gain and offset of the file"},
                threads, bad);
  for_each_pixel(plane, threads, [&](float count) {
    return static_cast<float>(camera.b_k / std::log1p(excess(camera, signal(count))));
  });
}

}  // namespace radiometry
