// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mtf/math/simd.h"
#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

namespace simd = mtf::simd;

constexpr int kBlock = 64;  // points that share one evaluation in double precision

/// a x + b y + c.
struct Plane {
  double a = 0.0, b = 0.0, c = 0.0;
};

struct ScreenTriangle {
  std::array<Plane, 3> edge{};  ///< none is negative inside
  Plane nearness{};
  float least = 0.0F, most = 0.0F;  ///< nearness of its corners
  std::int32_t x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  std::uint32_t side = 0;
  std::array<double, 3> crossing{};  ///< -n / a of each edge: over it, the column where an edge crosses a row

  /// Columns of points between the edges, a few more for rounding; `rest`: of the edges in this row, b y + c.
  struct Columns {
    std::int32_t first, last;
  };
  MTFKIT_INLINE Columns columns(const std::array<double, 3>& rest) const {
    double left = static_cast<double>(x0), right = static_cast<double>(x1);
    for (std::size_t k = 0; k < 3; ++k) {
      const double crossed = rest[k] * crossing[k];
      if (edge[k].a > 0.0) left = std::max(left, crossed - 2.0);
      if (edge[k].a < 0.0) right = std::min(right, crossed + 2.0);
    }
    // A nearly level edge crosses its row far outside.
    left = std::min(left, static_cast<double>(x1)), right = std::max(right, static_cast<double>(x0));
    return {static_cast<std::int32_t>(left), static_cast<std::int32_t>(right)};
  }
};

/// Where the points of a band are, in samples.
struct PointPlaces {
  int n;
  double per_n;
  std::array<float, kBlock> in_block{};     ///< from the first sample of a block
  std::array<double, Screen::kRows> row{};  ///< from the first row of the image

  PointPlaces(int points, std::int64_t first_row) : n(points), per_n(1.0 / points) {
    for (int k = 0; k < kBlock; ++k)
      in_block[static_cast<std::size_t>(k)] = static_cast<float>(k / n + point_in_sample(n, k % n));
    for (std::int64_t k = 0; k < Screen::kRows; ++k)
      row[static_cast<std::size_t>(k)] =
          static_cast<double>((first_row + k) / n) + point_in_sample(n, static_cast<int>((first_row + k) % n));
  }
};

/// Draws triangles, one after the other, into the rows from `first_row`.
struct Draw {
  template <int Bytes>
  static MTFKIT_INLINE void run(const ScreenTriangle* triangle, const ScreenTriangle* end, std::int64_t first_row,
                                const PointPlaces* places, ScreenRows* rows) {
    using Floats = simd::Vector<float, Bytes>;
    using Ints = simd::Vector<std::int32_t, Bytes>;
    constexpr int kLanes = Bytes / static_cast<int>(sizeof(float));
    for (; triangle != end; ++triangle) {
      const ScreenTriangle& t = *triangle;
      const Floats a0 = Floats{} + static_cast<float>(t.edge[0].a), a1 = Floats{} + static_cast<float>(t.edge[1].a),
                   a2 = Floats{} + static_cast<float>(t.edge[2].a), aw = Floats{} + static_cast<float>(t.nearness.a);
      const Floats least = Floats{} + t.least, most = Floats{} + t.most;
      const Ints side = Ints{} + static_cast<std::int32_t>(t.side);
      for (std::int64_t y = t.y0 - first_row; y < t.y1 - first_row; ++y) {
        const double v = places->row[static_cast<std::size_t>(y)];
        const double r0 = t.edge[0].b * v + t.edge[0].c, r1 = t.edge[1].b * v + t.edge[1].c,
                     r2 = t.edge[2].b * v + t.edge[2].c, rw = t.nearness.b * v + t.nearness.c;
        const std::int64_t row = y * rows->stride;
        const auto [left, right] = t.columns({r0, r1, r2});
        for (std::int32_t x = left & -kBlock; x < right; x += kBlock) {
          const double u = places->per_n * static_cast<double>(x);
          const Floats e0 = Floats{} + static_cast<float>(r0 + t.edge[0].a * u),
                       e1 = Floats{} + static_cast<float>(r1 + t.edge[1].a * u),
                       e2 = Floats{} + static_cast<float>(r2 + t.edge[2].a * u),
                       ew = Floats{} + static_cast<float>(rw + t.nearness.a * u);
          const std::int32_t to = std::min(right - x, kBlock);
          for (std::int32_t k = std::max(left - x, 0) & -kLanes; k < to; k += kLanes) {
            const Floats at = simd::load<Floats>(places->in_block.data() + k);
            const Ints signs = __builtin_bit_cast(Ints, a0 * at + e0) | __builtin_bit_cast(Ints, a1 * at + e1) |
                               __builtin_bit_cast(Ints, a2 * at + e2);
            Floats near = aw * at + ew;
            near = near > least ? near : least;
            near = near < most ? near : most;
            float* const nearness = rows->nearness.data() + row + x + k;
            std::uint32_t* const shown = rows->side.data() + row + x + k;
            const Floats before = simd::load<Floats>(nearness);
            const Ints other = simd::load<Ints>(shown);
            // Nearer, or as near and of a lower number. Numbers that are not negative have the order of their bits. GCC
            // 12 compiles combined comparisons of 64-byte vectors lane by lane, so integers are subtracted instead.
            const Ints further = __builtin_bit_cast(Ints, before) - __builtin_bit_cast(Ints, near);
            const Ints drawn = ~(signs >> 31) & ((further + ((side - other) >> 31)) >> 31);
            simd::store(drawn ? near : before, nearness);
            simd::store(drawn ? side : other, shown);
          }
        }
      }
    }
  }
};

}  // namespace

