// SPDX-License-Identifier: Apache-2.0
#pragma once

// A line of sight in its layers: what the spectral stage goes along.
//   column   what the air holds at each altitude that the model computes with: the amount of every absorber per km,
//            and, for refraction, the refractive index times the distance from the centre of the earth (n r)
//   ray      the way of light through spherical shells: n r sin theta = c. In a layer n r is a straight line of the
//            altitude with the slope g, so that the way is a straight line past a centre at the distance m / g, m = n
//            r; with C = m^2 - c^2 the length from one altitude to another is |sqrt(C1) - sqrt(C2)| / g
//   line     either, or level air, from the sensor on, checked

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "radiometry/atmosphere/air_impl.h"

namespace radiometry::atmosphere {

/// Indices of the densities, in the order of Amounts; self: h^2, oxygen: u P / P0.
enum Density : std::size_t {
  kForeign = kLineBands,
  kSelf,
  kNitrogenDensity,
  kOxygenDensity,
  kMoleculesDensity,
  kRainDensity,
  kPressureDensity,  ///< Pa
  kMassDensity,      ///< Pa / K
  kAerosolDensity,   ///< extinction at 0.55 um, of each region
  kHumidAerosolDensity =
      kAerosolDensity + kAerosolRegions,  ///< that of the boundary region times the humidity in percent
  kDensities
};

template <class S>
struct Column {
  std::vector<double> altitude_m;
  std::vector<S> bent;  ///< n r at the levels, up to a common factor; a straight line of the altitude between them
  std::vector<std::array<S, kDensities>> density;
  std::vector<std::array<S, kDensities>> log_ratio;  ///< of each layer: ln(above / below), where both are above 0
  std::size_t densities = kDensities;                ///< without aerosol: fewer
};

/// (n - 1) of air at 2000 cm^-1, Edlen's formula.
template <class S>
S refractivity(const Level<S>& level) {
  const double nu = 2000.0;
  const double dry = 83.42 + 185.08 / (1.0 - nu * nu / (1.14e5 * 1.14e5)) + 4.11 / (1.0 - nu * nu / (6.24e4 * 6.24e4));
  const double vapour = 43.49 - nu * nu / (1.7e4 * 1.7e4);
  const S pressure = level.pressure_pa / kStandard_pa;
  return 1e-6 * pressure * (dry * 288.15 / level.temperature_k - vapour * 1e-6 * level[Gas::water]);
}

template <class S>
std::array<S, kDensities> densities_of(const Air<S>& air, Level<S> level) {
  using std::exp, std::log, std::sqrt;
  constexpr double kReference_k = 296.0, kRainTop_m = 6000.0;
  const bool rains = value_of(air.rain_mm_h) > 0.0 && level.altitude_m <= kRainTop_m;
  if (rains) level[Gas::water] = water_ppm(level.pressure_pa, level.temperature_k, S(100.0));
  std::array<S, kDensities> out;
  const S n = air_per_cm3(level.pressure_pa, level.temperature_k);
  const S pressure = level.pressure_pa / kStandard_pa, cold = kReference_k / level.temperature_k;
  const S log_pressure = log(pressure), log_cold = log(cold);
  const auto laws = band_laws();
  for (std::size_t i = 0; i < kLineBands; ++i)  // 1e20 molecules per cm^2 and km
    out[i] = 1e-21 * n * level[laws[i].gas] * exp(laws[i].n * log_pressure + laws[i].m * log_cold);
  const S h = 1e-25 * n * level[Gas::water], whole = 1e-19 * n;
  out[kForeign] = h * (whole - h);
  out[kSelf] = h * h;
  out[kNitrogenDensity] = pressure * pressure * cold * sqrt(cold);
  out[kOxygenDensity] = 1e-21 * n * level[Gas::oxygen] * pressure;
  out[kMoleculesDensity] = pressure * cold;
  out[kRainDensity] = level.altitude_m <= kRainTop_m ? rain_per_km(air.rain_mm_h) : S(0.0);
  out[kPressureDensity] = level.pressure_pa;
  out[kMassDensity] = level.pressure_pa / level.temperature_k;
  const auto aerosol = aerosol_per_km(air.haze, level.altitude_m);
  std::ranges::copy(aerosol, out.begin() + kAerosolDensity);
  out[kHumidAerosolDensity] =
      value_of(aerosol[0]) > 0.0 ? S(aerosol[0] * (rains ? S(100.0) : relative_humidity_percent(level))) : S(0.0);
  return out;
}

/// The levels of the profile, and between them the altitudes at which the model divides its layers.
template <class S>
std::vector<Level<S>> refined_levels(const Profile<S>& profile) {
  std::vector<double> altitudes;
  for (int km = 0; km <= 25; ++km) altitudes.push_back(1000.0 * km);
  for (const double km : {30.0, 35.0, 40.0, 45.0, 50.0, 70.0, 100.0}) altitudes.push_back(1000.0 * km);
  std::vector<Level<S>> levels;
  for (std::size_t i = 0; i < profile.levels.size(); ++i) {
    if (i > 0)
      for (const double z : altitudes)
        if (z > profile.levels[i - 1].altitude_m && z < profile.levels[i].altitude_m)
          levels.push_back(level_between(profile.levels[i - 1], profile.levels[i], z));
    levels.push_back(profile.levels[i]);
  }
  return levels;
}

template <class S>
Column<S> column_of(const Air<S>& air) {
  using std::log;
  constexpr double kLeastBend = 0.1;  // of d(n r)/dr: below it light would circle the earth, in layers that do not last
  Column<S> column;
  if (air.haze.kind == HazeKind::none) column.densities = kAerosolDensity;
  const auto levels = refined_levels(air.profile);
  for (const Level<S>& level : levels) {
    column.altitude_m.push_back(level.altitude_m);
    column.density.push_back(densities_of(air, level));
  }
  column.bent.push_back(S(kEarthRadius_m + levels.front().altitude_m));
  column.log_ratio.resize(levels.size() - 1);
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
    const double radius = kEarthRadius_m + levels[i].altitude_m, step = levels[i + 1].altitude_m - levels[i].altitude_m;
    const S index = (1.0 + refractivity(levels[i + 1])) / (1.0 + refractivity(levels[i]));
    S rise = index * (1.0 + step / radius) - 1.0;
    if (value_of(rise) < kLeastBend * step / radius) rise = S(kLeastBend * step / radius);
    column.bent.push_back(column.bent[i] + column.bent[i] * rise);
    for (std::size_t k = 0; k < column.densities; ++k) {
      const S &below = column.density[i][k], &above = column.density[i + 1][k];
      if (value_of(below) > 0.0 && value_of(above) > 0.0) column.log_ratio[i][k] = log(above / below);
    }
  }
  return column;
}

