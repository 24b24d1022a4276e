// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/raw_counts.h"

#include <cmath>

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

void temperature_of_counts(mtf::ImageView<float> plane, const CountCamera& camera, const Reflection& reflection,
                           int threads) {
  require_valid("counts", camera);
  const double e = reflection.emissivity;
  if (!(e > 0.0 && e <= 1.0))
    throw mtf::UsageError("counts: an emissivity of " + mtf::format_double(e) + "; it has to be above 0, up to 1");
  const double reflected = e < 1.0 ? (1.0 - e) * (camera.count(reflection.reflected_k) + camera.o) : 0.0;
  if (e < 1.0 && !(reflection.reflected_k >= 0.0 && reflected >= 0.0 && std::isfinite(reflected)))
    throw mtf::UsageError(
        "counts: a reflected temperature of " + mtf::format_double(reflection.reflected_k) +
        " K; it has to be 0 or above, in kelvin, and a temperature that the constants of the camera can give");
  const auto signal = [&](float count) { return (static_cast<double>(count) + camera.o - reflected) / e; };
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