void Screen::place(const RenderScene& scene, const Camera& camera, int n, std::span<const std::uint32_t> likely,
                   int threads) {
  scene_ = &scene;
  likely_ = likely;
  n_ = n;
  width_ = camera.width * n, height_ = camera.height * n;
  place_corners(camera, threads);
  constexpr std::size_t kChunk = 1 << 14;
  const std::size_t triangles = scene.facets().triangles.size(), chunks = (triangles + kChunk - 1) / kChunk,
                    bands = static_cast<std::size_t>(this->bands());
  const auto each_band = [&](const Seen& seen, const auto& work) {
    for (std::int64_t band = seen.y0 / kRows; band <= (seen.y1 - 1) / kRows; ++band)
      work(static_cast<std::size_t>(band));
  };
  const auto each_chunk = [&](const auto& work) {
    mtf::parallel_for_each(static_cast<std::int64_t>(chunks), 1, threads, [&](std::size_t chunk) { work(chunk); });
  };
  seen_.resize(triangles);
  std::vector<std::size_t> count(chunks);
  // How many of a chunk are in a band; then where its next one goes.
  std::vector<std::size_t> of_chunk(chunks * bands, 0);
  each_chunk([&](std::size_t chunk) {
    const std::size_t from = chunk * kChunk, to = std::min(from + kChunk, triangles);
    count[chunk] = find_seen(static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to), seen_.data() + from);
    for (std::size_t i = from; i < from + count[chunk]; ++i)
      each_band(seen_[i], [&](std::size_t band) { ++of_chunk[chunk * bands + band]; });
  });
  std::size_t total = 0;
  first_.clear();
  for (std::size_t band = 0; band < bands; ++band) {
    first_.push_back(total);
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      std::size_t& next = of_chunk[chunk * bands + band];
      total += std::exchange(next, total);
    }
  }
  first_.push_back(total);
  of_band_.resize(total);
  each_chunk([&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < chunk * kChunk + count[chunk]; ++i)
      each_band(seen_[i],
                [&](std::size_t band) { of_band_[of_chunk[chunk * bands + band]++] = static_cast<std::uint32_t>(i); });
  });
}

