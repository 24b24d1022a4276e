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

}  // namespace radiometry::atmosphere
