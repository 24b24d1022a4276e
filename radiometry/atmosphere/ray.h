// SPDX-License-Identifier: Apache-2.0
#pragma once

// The way of light through spherical shells: n r sin theta = c. In a layer n r is a straight line of the altitude with
// the slope g, so that the way is a straight line past a centre at the distance m / g, m = n r; with C = m^2 - c^2 the
// length from one altitude to another is |sqrt(C1) - sqrt(C2)| / g.

#include <limits>
#include <optional>
#include <vector>

#include "radiometry/atmosphere/column.h"

namespace radiometry::atmosphere {

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
  std::vector<Piece<S>> pieces;
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

/// From an altitude within the column along the cosine of the zenith angle. `bounded`: the ground ends it and pieces
/// are kept; otherwise the lowest and the highest layer go on for ever.
template <class S>
Ray<S> trace(const Column<S>& column, double from_m, const S& cosine, const RayEnd<S>& end, bool bounded = true) {
  using std::sqrt;
  const auto& z = column.altitude_m;
  const std::size_t last = z.size() - 2;
  bool up = value_of(cosine) >= 0.0;
  std::size_t layer = 0;
  while (layer < last && (up ? from_m >= z[layer + 1] : from_m > z[layer + 1])) ++layer;
  S at(from_m), slope = slope_of(column, layer);
  const S start = column.bent[layer] + (from_m - z[layer]) * slope;
  const S invariant2 = start * start * (1.0 - cosine * cosine);
  S bent = start, root = start * (up ? cosine : S(-cosine));
  Ray<S> ray{.pieces = {}, .end_m = at, .length_m = S(0.0), .lowest_m = at};
  for (;;) {
    slope = slope_of(column, layer);
    const double lower = layer > 0 ? z[layer]
                         : bounded ? z[0] - kGroundSlack_m
                                   : -std::numeric_limits<double>::infinity();
    const double upper = layer < last || bounded ? z[layer + 1] : std::numeric_limits<double>::infinity();
    double stop = up ? upper : lower;
    bool arrives = false;
    if (end.altitude_m && (up ? *end.altitude_m <= upper && *end.altitude_m > value_of(at)
                              : *end.altitude_m >= lower && *end.altitude_m < value_of(at))) {
      stop = *end.altitude_m;
      arrives = true;
    }
    Piece<S> piece{.layer = layer,
                   .up = up,
                   .from_m = at,
                   .to_m = S(stop),
                   .length_m = S(0.0),
                   .bent = bent,
                   .root = root,
                   .slope = slope};
    S next_bent(0.0), next_root(0.0);
    bool turns = false;
    if (std::isfinite(stop)) {
      next_bent = column.bent[layer] + (stop - z[layer]) * slope;
      const S left = (next_bent - start) * (next_bent + start) + start * start * cosine * cosine;
      turns = !up && value_of(left) <= 0.0;
      next_root = root_of(left);
      const S sum = next_root + root;
      piece.length_m = value_of(sum) > 0.0 ? S((next_bent - bent) * (next_bent + bent) / (slope * sum)) : S(0.0);
      if (!up) piece.length_m = -piece.length_m;
    } else {
      turns = !up;
      if (up) piece.length_m = S(std::numeric_limits<double>::infinity());
    }
    if (turns) {  // the tangent height lies in this layer
      arrives = false;
      next_bent = sqrt(invariant2);
      next_root = S(0.0);
      piece.length_m = root / slope;
      piece.to_m = at - root * root / ((next_bent + bent) * slope);
    }
    if (end.range_m && value_of(ray.length_m + piece.length_m) >= value_of(*end.range_m)) {
      piece = cut(piece, S(*end.range_m - ray.length_m));
      arrives = true;
      turns = false;
    }
    if (value_of(piece.length_m) > 0.0 || arrives) ray.pieces.push_back(piece);
    ray.length_m = ray.length_m + piece.length_m;
    at = ray.end_m = piece.to_m;
    bent = next_bent;
    root = next_root;
    if (value_of(at) < value_of(ray.lowest_m)) ray.lowest_m = at;
    if (arrives) return ray;
    if (turns) {
      up = true;
    } else if (up) {
      if (layer == last) {
        ray.end = Ray<S>::End::space;
        return ray;
      }
      ++layer;
    } else {
      if (layer == 0) {
        ray.end = Ray<S>::End::ground;
        return ray;
      }
      --layer;
    }
  }
}

}  // namespace radiometry::atmosphere