/// A part of a ray in one layer, up or down all along.
template <class S>
struct Piece {
  std::size_t layer = 0;
  bool up = true;
  S from_m{}, to_m{}, length_m{};
  S bent{}, root{}, slope{};  ///< m and sqrt(C) where it starts, g
};

template <class S>
struct Ray {
  std::vector<Piece<S>> pieces{};
  S end_m{}, length_m{}, lowest_m{};
  enum class End { arrived, ground, space } end = End::arrived;
};

template <class S>
struct RayEnd {
  std::optional<S> range_m{};
  std::optional<double> altitude_m{};
};

/// How far a line may dip below the lowest level: no ground is even to a metre.
inline constexpr double kGroundSlack_m = 1.0;

template <class S>
S root_of(const S& x) {
  using std::sqrt;
  return value_of(x) > 0.0 ? S(sqrt(x)) : S(0.0);
}

template <class S>
S slope_of(const Column<S>& column, std::size_t layer) {
  return (column.bent[layer + 1] - column.bent[layer]) / (column.altitude_m[layer + 1] - column.altitude_m[layer]);
}

/// The altitude at a length from the start of a piece.
template <class S>
S altitude_along(const Piece<S>& piece, const S& length_m) {
  using std::sqrt;
  const S root = piece.up ? S(piece.root + piece.slope * length_m) : S(piece.root - piece.slope * length_m);
  const S more = (root - piece.root) * (root + piece.root);
  return piece.from_m + more / ((sqrt(piece.bent * piece.bent + more) + piece.bent) * piece.slope);
}

/// The first part of a piece.
template <class S>
Piece<S> cut(const Piece<S>& piece, const S& length_m) {
  Piece<S> out = piece;
  out.to_m = altitude_along(piece, length_m);
  out.length_m = length_m;
  return out;
}

