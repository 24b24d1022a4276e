// SPDX-License-Identifier: Apache-2.0
#pragma once

// A line of sight in its layers: what the spectral stage goes along.

#include "radiometry/atmosphere/ray.h"

namespace radiometry::atmosphere {

template <class S>
struct Line {
  bool horizontal = false;
  Column<S> column{};              ///< of Horizontal: one level, the air of the line
  std::vector<Piece<S>> pieces{};  ///< of Horizontal: one
  std::array<S, kDensities> at_sensor{};
  HazeKind haze = HazeKind::none;
  AerosolLoss loss = AerosolLoss::extinction;
  SightNumbers<S> numbers{};
};

[[noreturn]] void refuse_sensor(const std::string& source, double altitude_m, double lowest_m, double highest_m);
[[noreturn]] void refuse_one_level(const std::string& source);
[[noreturn]] void refuse_range(double range_m);
[[noreturn]] void refuse_level_range(double range_m);
[[noreturn]] void refuse_zenith(double zenith_rad);
[[noreturn]] void refuse_nearer(double range_m, double from_m, double to_m);
[[noreturn]] void refuse_ground(double range_m, double length_m, double from_m);
[[noreturn]] void refuse_horizon(double range_m, double from_m, double to_m, double horizon_m);
[[noreturn]] void refuse_altitude(double altitude_m, double zenith_rad, double tangent_m);

inline double checked_range(double range_m) {
  if (!(range_m >= 0.0) || !std::isfinite(range_m)) refuse_range(range_m);
  return range_m;
}

/// The longest line from one altitude to another that passes the lowest level.
template <class S>
double horizon_m(const Column<S>& column, double from_m, double to_m) {
  const double ground = column.altitude_m.front();
  double sum = 0.0;
  for (const double z : {from_m, to_m})
    if (z > ground) sum += value_of(trace(column, ground, S(0.0), {.altitude_m = z}).length_m);
  return sum;
}

/// The cosine of the zenith angle with which a line of that range gets to an altitude: the altitude at a range rises
/// with the cosine, from straight down to straight up. Its derivatives by one step of Newton's.
template <class S>
S cosine_between(const Column<S>& column, double from_m, double to_m, const S& range_m) {
  const double range = value_of(range_m);
  if (range == 0.0) return S(0.0);
  if (std::abs(to_m - from_m) > range * (1.0 + 1e-12)) refuse_nearer(range, from_m, to_m);
  const auto miss = [&](double cosine) {
    return value_of(trace(column, from_m, S(cosine), {.range_m = S(range)}, true).end_m) - to_m;
  };
  double lo = -1.0, hi = 1.0, at_lo = miss(lo), at_hi = miss(hi);
  double x = std::clamp((to_m - from_m) / range - range / (2.0 * kEarthRadius_m), -1.0, 1.0);
  for (int step = 0; step < 200 && hi - lo > 1e-15; ++step) {  // Illinois
    const double y = miss(x);
    if (y == 0.0) break;
    if (y < 0.0)
      lo = x, at_lo = y, at_hi *= step > 0 ? 0.5 : 1.0;
    else
      hi = x, at_hi = y, at_lo *= step > 0 ? 0.5 : 1.0;
    if (std::abs(y) < 1e-9) break;
    const double next = lo - at_lo * (hi - lo) / (at_hi - at_lo);
    x = next > lo && next < hi && step % 4 != 3 ? next : 0.5 * (lo + hi);
  }
  if constexpr (!requires(S s) { s.a; }) {
    return x;
  } else {
    const double h = 1e-6, slope = (miss(std::min(x + h, 1.0)) - miss(std::max(x - h, -1.0))) /
                                   (std::min(x + h, 1.0) - std::max(x - h, -1.0));
    const S missed = trace(column, from_m, S(x), {.range_m = range_m}, true).end_m;
    return S(x) - (missed - S(value_of(missed))) / slope;
  }
}

template <class S>
S angle_of(const S& cosine) {
  const double c = std::clamp(value_of(cosine), -1.0, 1.0);
  const double sine = std::sqrt((1.0 - c) * (1.0 + c));
  return lift({std::acos(c), sine > 0.0 ? -1.0 / sine : 0.0}, cosine);
}

template <class S>
Line<S> line_of(const Air<S>& air, const Horizontal<S>& sight) {
  constexpr double kQuarterOfEarth_m = 1e7;
  if (checked_range(value_of(sight.range_m)) > kQuarterOfEarth_m) refuse_level_range(value_of(sight.range_m));
  Line<S> line{.horizontal = true};
  if (!(sight.altitude_m >= -500.0 && sight.altitude_m <= 120000.0))
    refuse_sensor(air.profile.source, sight.altitude_m, -500.0, 120000.0);
  line.at_sensor = densities_of(air, level_at(air.profile, sight.altitude_m));
  if (air.haze.kind == HazeKind::none) line.column.densities = kAerosolDensity;
  const S z(sight.altitude_m);
  line.pieces.push_back({.layer = 0,
                         .up = true,
                         .from_m = z,
                         .to_m = z,
                         .length_m = sight.range_m,
                         .bent = S(0.0),
                         .root = S(0.0),
                         .slope = S(0.0)});
  line.numbers = {
      .range_m = sight.range_m, .zenith_rad = S(0.5 * mtf::kPi), .object_altitude_m = z, .lowest_altitude_m = z};
  return line;
}

/// The column and the air at the sensor, checked.
template <class S>
Line<S> line_from(const Air<S>& air, double altitude_m) {
  const auto& levels = air.profile.levels;
  if (levels.size() == 1) refuse_one_level(air.profile.source);
  if (!(altitude_m >= levels.front().altitude_m && altitude_m <= levels.back().altitude_m))
    refuse_sensor(air.profile.source, altitude_m, levels.front().altitude_m, levels.back().altitude_m);
  Line<S> line{.horizontal = false, .column = column_of(air)};
  line.at_sensor = densities_of(air, level_at(air.profile, altitude_m));
  return line;
}

template <class S>
S cosine_of(const S& zenith_rad) {
  using std::cos;
  if (!(value_of(zenith_rad) >= 0.0 && value_of(zenith_rad) <= mtf::kPi)) refuse_zenith(value_of(zenith_rad));
  return cos(zenith_rad);
}

template <class S>
void take(Line<S>& line, Ray<S> ray, const S& zenith_rad) {
  line.pieces = std::move(ray.pieces);
  line.numbers = {.range_m = ray.length_m,
                  .zenith_rad = zenith_rad,
                  .object_altitude_m = ray.end_m,
                  .lowest_altitude_m = ray.lowest_m};
}

template <class S>
Line<S> line_of(const Air<S>& air, const Between<S>& sight) {
  const double range = checked_range(value_of(sight.range_m));
  Line<S> line = line_from(air, sight.sensor_altitude_m);
  const auto& z = line.column.altitude_m;
  if (!(sight.object_altitude_m >= z.front() && sight.object_altitude_m <= z.back()))
    refuse_sensor(air.profile.source, sight.object_altitude_m, z.front(), z.back());
  if (range == 0.0 && sight.sensor_altitude_m != sight.object_altitude_m)
    refuse_nearer(range, sight.sensor_altitude_m, sight.object_altitude_m);
  const S cosine = cosine_between(line.column, sight.sensor_altitude_m, sight.object_altitude_m, sight.range_m);
  Ray<S> ray = trace(line.column, sight.sensor_altitude_m, cosine, {.range_m = sight.range_m});
  if (ray.end == Ray<S>::End::ground && value_of(ray.length_m) < range * (1.0 - 1e-9))
    refuse_horizon(range, sight.sensor_altitude_m, sight.object_altitude_m,
                   horizon_m(line.column, sight.sensor_altitude_m, sight.object_altitude_m));
  take(line, std::move(ray), angle_of(cosine));
  line.numbers.range_m = sight.range_m;
  return line;
}

template <class S>
Line<S> line_of(const Air<S>& air, const AtAngle<S>& sight) {
  const double range = checked_range(value_of(sight.range_m));
  const S cosine = cosine_of(sight.zenith_rad);
  Line<S> line = line_from(air, sight.sensor_altitude_m);
  Ray<S> ray = trace(line.column, sight.sensor_altitude_m, cosine, {.range_m = sight.range_m});
  if (ray.end == Ray<S>::End::ground) refuse_ground(range, value_of(ray.length_m), sight.sensor_altitude_m);
  const S beyond = trace(line.column, sight.sensor_altitude_m, cosine, {.range_m = sight.range_m}, true).end_m;
  take(line, std::move(ray), sight.zenith_rad);
  line.numbers.range_m = sight.range_m;  // the end may lie in space
  line.numbers.object_altitude_m = beyond;
  return line;
}

template <class S>
Line<S> line_of(const Air<S>& air, const ToAltitude<S>& sight) {
  const S cosine = cosine_of(sight.zenith_rad);
  Line<S> line = line_from(air, sight.sensor_altitude_m);
  const auto& z = line.column.altitude_m;
  if (!(sight.object_altitude_m >= z.front() && sight.object_altitude_m <= z.back()))
    refuse_sensor(air.profile.source, sight.object_altitude_m, z.front(), z.back());
  if (sight.object_altitude_m == sight.sensor_altitude_m) {
    take(line, Ray<S>{.end_m = S(sight.sensor_altitude_m), .length_m = S(0.0), .lowest_m = S(sight.sensor_altitude_m)},
         sight.zenith_rad);
    return line;
  }
  Ray<S> ray = trace(line.column, sight.sensor_altitude_m, cosine, {.altitude_m = sight.object_altitude_m});
  if (ray.end == Ray<S>::End::ground) refuse_ground(-1.0, value_of(ray.length_m), sight.sensor_altitude_m);
  if (ray.end == Ray<S>::End::space && value_of(ray.end_m) != sight.object_altitude_m)
    refuse_altitude(sight.object_altitude_m, value_of(sight.zenith_rad), value_of(ray.lowest_m));
  take(line, std::move(ray), sight.zenith_rad);
  return line;
}

template <class S>
Line<S> line_of(const Air<S>& air, const ToSpace<S>& sight) {
  const S cosine = cosine_of(sight.zenith_rad);
  Line<S> line = line_from(air, sight.sensor_altitude_m);
  Ray<S> ray = trace(line.column, sight.sensor_altitude_m, cosine, {});
  if (ray.end == Ray<S>::End::ground) refuse_ground(-1.0, value_of(ray.length_m), sight.sensor_altitude_m);
  take(line, std::move(ray), sight.zenith_rad);
  return line;
}

template <class S>
Line<S> line_of(const Air<S>& air, const Sight<S>& sight) {
  require_valid(air);
  Line<S> line = std::visit([&](const auto& one) { return line_of(air, one); }, sight);
  line.haze = air.haze.kind;
  line.loss = air.haze.loss;
  return line;
}

}  // namespace radiometry::atmosphere
