// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>

#include "apps/study/design/design_light.h"
#include "mtf/otf/otf_series.h"

namespace study {
namespace {

constexpr int kDegree = 6, kColours = kDegree / 2;  // of the series, and of those of colours that change little

/// Rising points in [-1, 1] at which a series of that degree is known.
double point(int k, int degree = kDegree) { return mtf::cos_pi(static_cast<double>(degree - k) / degree); }

double place_in(const RangePanel& panel, double range_m) {
  const double whole = std::log(panel.hi_m / panel.lo_m);
  return whole > 0.0 ? std::clamp(2.0 * std::log(range_m / panel.lo_m) / whole - 1.0, -1.0, 1.0) : 0.0;
}

/// The series through values at rising points.
std::vector<double> series_of(std::vector<double> value) {
  std::reverse(value.begin(), value.end());
  const std::vector<double> transform = mtf::chebyshev_transform(static_cast<int>(value.size()) - 1);
  std::vector<double> coefficient(value.size());
  mtf::add_products(transform.data(), std::span<const double>(value), std::span<double>(coefficient));
  return coefficient;
}

std::array<double, 3> numbers_of(const LightAtRange& light) { return {light.scene, light.path, light.contrast_share}; }

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

std::vector<double> RangePanel::weights(double at_m) const {
  const double t = place_in(*this, at_m);
  const int degree = static_cast<int>(colour.size()) - 1;
  std::vector<double> weight(colour.size(), 0.0);
  double sum = 0.0;
  for (int k = 0; k <= degree; ++k) {
    const double away = t - point(k, degree);
    if (away == 0.0) {
      std::fill(weight.begin(), weight.end(), 0.0);
      weight[static_cast<std::size_t>(k)] = 1.0;
      return weight;
    }
    const double end = k == 0 || k == degree ? 0.5 : 1.0;
    sum += weight[static_cast<std::size_t>(k)] = (k % 2 == 0 ? end : -end) / away;
  }
  for (double& w : weight) w /= sum;
  return weight;
}

double panel_error(std::vector<double> values) { return mtf::series_tail(series_of(std::move(values))); }

LightCourse::LightCourse(const VariantSensor& variant, const radiometry::Conditions& conditions,
                         std::span<const radiometry::Override<double>> numbers,
                         const radiometry::SpectralNumbers<double>& own, double tolerance)
    : variant_(&variant),
      temperature_k_(conditions.temperature_k),
      own_overrides_(numbers.begin(), numbers.end()),
      overrides_(own_overrides_),
      own_(own),
      air_(apps::air_course(*variant.loaded, overrides_)),
      extinction_per_km_(conditions.extinction_per_km.value_or(0.0)),
      tolerance_(tolerance) {
  own_ = radiometry::behind_path(own, variant.loaded->sensor, radiometry::Path{}, temperature_k_, overrides_);
  own_rate_ = apps::electron_rate(variant.system, *variant.loaded, radiometry::Path{});
  const bool colours = air_.path && variant.system.band && variant.system.band->rate;
  moves_otf_ = colours || static_cast<bool>(air_.path_air);
}

LightAtRange LightCourse::behind(const radiometry::Path& path, double range_m) const {
  const radiometry::SpectralNumbers<double> n =
      radiometry::behind_path(own_, variant_->loaded->sensor, path, temperature_k_, overrides_);
  return {n.radiances.scene, n.radiances.path, n.per_k / own_.per_k * std::exp(-1e-3 * range_m * extinction_per_km_)};
}

LightAtRange LightCourse::at(double range_m) const {
  if (air_.path && range_m > 0.0) return behind(air_.path(range_m), range_m);
  return {own_.radiances.scene, own_.radiances.path, std::exp(-1e-3 * range_m * extinction_per_km_)};
}

ColourAtRange LightCourse::colour_at(double range_m) const {
  ColourAtRange colour{own_rate_, variant_->system.air};
  if (range_m > 0.0 && air_.path)
    colour.rate = apps::electron_rate(variant_->system, *variant_->loaded, air_.path(range_m));
  if (air_.path_air) colour.air = range_m > 0.0 ? air_.path_air(range_m) : mtf::PathAir<double>{0.0, 0.0};
  return colour;
}

radiometry::SpectralNumbers<double> LightCourse::numbers(const LightAtRange& light) const {
  radiometry::SpectralNumbers<double> numbers = own_;
  numbers.radiances.scene = light.scene;
  numbers.radiances.path = light.path;
  return numbers;
}

RangePanel LightCourse::made(double lo_m, double hi_m) const {
  RangePanel panel{.lo_m = lo_m, .hi_m = hi_m};
  std::array<std::vector<double>, 3> value;
  for (int k = 0; k <= kDegree; ++k) {
    panel.range_m.push_back(k == 0 ? lo_m : k == kDegree ? hi_m : lo_m * std::pow(hi_m / lo_m, 0.5 * (1.0 + point(k))));
    const auto numbers = numbers_of(at(panel.range_m.back()));
    for (std::size_t n = 0; n < numbers.size(); ++n) value[n].push_back(numbers[n]);
  }
  for (std::size_t n = 0; n < value.size(); ++n) {
    std::vector<double>& values = value[n];
    panel.logarithm[n] = std::all_of(values.begin(), values.end(), [](double v) { return v > 0.0; });
    const double size = panel.logarithm[n] ? 1.0 : *std::max_element(values.begin(), values.end());
    if (panel.logarithm[n])
      for (double& v : values) v = std::log(v);
    panel.series[n] = series_of(values);
    if (size > 0.0) panel.error = std::max(panel.error, mtf::series_tail(panel.series[n]) / size);
  }
  return panel;
}

const RangePanel& LightCourse::panel(double range_m, bool colours) {
  double lo = std::exp2(std::floor(std::log2(range_m))), hi = 2.0 * lo;
  lo = std::max(lo, reach().least_m);
  hi = std::min(hi, reach().most_m);
  if (const auto& table = variant_->loaded->table) {
    for (const double kink : table->range_m())
      if (kink <= range_m && kink < reach().most_m)
        lo = std::max(lo, kink);
      else
        hi = std::min(hi, kink);
  }
  constexpr int kDeepest = 6;
  for (int depth = 0;; ++depth) {
    auto found = panels_.find({lo, hi});
    if (found == panels_.end()) found = panels_.emplace(std::pair(lo, hi), made(lo, hi)).first;
    RangePanel& panel = found->second;
    if (panel.error <= tolerance_ || depth == kDeepest) {
      if (colours && panel.colour.empty())
        for (std::size_t k = 0; k < panel.range_m.size(); k += air_.path_air ? 1 : kDegree / kColours)
          panel.colour.push_back(colour_at(panel.range_m[k]));
      return panel;
    }
    const double middle = std::sqrt(lo * hi);
    (range_m < middle ? hi : lo) = middle;
  }
}

LightAtRange LightCourse::between(double range_m) {
  if (!air_.path) return at(range_m);
  const RangePanel& panel = this->panel(range_m, false);
  const double t = place_in(panel, range_m);
  std::array<double, 3> number{};
  for (std::size_t n = 0; n < number.size(); ++n) {
    const double value = mtf::chebyshev(panel.series[n], t);
    number[n] = panel.logarithm[n] ? std::exp(value) : std::max(value, 0.0);
  }
  return {number[0], number[1], number[2]};
}

double LightCourse::error(double range_m) {
  if (!air_.path) return 0.0;
  const double of_panel = panel(range_m, false).error;
  if (!air_.coarser) return of_panel;
  const auto fine = numbers_of(behind(air_.path(range_m), range_m)),
             coarse = numbers_of(behind(air_.coarser(range_m), range_m));
  double worst = 0.0;
  for (std::size_t n = 0; n < fine.size(); ++n)
    if (fine[n] > 0.0) worst = std::max(worst, std::abs(coarse[n] / fine[n] - 1.0));
  return of_panel + worst;
}

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
