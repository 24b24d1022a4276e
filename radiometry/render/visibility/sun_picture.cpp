// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/sun_picture.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <span>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

using scene::operator-;

}  // namespace

SunPicture::Box SunPicture::Box::none() {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  return {{kFar, kFar}, {-kFar, -kFar}};
}

void SunPicture::Box::take(const Place& p) { take(Box{p, p}); }

void SunPicture::Box::take(const Box& other) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    low[axis] = std::min(low[axis], other.low[axis]);
    high[axis] = std::max(high[axis], other.high[axis]);
  }
}

SunPicture::SunPicture(const scene::Facets& facets, const Vector& to_sun, int threads)
    : facets_(&facets), to_sun_(to_sun), place_(facets.vertices.size()) {
  // Any two axes will do: what faces the sun runs counter-clockwise.
  const auto steep = [](double a, double b) { return std::abs(a) < std::abs(b); };
  Vector level{};
  level[static_cast<std::size_t>(std::min_element(to_sun.begin(), to_sun.end(), steep) - to_sun.begin())] = 1.0;
  axes_[0] = scene::unit(scene::cross(level, to_sun));
  axes_[1] = scene::unit(scene::cross(to_sun, axes_[0]));
  for (std::size_t i = 0; i < place_.size(); ++i) {
    const Vector from_middle = facets.vertices[i] - facets.middle;
    place_[i] = {scene::dot(axes_[0], from_middle), scene::dot(axes_[1], from_middle)};
  }
  find_outlines();
  build_tree(threads);
}

/// Edges are gathered by their lower vertex.
void SunPicture::find_outlines() {
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
  outline_.assign(triangles, 0);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::array<std::uint32_t, 3>& number = facets_->triangles[t];
    const auto &a = place_[number[0]], &b = place_[number[1]], &c = place_[number[2]];
    const bool faces = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    if (faces) outline_[t] = kFaces;
    for (std::uint8_t k = 0; k < 3; ++k) {
      const auto [low, high] = ends(t, k);
      use[next[low]++] = {high, t, k, faces == (number[k] == low)};
    }
  }
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
void SunPicture::build_tree(int threads) {
  const std::size_t triangles = facets_->triangles.size();
  std::vector<std::array<double, 2>> middle(triangles);
  for (std::size_t t = 0; t < triangles; ++t)
    for (const std::uint32_t vertex : facets_->triangles[t])
      for (std::size_t axis = 0; axis < 2; ++axis) middle[t][axis] += place_[vertex][axis];
  std::size_t leaves = 1;
  while (triangles > leaves * kLeaf) leaves *= 2;  // as halving goes on while a node has more than kLeaf
  box_.assign(2 * leaves - 1, Box::none());
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
        for (const std::uint32_t vertex : facets_->triangles[order_[i]]) box_[node].take(place_[vertex]);
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

}  // namespace radiometry::render