void Screen::place_corners(const Camera& camera, int threads) {
  using scene::operator-;
  const std::vector<Point>& vertices = scene_->facets().vertices;
  corner_.resize(vertices.size());
  const double per_x = 1.0 / camera.step_x, per_y = 1.0 / camera.step_y;
  mtf::parallel_for_each(static_cast<std::int64_t>(vertices.size()), 1 << 14, threads, [&](std::size_t i) {
    const Vector v = vertices[i] - camera.position;
    const double w = scene::dot(v, camera.ahead);
    corner_[i] = {per_x * scene::dot(v, camera.right) + camera.axis_x * w,
                  per_y * scene::dot(v, camera.down) + camera.axis_y * w, w};
  });
}

std::size_t Screen::find_seen(std::uint32_t begin, std::uint32_t end, Seen* out) const {
  constexpr double kNear = 1e-12;  // of the deepest corner: where an edge is cut that comes from behind the camera
  constexpr double kSlack = 0.15;  // points are at most 0.125 n-ths of a sample from where they were if evenly spread
  const scene::Facets& facets = scene_->facets();
  std::size_t count = 0;
  for (std::uint32_t t = begin; t < end; ++t) {
    const std::array<Corner, 3> c{corner_[facets.triangles[t][0]], corner_[facets.triangles[t][1]],
                                  corner_[facets.triangles[t][2]]};
    const double deepest = std::max({c[0].w, c[1].w, c[2].w});
    if (!(deepest > 0.0)) continue;
    const double volume = c[0].x * (c[1].y * c[2].w - c[1].w * c[2].y) + c[0].y * (c[1].w * c[2].x - c[1].x * c[2].w) +
                          c[0].w * (c[1].x * c[2].y - c[1].y * c[2].x);
    // Rows run downwards: the front is seen where corners run clockwise.
    const std::uint32_t side = 2 * facets.facet_of[t] + (volume > 0.0 ? 1U : 0U);
    if (volume == 0.0 || std::isnan(scene_->temperature_k[side])) continue;
    const double least = kNear * deepest;
    double left = std::numeric_limits<double>::infinity(), top = left, right = -left, bottom = -left;
    const double nearest = std::min({c[0].w, c[1].w, c[2].w});
    const auto take = [&](double x, double y, double w) {
      const double depth = 1.0 / w;
      left = std::min(left, x * depth), right = std::max(right, x * depth);
      top = std::min(top, y * depth), bottom = std::max(bottom, y * depth);
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner &p = c[k], &q = c[(k + 1) % 3];
      if (p.w >= least) take(p.x, p.y, p.w);
      if ((p.w >= least) == (q.w >= least)) continue;
      const double cut = (least - p.w) / (q.w - p.w);
      take(std::lerp(p.x, q.x, cut), std::lerp(p.y, q.y, cut), least);
    }
    // Between 0 and the last one, where conversion is std::floor.
    const auto last = [&](double to, std::int64_t most) {
      return static_cast<std::int32_t>(std::clamp(n_ * to + 0.5 + kSlack, 0.0, static_cast<double>(most)));
    };
    const auto first = [&](double from, std::int64_t most) {
      const double at = std::clamp(n_ * from - 0.5 - kSlack, 0.0, static_cast<double>(most));
      const auto below = static_cast<std::int32_t>(at);
      return static_cast<double>(below) < at ? below + 1 : below;
    };
    const Seen one{.triangle = t,
                   .side = side,
                   .most = nearest > 0.0 ? static_cast<float>(1.0 / nearest) : std::numeric_limits<float>::infinity(),
                   .x0 = first(left, width_),
                   .x1 = last(right, width_),
                   .y0 = first(top, height_),
                   .y1 = last(bottom, height_)};
    if (one.x0 >= one.x1 || one.y0 >= one.y1) continue;
    out[count++] = one;
  }
  return count;
}

/// Whether everything in its part of a band is nearer than the triangle anywhere.
bool Screen::hidden(const Seen& seen, const std::vector<float>& least) const {
  for (std::int32_t tile = seen.x0 / kTile; tile <= (seen.x1 - 1) / kTile; ++tile)
    if (!(least[static_cast<std::size_t>(tile)] > seen.most)) return false;
  return true;
}

