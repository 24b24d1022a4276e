// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/backdrop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace radiometry::render {
namespace {

constexpr double kRight = 0.5 * std::numbers::pi;
constexpr double kLowest = 1e-4;       // rad: lines nearer to the horizon are taken to have this elevation
constexpr double kFarthest_m = 300e3;  // of a ground that the air does not hide

double interpolated(const std::vector<double>& values, double elevation) {
  const ElevationPlace place = elevation_place(elevation, values.size());
  double sum = 0.0;
  for (std::size_t k = 0; k < 4; ++k) sum += place.weight[k] * values[place.first + k];
  return sum;
}

}  // namespace

double sky_elevation(std::size_t k, std::size_t of) {
  const double root = static_cast<double>(k) / static_cast<double>(of - 1);
  return std::max(kRight * root * root, kLowest);
}

ElevationPlace elevation_place(double elevation_rad, std::size_t of) {
  const double at = std::sqrt(std::clamp(elevation_rad / kRight, 0.0, 1.0)) * static_cast<double>(of - 1);
  const double below = std::clamp(std::floor(at), 1.0, static_cast<double>(of - 3)), t = at - below;
  return {static_cast<std::size_t>(below) - 1,
          {-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0, -(t + 1.0) * t * (t - 2.0) / 2.0,
           (t + 1.0) * t * (t - 1.0) / 6.0}};
}

Backdrop::Backdrop(const RenderScene& scene, const BandNodes& nodes, const LightSources& sources, const AirView* view,
                   double camera_height_m, double ground_m, std::optional<double> nearest_m)
    : camera_above_m_(camera_height_m - ground_m), nearest_m_(nearest_m.value_or(camera_above_m_)) {
  below_.emplace_back();
  const AirView* layered = view != nullptr && view->layered() ? view : nullptr;
  const std::vector<double> ground = fold(nodes, sources.radiance[sources.ground()]);
  std::vector<double> air;
  if (view != nullptr) air = fold(nodes, blackbody_at(nodes, view->reference_k()));
  for (std::size_t i = 0; i < kSkyElevations; ++i) {
    const double elevation = sky_elevation(i);
    above_.push_back(integral(nodes, sky_at(scene.sky, nodes, layered, kRight - elevation)));
  }
  for (std::size_t i = 0; i < kGroundElevations; ++i) {
    const double elevation = sky_elevation(i, kGroundElevations);
    double sum = 0.0, added = 0.0;
    if (view == nullptr || camera_above_m_ <= 0.0) {
      for (const double part : ground) sum += part;
    } else {
      const AirSamples path = view->to(std::min(nearest_m_ / std::sin(elevation), kFarthest_m), ground_m);
      for (std::size_t s = 0; s < ground.size(); ++s) {
        sum += path.transmission[s] * ground[s];
        added += path.source[s] * air[s];
      }
    }
    below_.back().radiance.push_back(sum + added);
    below_.back().path.push_back(added);
  }
}

Backdrop Backdrop::between(const Backdrop& low, const Backdrop& high, double share) {
  Backdrop out = low;
  out.camera_above_m_ = std::lerp(low.camera_above_m_, high.camera_above_m_, share);
  for (std::size_t i = 0; i < kSkyElevations; ++i) out.above_[i] = std::lerp(low.above_[i], high.above_[i], share);
  out.below_.push_back(high.below_.front());
  out.share_ = share;
  return out;
}

double Backdrop::below(std::vector<double> Below::*what, double sine_of_depression) const {
  const double sine = camera_above_m_ > 0.0 ? nearest_m_ / camera_above_m_ * sine_of_depression : sine_of_depression;
  const double elevation = std::asin(std::min(sine, 1.0)), low = interpolated(below_.front().*what, elevation);
  return below_.size() == 1 ? low : std::lerp(low, interpolated(below_.back().*what, elevation), share_);
}

double Backdrop::radiance(double sine_of_elevation) const {
  if (sine_of_elevation < 0.0) return below(&Below::radiance, -sine_of_elevation);
  return interpolated(above_, std::asin(std::min(sine_of_elevation, 1.0)));
}

double Backdrop::path_radiance(double sine_of_elevation) const {
  return below(&Below::path, std::max(-sine_of_elevation, 0.0));
}

double Backdrop::range_m(double sine_of_elevation) const {
  if (sine_of_elevation >= 0.0 || camera_above_m_ <= 0.0) return std::numeric_limits<double>::infinity();
  return std::min(camera_above_m_ / -sine_of_elevation, kFarthest_m);
}

}  // namespace radiometry::render
