// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/sides_in_sun.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

using scene::operator-, scene::operator*;

constexpr std::size_t kLeaf = 8;  // triangles

Vector unit(const Vector& v) { return (1.0 / scene::length(v)) * v; }

}  // namespace

void SidesInSun::Box::take(const Corner& p) {
  left = std::min(left, p.x), right = std::max(right, p.x);
  low = std::min(low, p.y), high = std::max(high, p.y);
}

void SidesInSun::Box::take(const Box& other) {
  left = std::min(left, other.left), right = std::max(right, other.right);
  low = std::min(low, other.low), high = std::max(high, other.high);
}

SidesInSun::SidesInSun(const scene::Facets& facets, const Vector& to_sun, double lift_m, int threads)
    : facets_(&facets), to_sun_(to_sun), lift_m_(lift_m), place_(facets.vertices.size()) {
  // Any two axes that make a right-handed frame with the direction to the sun: what faces it runs counter-clockwise.
  const auto steep = [](double a, double b) { return std::abs(a) < std::abs(b); };
  Vector axis{};
  axis[static_cast<std::size_t>(std::min_element(to_sun.begin(), to_sun.end(), steep) - to_sun.begin())] = 1.0;
  const Vector x = unit(scene::cross(axis, to_sun)), y = unit(scene::cross(to_sun, x));
  for (std::size_t i = 0; i < place_.size(); ++i) {
    const Vector from_middle = facets.vertices[i] - facets.middle;
    place_[i] = {scene::dot(x, from_middle), scene::dot(y, from_middle)};
  }
  find_outlines();
  build_tree(threads);
}

/// Edges are gathered by their lower vertex.
void SidesInSun::find_outlines() {
  struct Use {
    std::uint32_t other, triangle;  ///< the higher vertex
    std::uint8_t edge;
    bool left;  ///< of the edge from its lower vertex to the higher one
  };
  const auto ends = [&](std::size_t t, std::size_t k) {
    return std::minmax(facets_->triangles[t][k], facets_->triangles[t][(k + 1) % 3]);
  };
  const std::size_t triangles = facets_->triangles.size();
  std::vector<std::size_t> first(facets_->vertices.size() + 1, 0);
  for (std::size_t t = 0; t < triangles; ++t)
    for (std::size_t k = 0; k < 3; ++k) ++first[ends(t, k).first + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Use> use(3 * triangles);
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::array<std::uint32_t, 3>& number = facets_->triangles[t];
    const auto &a = place_[number[0]], &b = place_[number[1]], &c = place_[number[2]];
    const bool faces = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    for (std::uint8_t k = 0; k < 3; ++k) {
      const auto [low, high] = ends(t, k);
      use[next[low]++] = {high, t, k, faces == (number[k] == low)};
    }
  }
  outline_.assign(triangles, 0);
  const auto by_other = [](const Use& a, const Use& b) { return a.other < b.other; };
  for (std::size_t v = 0; v + 1 < first.size(); ++v) {
    const std::span<Use> here = std::span(use).subspan(first[v], first[v + 1] - first[v]);
    std::sort(here.begin(), here.end(), by_other);
    for (auto from = here.begin(), to = from; from != here.end(); from = to) {
      to = std::upper_bound(from, here.end(), *from, by_other);
      if (to - from == 2 && from[0].left != from[1].left) continue;
      for (auto one = from; one != to; ++one) outline_[one->triangle] |= static_cast<std::uint8_t>(1U << one->edge);
    }
  }
}

