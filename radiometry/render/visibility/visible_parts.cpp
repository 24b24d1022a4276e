// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/visible_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

using scene::kNone;

/// The mean place of some of the n x n points of a sample, from its corner, in samples.
PlaceInImage middle_of(std::uint16_t points, int n) {
  double x = 0.0, y = 0.0;
  for (std::uint32_t left = points; left != 0; left &= left - 1) {
    const int point = std::countr_zero(left);
    x += point_in_sample(n, point % n);
    y += point_in_sample(n, point / n);
  }
  const double scale = 1.0 / std::popcount(points);
  return {x * scale, y * scale};
}

/// What parts on facets add up to.
struct Sum {
  float near = std::numeric_limits<float>::infinity(), far = 0.0F, low = near, high = -near;
  std::size_t on_facets = 0, divided = 0;

  void add(float range, float height) {
    near = std::min(near, range), far = std::max(far, range);
    low = std::min(low, height), high = std::max(high, height);
    ++on_facets;
  }
  void add(const Sum& other) {
    near = std::min(near, other.near), far = std::max(far, other.far);
    low = std::min(low, other.low), high = std::max(high, other.high);
    on_facets += other.on_facets;
    divided += other.divided;
  }
};

/// Turns the points of rows of samples into parts.
template <int N>
class RowOfSamples {
 public:
  explicit RowOfSamples(const Camera& camera) : camera_(camera), whole_(static_cast<std::size_t>(camera.width)) {
    for (std::uint32_t points = 1; points < kPlaces; ++points)
      place_[points] = middle_of(static_cast<std::uint16_t>(points), N);
  }

