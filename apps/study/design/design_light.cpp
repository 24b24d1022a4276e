// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/design_light.h"

#include <algorithm>

namespace study {

namespace {

/// Of the light behind the design's own air.
DesignLight own_light_of(const VariantSensor& variant, const Study& study, const radiometry::Overrides<double>& numbers,
                         const LightNeeds& needs) {
  DesignLight light{variant.spectral, variant.system.band ? variant.system.band->rate : nullptr, variant.system.air};
  if (!variant.loaded || !numbers.any(radiometry::is_spectral)) return light;
  const radiometry::Sensor& sensor = variant.loaded->sensor;
  const bool other_air = needs.otf && numbers.any(radiometry::changes_color);
  if (!needs.numbers && !other_air) return light;
  const radiometry::Path path = path_with(sensor, numbers);
  if (needs.numbers) light.numbers = spectral_numbers(study.conditions, sensor, path, numbers);
  if (!other_air) return light;
  light.rate = apps::electron_rate(variant.system, *variant.loaded, path);
  if (variant.loaded->path_air) light.air = variant.loaded->path_air(atmosphere_with(sensor, numbers));
  return light;
}

}  // namespace

DesignLight light_of(const VariantSensor& variant, const Study& study,
                     std::span<const radiometry::Override<double>> numbers, const LightNeeds& needs) {
  DesignLight light = own_light_of(variant, study, radiometry::Overrides<double>{numbers}, needs);
  // Of the numbers between the points of a panel; a series of an octave is as good as the last at once.
  constexpr double kOfTolerance = 0.1, kTightest = 1e-9;
  if (needs.ranges && variant.loaded && variant.no_ranges.empty())
    light.course = std::make_shared<LightCourse>(variant, study.conditions, numbers, light.numbers,
                                                 std::max(kOfTolerance * study.tolerance, kTightest));
  return light;
}

const DesignLight& KeptLight::at(const VariantSensor& variant, const Study& study,
                                 std::span<const radiometry::Override<double>> overrides, const LightNeeds& needs) {
  std::vector<radiometry::Override<double>> spectral;
  for (const auto& number : overrides)
    if (radiometry::is_spectral(number.path)) spectral.push_back(number);
  const auto same = [](const auto& a, const auto& b) { return a.path == b.path && a.value == b.value; };
  if (light_ && std::equal(spectral.begin(), spectral.end(), spectral_.begin(), spectral_.end(), same)) return *light_;
  light_.reset();
  light_ = light_of(variant, study, spectral, needs);
  spectral_ = std::move(spectral);
  return *light_;
}

}  // namespace study