/// Each node halves its triangles by their middles, along x and y in turn.
void SidesInSun::build_tree(int threads) {
  const std::size_t triangles = facets_->triangles.size();
  std::vector<std::array<double, 2>> middle(triangles);
  for (std::size_t t = 0; t < triangles; ++t)
    for (const std::uint32_t vertex : facets_->triangles[t])
      for (std::size_t axis = 0; axis < 2; ++axis) middle[t][axis] += place_[vertex][axis];
  std::size_t leaves = 1;
  while (triangles > leaves * kLeaf) leaves *= 2;  // as halving goes on while a node has more than kLeaf
  constexpr double kFar = std::numeric_limits<double>::infinity();
  box_.assign(2 * leaves - 1, {kFar, -kFar, kFar, -kFar});
  order_.resize(triangles);
  std::iota(order_.begin(), order_.end(), 0U);
  const auto place = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  const auto halve = [&](std::size_t first, std::size_t last, std::size_t axis) {
    const std::size_t half = std::midpoint(first, last);
    std::nth_element(place(first), place(half), place(last),
                     [&](std::uint32_t a, std::uint32_t b) { return middle[a][axis] < middle[b][axis]; });
    return half;
  };
  const std::function<void(std::size_t, std::size_t, std::size_t, std::size_t)> build = [&](std::size_t node,
                                                                                            std::size_t first,
                                                                                            std::size_t last,
                                                                                            std::size_t axis) {
    if (last - first <= kLeaf) {
      for (std::size_t i = first; i < last; ++i)
        for (const std::uint32_t vertex : facets_->triangles[order_[i]]) box_[node].take(corner(vertex));
      return;
    }
    const std::size_t half = halve(first, last, axis);
    const std::array<std::array<std::size_t, 3>, 2> parts{{{2 * node + 1, first, half}, {2 * node + 2, half, last}}};
    constexpr std::size_t kAlone = 1 << 14;  // triangles
    mtf::parallel_for(2, 1, last - first > kAlone ? threads : 1, [&](std::int64_t from, std::int64_t to) {
      for (auto k = static_cast<std::size_t>(from); k < static_cast<std::size_t>(to); ++k)
        build(parts[k][0], parts[k][1], parts[k][2], 1 - axis);
    });
    box_[node].take(box_[2 * node + 1]);
    box_[node].take(box_[2 * node + 2]);
  };
  build(0, 0, triangles, 0);
}

struct SidesInSun::Target {
  std::uint32_t facet;
  Vector up;  ///< the normal of the side
  Point on;   ///< in its plane
  /// An edge in the picture: how far a place is inside of it, m, is ahead * x + aside * y + rest.
  struct Edge {
    double ahead, aside, rest;
  };
  std::array<Edge, 3> edge{};
  Box box{};
  double height_m = 0.0;  ///< least; NaN where the sun sees it edge on, negative where it is turned over

  /// Corners counter-clockwise.
  Target(std::uint32_t of, const Vector& normal, const Point& in_plane, const std::array<Corner, 3>& own)
      : facet(of), up(normal), on(in_plane), box{own[0].x, own[0].x, own[0].y, own[0].y} {
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner &a = own[k], &b = own[(k + 1) % 3];
      const double dx = b.x - a.x, dy = b.y - a.y, per_length = 1.0 / std::hypot(dx, dy);
      edge[k] = {-dy * per_length, dx * per_length, (dy * a.x - dx * a.y) * per_length};
      box.take(a);
    }
    const std::array<double, 3> heights{inside(0, own[2]), inside(1, own[0]), inside(2, own[1])};
    height_m = std::isnan(heights[0] + heights[1] + heights[2]) ? heights[0] + heights[1] + heights[2]
                                                                : *std::min_element(heights.begin(), heights.end());
  }
  double inside(std::size_t k, const Corner& p) const {
    return edge[k].ahead * p.x + edge[k].aside * p.y + edge[k].rest;
  }
};

namespace {

/// A polygon of few corners.
template <class Corner>
struct Few {
  std::array<Corner, 8> corner;
  std::size_t count = 0;
  void add(const Corner& p) { corner[count++] = p; }
};

/// What of a polygon, or of a line as one of two corners, is within the target by more than `slack`.
template <class Target, class Corner>
void clip(const Target& target, double slack, Few<Corner>& shape) {
  for (std::size_t k = 0; k < 3 && shape.count > 0; ++k) {
    const Few<Corner> before = shape;
    shape.count = 0;
    const std::size_t lines = before.count == 2 ? 1 : before.count;
    for (std::size_t i = 0; i < before.count; ++i) {
      const Corner &p = before.corner[i], &q = before.corner[(i + 1) % before.count];
      const double in_p = target.inside(k, p) - slack, in_q = target.inside(k, q) - slack;
      if (in_p > 0.0) shape.add(p);
      if (i >= lines || (in_p > 0.0) == (in_q > 0.0)) continue;
      const double at = in_p / (in_p - in_q);
      shape.add({std::lerp(p.x, q.x, at), std::lerp(p.y, q.y, at), std::lerp(p.height_m, q.height_m, at)});
    }
  }
}

}  // namespace