  void add(std::int64_t row, const ScreenRows& rows, std::int64_t first_point, std::vector<SamplePart>& parts) {
    const auto y = static_cast<std::uint32_t>(row);
    for (std::size_t column = 0; column < whole_.size(); ++column)
      whole_[column] = line_of_sight(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
    for (std::uint32_t column = 0; column < whole_.size(); ++column) {
      std::array<std::uint32_t, N * N> side;
      std::array<float, N * N> near;
      bool one = true;
      for (std::size_t k = 0; k < N * N; ++k) {
        const std::size_t at =
            static_cast<std::size_t>(first_point) + k / N * static_cast<std::size_t>(rows.stride) + column * N + k % N;
        side[k] = rows.side[at];
        near[k] = rows.nearness[at];
        one = one && side[k] == side[0];
      }
      if (one) {
        float sum = 0.0F;
        for (const float each : near) sum += each;
        fill(parts.emplace_back(), column, y, side[0], kAll, N * N, sum, whole_[column]);
        continue;
      }
      ++sum_.divided;
      for (std::uint32_t left = kAll; left != 0;) {
        const std::uint32_t first = side[static_cast<std::size_t>(std::countr_zero(left))];
        std::uint32_t points = 0;
        int shown = 0;
        float sum = 0.0F;
        for (std::uint32_t k = 0; k < N * N; ++k)
          if (side[k] == first) points |= 1U << k, ++shown, sum += near[k];
        left &= ~points;
        const PlaceInImage in = N <= 2 ? place_[points % kPlaces] : middle_of(static_cast<std::uint16_t>(points), N);
        fill(parts.emplace_back(), column, y, first, points, shown, sum, line_of_sight(column + in.x, y + in.y));
      }
    }
  }

  const Sum& sum() const { return sum_; }

 private:
  static constexpr std::uint32_t kAll = (1U << (N * N)) - 1U;
  static constexpr std::uint32_t kPlaces = N <= 2 ? kAll + 1 : 1;  // of n = 4 they are worked out as they come

  /// Over the depth: the range, and how much higher the end is than the camera.
  struct LineOfSight {
    float length, rise;
  };
  LineOfSight line_of_sight(double x, double y) const {
    const auto u = static_cast<float>((x - camera_.axis_x) * camera_.step_x),
               v = static_cast<float>((y - camera_.axis_y) * camera_.step_y);
    return {std::sqrt(1.0F + u * u + v * v), static_cast<float>(camera_.ahead[2]) +
                                                 u * static_cast<float>(camera_.right[2]) +
                                                 v * static_cast<float>(camera_.down[2])};
  }

  void fill(SamplePart& out, std::uint32_t column, std::uint32_t row, std::uint32_t side, std::uint32_t points,
            int shown, float nearness_sum, const LineOfSight& line) {
    out.column = column;
    out.row = row;
    out.side = side;
    out.points = static_cast<std::uint16_t>(points);
    out.shown = static_cast<std::uint8_t>(shown);
    if (side == kNone) {
      out.height_m = line.rise / line.length;
    } else {
      const float depth = static_cast<float>(shown) / nearness_sum;
      out.range_m = depth * line.length;
      out.height_m = static_cast<float>(camera_.position[2]) + depth * line.rise;
      sum_.add(out.range_m, out.height_m);
    }
  }

  const Camera& camera_;
  std::vector<LineOfSight> whole_;  ///< of the middles of the samples of a row
  std::array<PlaceInImage, kPlaces> place_{};
  Sum sum_{};
};

template <int N>
void parts_of(const Screen& screen, const Camera& camera, VisibleParts& parts, int threads) {
  constexpr std::int64_t kSampleRows = Screen::kRows / N;
  Sum all;
  std::mutex lock;
  parts.band.resize(static_cast<std::size_t>(screen.bands()));
  const std::int64_t together = std::max<std::int64_t>(screen.bands() / (16 * mtf::threads_of(threads)), 1);
  mtf::parallel_for(screen.bands(), together, threads, [&](std::int64_t begin, std::int64_t end) {
    ScreenRows rows;
    RowOfSamples<N> samples(camera);
    for (std::int64_t b = begin; b < end; ++b) {
      screen.draw(b, rows);
      std::vector<SamplePart>& band = parts.band[static_cast<std::size_t>(b)];
      band.clear();
      for (std::int64_t row = b * kSampleRows; row < std::min((b + 1) * kSampleRows, camera.height); ++row) {
        samples.add(row, rows, (row - b * kSampleRows) * N * rows.stride, band);
      }
    }
    const std::scoped_lock guard(lock);
    all.add(samples.sum());
  });
  parts.extent = {all.near, all.far, all.low, all.high};
  parts.on_facets = all.on_facets;
  parts.divided = all.divided;
}

}  // namespace

void find_parts(const RenderScene& scene, const Camera& camera, int n, std::span<const std::uint32_t> likely,
                VisibleParts& parts, int threads) {
  const Screen screen(scene, camera, n, likely, threads);
  parts.n = n;
  if (n == 1) parts_of<1>(screen, camera, parts, threads);
  if (n == 2) parts_of<2>(screen, camera, parts, threads);
  if (n == 4) parts_of<4>(screen, camera, parts, threads);
}

PlaceInImage place_of(const SamplePart& part, int n) {
  const PlaceInImage in = middle_of(part.points, n);
  return {static_cast<double>(part.column) + in.x, static_cast<double>(part.row) + in.y};
}

PlaceInScene place_of(const RenderScene& scene, const Camera& camera, const SamplePart& part, int n) {
  using scene::operator+, scene::operator-, scene::operator*;
  const PlaceInImage place = place_of(part, n);
  const Vector d = camera.direction(place.x, place.y), unit = (1.0 / scene::length(d)) * d;
  const scene::Facet& facet = scene.facets().facet[part.side / 2];
  const double towards = scene::dot(facet.normal, unit);
  const double exact = scene::dot(facet.normal, facet.centre - camera.position) / towards;
  const auto range_m = static_cast<double>(part.range_m);
  // Edge on, the range in single precision is the better one.
  const bool close = std::abs(exact - range_m) <= 1e-4 * range_m;
  return {camera.position + (close ? exact : range_m) * unit, (part.side % 2 == 1 ? -1.0 : 1.0) * facet.normal, unit};
}

}  // namespace radiometry::render
