// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/backdrop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace radiometry::render {
namespace {

constexpr double kRight = 0.5 * std::numbers::pi;
constexpr double kLowest = 1e-4;     // rad: lines nearer to the horizon are taken to have this elevation
constexpr std::size_t kRanges = 97;  // a seventh farther each, from 1 m
constexpr double kNearest_m = 0.01;
constexpr double kFarthest_m = 300e3;  // of a ground that the air does not hide

/// At a share of the way through `of` values.
CubicPlace cubic_between(double share, std::size_t of) {
  return cubic_place(std::clamp(share, 0.0, 1.0) * static_cast<double>(of - 1), of);
}

double interpolated(const std::vector<double>& values, const CubicPlace& place) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 4; ++k) sum += place.weight[k] * values[place.first + k];
  return sum;
}

}  // namespace

double sky_elevation(std::size_t k) {
  const double root = static_cast<double>(k) / (kSkyElevations - 1);
  return std::max(kRight * root * root, kLowest);
}

CubicPlace elevation_place(double elevation_rad) {
  return cubic_between(std::sqrt(std::clamp(elevation_rad / kRight, 0.0, 1.0)), kSkyElevations);
}

Backdrop::Backdrop(const RenderScene& scene, const BandNodes& nodes, const LightSources& sources, const AirView* view,
                   double camera_height_m, double ground_m, std::optional<double> nearest_m)
    : camera_above_m_(camera_height_m - ground_m),
      nearest_m_(std::clamp(nearest_m.value_or(camera_above_m_), kNearest_m, 0.5 * kFarthest_m)) {
  below_.emplace_back();
  const AirView* layered = view != nullptr && view->layered() ? view : nullptr;
  const std::vector<double> ground = fold(nodes, sources.radiance[sources.ground()]);
  std::vector<double> air;
  if (view != nullptr) air = fold(nodes, blackbody_at(nodes, view->reference_k()));
  for (std::size_t i = 0; i < kSkyElevations; ++i) {
    const double elevation = sky_elevation(i);
    above_.push_back(integral(nodes, sky_at(scene.sky, nodes, layered, kRight - elevation)));
  }
  for (std::size_t i = 0; i < kRanges; ++i) {
    const double share = static_cast<double>(i) / (kRanges - 1);
    double sum = 0.0, added = 0.0;
    if (view == nullptr || camera_above_m_ <= 0.0) {
      for (const double part : ground) sum += part;
    } else {
      const AirSamples path = view->to(nearest_m_ * std::pow(kFarthest_m / nearest_m_, share), ground_m);
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
  if (camera_above_m_ <= 0.0) return (below_.front().*what).front();
  const double range_m = camera_above_m_ / sine_of_depression;
  const CubicPlace place = cubic_between(std::log(range_m / nearest_m_) / std::log(kFarthest_m / nearest_m_), kRanges);
  const double low = interpolated(below_.front().*what, place);
  return below_.size() == 1 ? low : std::lerp(low, interpolated(below_.back().*what, place), share_);
}

double Backdrop::radiance(double sine_of_elevation) const {
  if (sine_of_elevation < 0.0) return below(&Below::radiance, -sine_of_elevation);
  return interpolated(above_, elevation_place(std::asin(std::min(sine_of_elevation, 1.0))));
}

double Backdrop::path_radiance(double sine_of_elevation) const {
  return below(&Below::path, std::max(-sine_of_elevation, 0.0));
}

double Backdrop::range_m(double sine_of_elevation) const {
  if (sine_of_elevation >= 0.0 || camera_above_m_ <= 0.0) return std::numeric_limits<double>::infinity();
  return camera_above_m_ / -sine_of_elevation;
}

}  // namespace radiometry::render
