// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/design_light.h"

#include <algorithm>

namespace study {

DesignLight light_of(const VariantSensor& variant, const Conditions& conditions,
                     const radiometry::Overrides<double>& numbers, const LightNeeds& needs) {
  DesignLight light{variant.spectral, variant.system.band ? variant.system.band->rate : nullptr, variant.system.air};
  if (!variant.loaded || !numbers.any(radiometry::is_spectral)) return light;
  const radiometry::Sensor& sensor = variant.loaded->sensor;
  const bool other_air = needs.otf && numbers.any(radiometry::changes_color);
  if (!needs.numbers && !other_air) return light;
  const radiometry::Path path = path_with(sensor, numbers);
  if (needs.numbers) light.numbers = spectral_numbers(conditions, sensor, path, numbers);
  if (!other_air) return light;
  light.rate = apps::electron_rate(variant.system, *variant.loaded, path);
  if (variant.loaded->path_air) light.air = variant.loaded->path_air(atmosphere_with(sensor, numbers));
  return light;
}

const DesignLight& KeptLight::at(const VariantSensor& variant, const Conditions& conditions,
                                 std::span<const radiometry::Override<double>> overrides, const LightNeeds& needs) {
  std::vector<radiometry::Override<double>> spectral;
  for (const auto& number : overrides)
    if (radiometry::is_spectral(number.path)) spectral.push_back(number);
  const auto same = [](const auto& a, const auto& b) { return a.path == b.path && a.value == b.value; };
  if (light_ && std::equal(spectral.begin(), spectral.end(), spectral_.begin(), spectral_.end(), same)) return *light_;
  light_.reset();
  light_ = light_of(variant, conditions, radiometry::Overrides<double>{spectral}, needs);
  spectral_ = std::move(spectral);
  return *light_;
}

}  // namespace study