/// A piece from where a ray is to where it leaves the layer or, on the way down, has its tangent height. `unbounded`:
/// the lowest and the highest layer go on for ever.
template <class S>
struct WayThrough {
  Piece<S> piece;
  S bent{}, root{};  ///< m and sqrt(C) at its end
  bool turns = false;
};
template <class S>
WayThrough<S> way_through(const Column<S>& column, Piece<S> piece, bool unbounded) {
  using std::sqrt;
  const auto& z = column.altitude_m;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const bool lowest = piece.layer == 0, highest = piece.layer + 2 == z.size();
  const double stop = piece.up ? (highest && unbounded ? kInfinity : z[piece.layer + 1])
                               : (!lowest     ? z[piece.layer]
                                  : unbounded ? -kInfinity
                                              : z[0] - kGroundSlack_m);
  WayThrough<S> way{.piece = piece, .bent = S(0.0), .root = S(0.0)};
  if (std::isfinite(stop)) {
    way.bent = column.bent[piece.layer] + (stop - z[piece.layer]) * piece.slope;
    const S more = (way.bent - piece.bent) * (way.bent + piece.bent), left = more + piece.root * piece.root;
    way.turns = !piece.up && value_of(left) <= 0.0;
    way.root = root_of(left);
    const S sum = way.root + piece.root;
    way.piece.length_m = value_of(sum) > 0.0 ? S(more / (piece.slope * sum)) : S(0.0);
    if (!piece.up) way.piece.length_m = -way.piece.length_m;
    way.piece.to_m = S(stop);
  } else {
    way.turns = !piece.up;
    way.piece.length_m = S(kInfinity);
  }
  if (way.turns) {
    way.bent = sqrt(piece.bent * piece.bent - piece.root * piece.root);
    way.root = S(0.0);
    way.piece.length_m = piece.root / piece.slope;
    way.piece.to_m = piece.from_m - piece.root * piece.root / ((way.bent + piece.bent) * piece.slope);
  }
  return way;
}

/// From an altitude within the column along the cosine of the zenith angle, to the end or, if `unbounded` is false, to
/// the ground or the highest level.
template <class S>
Ray<S> trace(const Column<S>& column, double from_m, const S& cosine, const RayEnd<S>& end, bool unbounded = false) {
  const auto& z = column.altitude_m;
  const std::size_t last = z.size() - 2;
  Piece<S> next{.layer = 0, .up = value_of(cosine) >= 0.0, .from_m = S(from_m), .to_m = S(from_m), .length_m = S(0.0)};
  while (next.layer < last && (next.up ? from_m >= z[next.layer + 1] : from_m > z[next.layer + 1])) ++next.layer;
  next.slope = slope_of(column, next.layer);
  next.bent = column.bent[next.layer] + (from_m - z[next.layer]) * next.slope;
  next.root = next.bent * (next.up ? cosine : S(-cosine));
  Ray<S> ray{.end_m = next.from_m, .length_m = S(0.0), .lowest_m = next.from_m};
  for (;;) {
    next.slope = slope_of(column, next.layer);
    const WayThrough<S> way = way_through(column, next, unbounded);
    Piece<S> piece = way.piece;
    bool arrives = false;
    if (end.altitude_m) {
      const double to = *end.altitude_m, at = value_of(piece.from_m), stop = value_of(piece.to_m);
      if (piece.up ? to > at && to <= stop : to < at && to >= stop) {
        const S bent = piece.bent + (S(to) - piece.from_m) * piece.slope;
        const S more = (bent - piece.bent) * (bent + piece.bent);
        const S sum = root_of(S(more + piece.root * piece.root)) + piece.root;
        piece.to_m = S(to);
        piece.length_m = value_of(sum) > 0.0 ? S(more / (piece.slope * sum)) : S(0.0);
        if (!piece.up) piece.length_m = -piece.length_m;
        arrives = true;
      }
    }
    if (end.range_m && value_of(ray.length_m + piece.length_m) >= value_of(*end.range_m)) {
      piece = cut(piece, S(*end.range_m - ray.length_m));
      arrives = true;
    }
    if (value_of(piece.length_m) > 0.0 || arrives) ray.pieces.push_back(piece);
    ray.length_m = ray.length_m + piece.length_m;
    ray.end_m = piece.to_m;
    if (value_of(ray.end_m) < value_of(ray.lowest_m)) ray.lowest_m = ray.end_m;
    if (arrives) return ray;
    next = {.layer = next.layer,
            .up = next.up || way.turns,
            .from_m = piece.to_m,
            .to_m = piece.to_m,
            .length_m = S(0.0),
            .bent = way.bent,
            .root = way.root,
            .slope = next.slope};
    if (way.turns) continue;
    if (next.layer == (next.up ? last : 0)) {
      ray.end = next.up ? Ray<S>::End::space : Ray<S>::End::ground;
      return ray;
    }
    next.up ? ++next.layer : --next.layer;
  }
}

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
