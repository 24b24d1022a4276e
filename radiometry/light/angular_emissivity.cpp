// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/angular_emissivity.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "mtf/error.h"
#include "mtf/units.h"

namespace radiometry {
namespace {

constexpr std::size_t kSteps = 1024;  // straight lines err by 3e-6 with p = 5

template <class Value>
AngularEmissivity sampled(const Value& value) {
  AngularEmissivity curve;
  for (std::size_t k = 0; k <= kSteps; ++k)
    curve.relative.push_back(static_cast<float>(value(static_cast<double>(k) / kSteps)));
  return curve;
}

/// Fresnel, of unpolarised light that meets a dielectric from the air.
double reflectance(double index, double cosine) {
  const double inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (index * index));
  const double s = (cosine - index * inside) / (cosine + index * inside),
               p = (index * cosine - inside) / (index * cosine + inside);
  return 0.5 * (s * s + p * p);
}

[[noreturn]] void refuse(const std::string& what) { throw mtf::UsageError("emissivity by angle: " + what); }

}  // namespace

AngularEmissivity schlick(double exponent) {
  if (!(exponent >= 1.0 && exponent <= 100.0))
    refuse("an exponent of " + mtf::format_double(exponent) + "; it is from 1 to 100");
  return sampled([&](double cosine) { return 1.0 - std::pow(1.0 - cosine, exponent); });
}

AngularEmissivity dielectric(double index) {
  if (!(index > 1.0 && index <= 10.0))
    refuse("a refractive index of " + mtf::format_double(index) + "; it is above 1 and at most 10");
  return sampled([&](double cosine) {
    return cosine > 0.0 ? (1.0 - reflectance(index, cosine)) / (1.0 - reflectance(index, 1.0)) : 0.0;
  });
}

AngularEmissivity angle_table(std::span<const double> angle_deg, std::span<const double> relative) {
  if (angle_deg.size() < 2 || angle_deg.size() != relative.size()) refuse("a table needs two angles or more");
  if (angle_deg.front() != 0.0 || relative.front() != 1.0)
    refuse("a table begins with 0 degrees and 1: values are relative to the emissivity along the normal");
  for (std::size_t i = 0; i < angle_deg.size(); ++i) {
    if (!(angle_deg[i] <= 90.0) || (i > 0 && !(angle_deg[i] > angle_deg[i - 1])))
      refuse("angles rise from 0 to at most 90 degrees; there is " + mtf::format_double(angle_deg[i]));
    if (!(relative[i] >= 0.0 && relative[i] <= 100.0))
      refuse("a value of " + mtf::format_double(relative[i]) + "; it is from 0 to 100");
  }
  return sampled([&](double cosine) {
    const double angle = std::acos(cosine) * 180.0 / std::numbers::pi;
    if (angle >= angle_deg.back()) return relative.back();
    const auto above = std::upper_bound(angle_deg.begin(), angle_deg.end(), angle);
    const auto i = static_cast<std::size_t>(above - angle_deg.begin());
    return std::lerp(relative[i - 1], relative[i], (angle - angle_deg[i - 1]) / (angle_deg[i] - angle_deg[i - 1]));
  });
}

double relative_emissivity(const AngularEmissivity& curve, double cosine) {
  if (curve.empty()) return 1.0;
  const double at = std::clamp(cosine, 0.0, 1.0) * static_cast<double>(curve.relative.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), curve.relative.size() - 2);
  return std::lerp(static_cast<double>(curve.relative[below]), static_cast<double>(curve.relative[below + 1]),
                   at - static_cast<double>(below));
}

double hemispherical_mean(const AngularEmissivity& curve) {
  if (curve.empty()) return 1.0;
  // Of straight lines, exactly: integral of g mu over a step.
  const double step = 1.0 / static_cast<double>(curve.relative.size() - 1);
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < curve.relative.size(); ++k) {
    const double a = static_cast<double>(k) * step;
    const auto low = static_cast<double>(curve.relative[k]), high = static_cast<double>(curve.relative[k + 1]);
    sum += step * (0.5 * (low + high) * a + step * (low / 6.0 + high / 3.0));
  }
  return 2.0 * sum;
}

double largest(const AngularEmissivity& curve) {
  return curve.empty() ? 1.0 : static_cast<double>(*std::max_element(curve.relative.begin(), curve.relative.end()));
}

}  // namespace radiometry
