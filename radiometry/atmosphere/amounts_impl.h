// SPDX-License-Identifier: Apache-2.0
#pragma once

// Densities along a line of sight, integrated layer by layer.

#include "radiometry/atmosphere/line.h"

namespace radiometry::atmosphere {

/// (e^x - 1) / x with its slope.
template <class S>
S growth(const S& x) {
  const double r = value_of(x);
  if (std::abs(r) < 1e-2)
    return lift({1.0 + r / 2.0 * (1.0 + r / 3.0 * (1.0 + r / 4.0 * (1.0 + r / 5.0))),
                 0.5 + r / 3.0 + r * r / 8.0 + r * r * r / 30.0},
                x);
  const double e = std::expm1(r);
  return lift({e / r, (e * (r - 1.0) + r) / (r * r)}, x);
}

/// Parts of a piece in which the altitude is a straight line of the length, within 5 cm.
template <class S>
struct Part {
  S from, to;  ///< share of the layer's height, rising
  S length_km;
};
template <class S>
std::vector<Part<S>> parts_of(const Column<S>& column, const Piece<S>& piece) {
  constexpr double kStraight_m = 0.05;
  const double z = column.altitude_m[piece.layer], height = column.altitude_m[piece.layer + 1] - z;
  const double length = value_of(piece.length_m);
  const int parts = std::max(1, static_cast<int>(std::ceil(length / std::sqrt(8.0 * kEarthRadius_m * kStraight_m))));
  // A line that is nearly vertical bends less: its sine is that of C = m^2 - c^2.
  const double cosine = std::min(1.0, value_of(piece.root) / value_of(piece.bent));
  const int count = std::max(1, static_cast<int>(std::ceil(parts * std::sqrt(1.0 - cosine * cosine))));
  std::vector<Part<S>> out;
  S before = (piece.from_m - z) / height;
  for (int i = 1; i <= count; ++i) {
    const double share = static_cast<double>(i) / count;
    const S after = ((i < count ? altitude_along(piece, S(share * piece.length_m)) : piece.to_m) - z) / height;
    const S length_km = 1e-3 / count * piece.length_m;
    out.push_back(piece.up ? Part<S>{before, after, length_km} : Part<S>{after, before, length_km});
    before = after;
  }
  return out;
}

/// Integrals of the densities along a piece, per km.
template <class S>
std::array<S, kDensities> integrals(const Column<S>& column, const Piece<S>& piece) {
  using std::exp;
  const auto parts = parts_of(column, piece);
  const auto &below = column.density[piece.layer], &above = column.density[piece.layer + 1];
  const auto& ratio = column.log_ratio[piece.layer];
  std::array<S, kDensities> out{};
  for (std::size_t k = 0; k < column.densities; ++k) {
    const bool exponential = value_of(below[k]) > 0.0 && value_of(above[k]) > 0.0;
    if (!exponential && !(value_of(below[k]) > 0.0) && !(value_of(above[k]) > 0.0)) continue;
    S sum(0.0);
    for (const Part<S>& part : parts) {
      if (exponential) {
        const S start = value_of(part.from) == 0.0 ? below[k] : S(below[k] * exp(ratio[k] * part.from));
        sum = sum + start * growth(S(ratio[k] * (part.to - part.from))) * part.length_km;
      } else {
        const S middle = 0.5 * (part.from + part.to);
        const S mean = below[k] + middle * (above[k] - below[k]);
        if (value_of(mean) > 0.0) sum = sum + mean * part.length_km;
      }
    }
    out[k] = sum;
  }
  return out;
}

/// Amounts of integrals over a layer of that mean temperature, but for the aerosol.
template <class S>
Amounts<S> amounts_of(const std::array<S, kDensities>& sum, const S& temperature_k) {
  constexpr double kCold_k = 260.0, kWarm_k = 296.0, kOxygenFrom_k = 200.0, kOxygenTo_k = 310.0;
  const auto clamped = [](const S& x, double lo, double hi) {
    return value_of(x) < lo ? S(lo) : value_of(x) > hi ? S(hi) : x;
  };
  const S theta = (kWarm_k - clamped(temperature_k, kCold_k, kWarm_k)) / (kWarm_k - kCold_k);
  const S t = (clamped(temperature_k, kOxygenFrom_k, kOxygenTo_k) - 250.0) / 100.0;
  Amounts<S> out;
  std::copy_n(sum.begin(), kLineBands, out.lines.begin());
  out.water_foreign = sum[kForeign];
  out.water_self_296 = sum[kSelf] * (1.0 - theta);
  out.water_self_260 = sum[kSelf] * theta;
  out.nitrogen = sum[kNitrogenDensity];
  out.oxygen = {sum[kOxygenDensity], sum[kOxygenDensity] * t, sum[kOxygenDensity] * t * t};
  out.molecules = sum[kMoleculesDensity];
  out.rain = sum[kRainDensity];
  return out;
}

template <class S>
std::array<S, kDensities> integrals(const Line<S>& line, const Piece<S>& piece) {
  if (!line.horizontal) return integrals(line.column, piece);
  auto sum = line.at_sensor;
  for (S& s : sum) s = 1e-3 * piece.length_m * s;
  return sum;
}

/// The layers of a line, and parts of them.
template <class S>
class LineLayers {
 public:
  explicit LineLayers(const Line<S>& line) : line_(line) {
    Boundary boundary{};
    for (std::size_t i = 0; i < line.pieces.size(); ++i) {
      const auto sum = integrals(line, line.pieces[i]);
      before_.push_back(boundary);
      boundary = after(i, sum);
      layers.push_back(layer_of(i, line.pieces[i], sum, boundary));
    }
  }

