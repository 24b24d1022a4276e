// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/fried.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

namespace mtf {
namespace {

// Altitudes (m) between which every term of the profile is smooth enough for the rule below; above the last nothing.
constexpr std::array kLayers{0.0,    40.0,   80.0,  150.0, 250.0, 400.0, 600.0, 900.0, 1500.0, 2500.0, 4000.0,
                             6000.0, 8000.0, 1.1e4, 1.4e4, 1.8e4, 2.3e4, 3e4,   4e4,   6e4,    1e5,    2e5};

struct Terms {
  double value, slope;  // of Cn2 by altitude
  double by_wind, by_ground;
};

Terms terms(const HufnagelValley& p, double h) {
  const double upper = 5.94e-53 / (27.0 * 27.0) * std::pow(h, 9.0) * std::exp(-h / 1000.0),
               middle = 2.7e-16 * std::exp(-h / 1500.0), ground = std::exp(-h / 100.0), wind2 = p.wind_m_s * p.wind_m_s;
  return {wind2 * upper * h + middle + p.ground * ground,
          wind2 * upper * (10.0 - h / 1000.0) - middle / 1500.0 - p.ground * ground / 100.0,
          2.0 * p.wind_m_s * upper * h, ground};
}

void add(PathMean& sum, const Terms& t, double s, double weight) {
  sum.value += weight * t.value;
  sum.by_wind += weight * t.by_wind;
  sum.by_ground += weight * t.by_ground;
  sum.by_target += weight * (1.0 - s) * t.slope;
  sum.by_sensor += weight * s * t.slope;
}

}  // namespace

double structure_parameter(const HufnagelValley& profile, double altitude_m) {
  return altitude_m < kLayers.back() ? terms(profile, altitude_m).value : 0.0;
}

// With s = q^3 the weight s^(5/3) ds = 3 q^7 dq is smooth at the source; Gauss-Legendre in q, layer by layer. Altitudes
// and q are counted from the face of the layer that is nearer to the target: seen from a satellite, target + s rise and
// the difference of two cube roots would leave a layer few digits of its thickness.
PathMean path_mean(const HufnagelValley& profile, double target_altitude_m, double sensor_altitude_m, Wave wave) {
  static const GaussRule rule = mean_rule(0.0, 1.0, 24);
  const auto weight = [&](double q) { return 3.0 * q * q * (wave == Wave::spherical ? std::pow(q, 5.0) : 1.0); };
  const double rise = sensor_altitude_m - target_altitude_m;
  const double low = std::min(target_altitude_m, sensor_altitude_m),
               high = std::min(kLayers.back(), std::max(target_altitude_m, sensor_altitude_m));
  PathMean sum;
  if (low >= kLayers.back()) return sum;
  if (std::abs(rise) < 1e-3 * (100.0 + low)) {  // one layer: the profile hardly changes
    for (std::size_t i = 0; i < rule.weight.size(); ++i) {
      const double q = rule.node[i], s = q * q * q;
      add(sum, terms(profile, target_altitude_m + s * rise), s, weight(q) * rule.weight[i]);
    }
    return sum;
  }
  for (std::size_t k = 0; k + 1 < kLayers.size(); ++k) {
    const double a = std::max(low, kLayers[k]), b = std::min(high, kLayers[k + 1]);
    if (!(a < b)) continue;
    const double near = rise > 0.0 ? a : b, far = rise > 0.0 ? b : a, share = (b - a) / std::abs(rise);
    const double q0 = std::cbrt((near - target_altitude_m) / rise), q1 = std::cbrt((far - target_altitude_m) / rise),
                 thickness = share / (q1 * q1 + q1 * q0 + q0 * q0);  // q1 - q0, of q1^3 - q0^3 = share
    for (std::size_t i = 0; i < rule.weight.size(); ++i) {
      const double step = thickness * rule.node[i], q = q0 + step;
      const double altitude = near + step * (q * q + q * q0 + q0 * q0) * rise;
      add(sum, terms(profile, altitude), q * q * q, weight(q) * rule.weight[i] * thickness);
    }
  }
  return sum;
}

InverseFried inverse_fried(double path_m13, double wavelength_um) {
  if (!(path_m13 > 0.0)) return {};
  const double k_1_m = 2.0 * kPi / (wavelength_um * 1e-6);
  const double value = 1e-3 * std::pow(0.423 * path_m13, 0.6) * std::pow(k_1_m, 1.2);
  return {value, 0.6 * value / path_m13, -1.2 * value / wavelength_um};
}

}  // namespace mtf