/// The least nearness in each tile of a band.
void Screen::find_least(const ScreenRows& rows, std::int64_t count, std::vector<float>& least) const {
  least.assign(static_cast<std::size_t>((width_ + kTile - 1) / kTile), std::numeric_limits<float>::infinity());
  for (std::int64_t row = 0; row < count; ++row) {
    const float* const nearness = rows.nearness.data() + row * rows.stride;
    for (std::int64_t x = 0; x < width_; x += kTile) {
      float& so_far = least[static_cast<std::size_t>(x / kTile)];
      for (std::int64_t k = x; k < std::min<std::int64_t>(x + kTile, width_); ++k)
        so_far = std::min(so_far, nearness[k]);
    }
  }
}

void Screen::draw(std::int64_t band, ScreenRows& out) const {
  out.stride = (width_ + kBlock - 1) / kBlock * kBlock;
  const auto points = static_cast<std::size_t>(out.stride * kRows);
  out.nearness.assign(points, 0.0F);
  out.side.assign(points, scene::kNone);
  const scene::Facets& facets = scene_->facets();
  const PointPlaces places(n_, band * kRows);
  std::array<ScreenTriangle, 64> some;  // a few at a time stay in the cache
  std::size_t count = 0;
  const auto draw_some = [&] {
    simd::run<Draw>(static_cast<const ScreenTriangle*>(some.data()),
                    static_cast<const ScreenTriangle*>(some.data() + count), band * kRows, &places, &out);
    count = 0;
  };
  const auto add = [&](const Seen& seen) {
    const std::array<std::uint32_t, 3>& number = facets.triangles[seen.triangle];
    ScreenTriangle t{.x0 = seen.x0,
                     .x1 = seen.x1,
                     .y0 = std::max(seen.y0, static_cast<std::int32_t>(band * kRows)),
                     .y1 = std::min(seen.y1, static_cast<std::int32_t>((band + 1) * kRows)),
                     .side = seen.side};
    for (std::size_t k = 0; k < 3; ++k) {
      // From the lower number to the higher, whichever triangle asks.
      std::uint32_t from = number[(k + 1) % 3], to = number[(k + 2) % 3];
      double sign = (seen.side % 2 == 0) ? -1.0 : 1.0;
      if (from > to) std::swap(from, to), sign = -sign;
      const Corner &p = corner_[from], &q = corner_[to];
      t.edge[k] = {sign * (p.y * q.w - p.w * q.y), sign * (p.w * q.x - p.x * q.w), sign * (p.x * q.y - p.y * q.x)};
    }
    const Corner& c = corner_[number[0]];
    const double volume = t.edge[0].a * c.x + t.edge[0].b * c.y + t.edge[0].c * c.w;
    if (!(volume > 0.0)) return;  // edge on, to rounding
    const double scale = 1.0 / volume;
    for (std::size_t k = 0; k < 3; ++k) {
      const Plane& edge = t.edge[k];
      t.nearness = {t.nearness.a + scale * edge.a, t.nearness.b + scale * edge.b, t.nearness.c + scale * edge.c};
      t.crossing[k] = -n_ / edge.a;
    }
    const std::array<double, 3> depth{corner_[number[0]].w, corner_[number[1]].w, corner_[number[2]].w};
    t.least = static_cast<float>(1.0 / *std::max_element(depth.begin(), depth.end()));
    t.most = seen.most;
    some[count++] = t;
    if (count == some.size()) draw_some();
  };
  const auto b = static_cast<std::size_t>(band);
  const std::span<const std::uint32_t> here = std::span(of_band_).subspan(first_[b], first_[b + 1] - first_[b]);
  const auto first = [&](const Seen& seen) { return !likely_.empty() && likely_[seen.side] != scene::kNone; };
  for (const std::uint32_t i : here)
    if (first(seen_[i])) add(seen_[i]);
  draw_some();
  std::vector<float> least;
  find_least(out, std::min(kRows, height_ - band * kRows), least);
  for (const std::uint32_t i : here)
    if (!first(seen_[i]) && !hidden(seen_[i], least)) add(seen_[i]);
  draw_some();
}

}  // namespace radiometry::render