  /// A piece that is the i-th one up to some length.
  PathLayer<S> part(std::size_t i, const Piece<S>& piece) const {
    const auto sum = integrals(line_, piece);
    return layer_of(i, piece, sum, after(i, sum));
  }

  std::vector<PathLayer<S>> layers;

 private:
  /// The boundary region up to some length: extinction at 0.55 um, that times the humidity, optical depths.
  struct Boundary {
    S extinction, humid;
    std::array<S, kAerosolNodes> depth;
  };

  PathLayer<S> layer_of(std::size_t i, const Piece<S>& piece, const std::array<S, kDensities>& sum,
                        const Boundary& boundary) const {
    const auto& air = value_of(sum[kMassDensity]) > 0.0 ? sum : line_.at_sensor;
    const S temperature = air[kPressureDensity] / air[kMassDensity];
    PathLayer<S> layer{amounts_of(sum, temperature), temperature, piece.length_m};
    for (std::size_t k = 0; k < kAerosolNodes; ++k) layer.amounts.aerosol[k] = boundary.depth[k] - before_[i].depth[k];
    for (std::size_t region = 1; line_.haze != HazeKind::none && region < kAerosolRegions; ++region) {
      const S& extinction = sum[kAerosolDensity + region];
      const auto spectrum = upper_spectrum(static_cast<AerosolRegion>(region), line_.loss);
      for (std::size_t k = 0; k < kAerosolNodes; ++k)
        layer.amounts.aerosol[k] = layer.amounts.aerosol[k] + extinction * spectrum[k];
    }
    return layer;
  }

  /// With what the i-th piece, or a part of it, adds: the spectrum is that of the mean humidity so far, weighted by the
  /// extinction, and nothing becomes less.
  Boundary after(std::size_t i, const std::array<S, kDensities>& sum) const {
    Boundary boundary = before_[i];
    boundary.extinction = boundary.extinction + sum[kAerosolDensity];
    boundary.humid = boundary.humid + sum[kHumidAerosolDensity];
    const bool some = value_of(boundary.extinction) > 0.0;  // else the air at the sensor tells the slope
    const S& extinction = some ? boundary.extinction : line_.at_sensor[kAerosolDensity];
    const S& humid = some ? boundary.humid : line_.at_sensor[kHumidAerosolDensity];
    if (!(value_of(extinction) > 0.0)) return boundary;
    const auto spectrum = boundary_spectrum(line_.haze, line_.loss, S(humid / extinction));
    for (std::size_t k = 0; k < kAerosolNodes; ++k) {
      const S depth = boundary.extinction * spectrum[k];
      if (value_of(depth) >= value_of(boundary.depth[k])) boundary.depth[k] = depth;
    }
    return boundary;
  }
  const Line<S>& line_;
  std::vector<Boundary> before_;
};

/// Calls f(value, value) for the amounts of both, one by one.
template <class S, class F>
void for_each_amount(Amounts<S>& a, const Amounts<S>& b, const F& f) {
  for (std::size_t i = 0; i < kLineBands; ++i) f(a.lines[i], b.lines[i]);
  f(a.water_foreign, b.water_foreign);
  f(a.water_self_296, b.water_self_296);
  f(a.water_self_260, b.water_self_260);
  f(a.nitrogen, b.nitrogen);
  for (std::size_t i = 0; i < 3; ++i) f(a.oxygen[i], b.oxygen[i]);
  f(a.molecules, b.molecules);
  for (std::size_t i = 0; i < kAerosolNodes; ++i) f(a.aerosol[i], b.aerosol[i]);
  f(a.rain, b.rain);
}

template <class S>
Amounts<S> sum_of(Amounts<S> a, const Amounts<S>& b) {
  for_each_amount(a, b, [](S& x, const S& y) { x = x + y; });
  return a;
}

template <class S>
std::vector<PathLayer<S>> path_layers(const Air<S>& air, const Sight<S>& sight) {
  const Line<S> line = line_of(air, sight);
  return LineLayers<S>(line).layers;
}

template <class S>
SightNumbers<S> sight_numbers(const Air<S>& air, const Sight<S>& sight) {
  return line_of(air, sight).numbers;
}

}  // namespace radiometry::atmosphere