/// `wholly`: the triangle takes no light; `nowhere`: it covers some of the target, and no outline of it falls there.
InSun SidesInSun::under(const Target& target, std::uint32_t triangle) const {
  if (facets_->facet_of[triangle] == target.facet) return InSun::wholly;
  const double slack = 0x1p-10 * lift_m_;  // edges that are shared are worked out alike but for rounding
  Few<Corner> shape;
  bool below = true;
  for (const std::uint32_t vertex : facets_->triangles[triangle]) {
    Corner p = corner(vertex);
    p.height_m = scene::dot(target.up, facets_->vertices[vertex] - target.on);
    below = below && p.height_m <= lift_m_;
    shape.add(p);
  }
  if (below) return InSun::wholly;
  const Few<Corner> whole = shape;
  clip(target, slack, shape);
  if (shape.count == 0) return InSun::wholly;
  const auto height = [](const Corner& a, const Corner& b) { return a.height_m < b.height_m; };
  const auto [lowest, highest] = std::minmax_element(
      shape.corner.begin(), shape.corner.begin() + static_cast<std::ptrdiff_t>(shape.count), height);
  if (highest->height_m <= 0.0) return InSun::wholly;
  if (lowest->height_m <= lift_m_) return InSun::partly;
  for (std::size_t k = 0; k < 3; ++k) {
    if ((outline_[triangle] >> k & 1U) == 0U) continue;
    Few<Corner> line;
    line.add(whole.corner[k]);
    line.add(whole.corner[(k + 1) % 3]);
    clip(target, slack, line);
    if (line.count > 0) return InSun::partly;
  }
  return InSun::nowhere;
}

InSun SidesInSun::find(const Target& target, std::size_t node, std::size_t first, std::size_t last) const {
  if (!box_[node].meets(target.box)) return InSun::wholly;
  InSun all = InSun::wholly;
  const auto take = [&](InSun one) {
    if (one != InSun::wholly) all = one;
    return one != InSun::partly;
  };
  if (last - first > kLeaf) {
    const std::size_t middle = std::midpoint(first, last);
    if (take(find(target, 2 * node + 1, first, middle))) take(find(target, 2 * node + 2, middle, last));
    return all;
  }
  for (std::size_t i = first; i < last; ++i)
    if (!take(under(target, order_[i]))) break;
  return all;
}

InSun SidesInSun::find(scene::Side side) const {
  const scene::Facet& facet = facets_->facet[side.facet];
  std::optional<InSun> all;
  for (std::uint64_t t = facets_->first[side.facet]; t < facets_->first[side.facet + 1]; ++t) {
    const std::array<std::uint32_t, 3>& number = facets_->triangles[t];
    std::array<Corner, 3> own;
    for (std::size_t k = 0; k < 3; ++k) own[side.back ? 2 - k : k] = corner(number[k]);
    const Vector up = (side.back ? -1.0 : 1.0) * facet.normal;
    const Target target(side.facet, up, facet.centre, own);
    // Thinner than what rays can tell, it says nothing; a face that crosses itself has triangles that are turned over.
    if (std::abs(target.height_m) <= 0x1p-8 * lift_m_) continue;
    if (!(target.height_m > 0.0)) return InSun::partly;
    const InSun one = find(target, 0, 0, order_.size());
    if (one == InSun::partly || (all && *all != one)) return InSun::partly;
    all = one;
  }
  return all.value_or(InSun::partly);
}

void SidesInSun::add(const VisibleSides& sides, int threads) {
  const std::size_t begin_at = known_.size();
  known_.resize(sides.size(), InSun::nowhere);
  mtf::parallel_for(static_cast<std::int64_t>(sides.size() - begin_at), 64, threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      for (std::size_t n = begin_at + static_cast<std::size_t>(begin);
                           n < begin_at + static_cast<std::size_t>(end); ++n)
                        if (sides.sun_cosine(n) > 0.0F) known_[n] = find({sides.side(n) / 2, sides.side(n) % 2 == 1});
                    });
}

}  // namespace radiometry::render
