// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/visible_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>

#include "mtf/parallel.h"
#include "radiometry/render/mirror_rays.h"

namespace radiometry::render {
namespace {

using scene::kNone;

/// The mean place of some of the n x n points of a sample, from its corner, in samples.
constexpr PlaceInImage mean_place(std::uint32_t points, int n) {
  double x = 0.0, y = 0.0;
  for (std::uint32_t left = points; left != 0; left &= left - 1) {
    const int point = std::countr_zero(left);
    x += point_in_sample(n, point % n);
    y += point_in_sample(n, point / n);
  }
  const double scale = 1.0 / std::popcount(points);
  return {x * scale, y * scale};
}

/// The same; of few points it is known.
PlaceInImage middle_of(std::uint32_t points, int n) {
  static constexpr std::array<PlaceInImage, 16> kFour = [] {
    std::array<PlaceInImage, 16> all{};
    for (std::uint32_t k = 1; k < all.size(); ++k) all[k] = mean_place(k, 2);
    return all;
  }();
  return n == 1 ? PlaceInImage{0.5, 0.5} : n == 2 ? kFour[points] : mean_place(points, n);
}

/// Over the depth: the range, and how much higher the end is than the camera.
struct LineOfSight {
  float length, rise;
};
/// Of tangents of angles from the axis.
LineOfSight line_of_sight(const Camera& camera, float x, float y) {
  return {std::sqrt(1.0F + x * x + y * y), static_cast<float>(camera.ahead[2]) +
                                               x * static_cast<float>(camera.right[2]) +
                                               y * static_cast<float>(camera.down[2])};
}

/// What parts on facets add up to.
struct Sum {
  float near = std::numeric_limits<float>::infinity(), far = 0.0F, low = near, high = -near;
  std::size_t on_facets = 0, divided = 0;

  void add(float range, float height) {
    near = std::min(near, range), far = std::max(far, range);
    low = std::min(low, height), high = std::max(high, height);
  }
  void add(const Sum& other) {
    near = std::min(near, other.near), far = std::max(far, other.far);
    low = std::min(low, other.low), high = std::max(high, other.high);
    on_facets += other.on_facets;
    divided += other.divided;
  }
};

/// Turns the points of rows of samples into runs and parts.
template <int N>
class RowOfSamples {
 public:
  /// `may_run`: of each finish; empty: there are no runs.
  RowOfSamples(const RenderScene& scene, const Camera& camera, const std::vector<bool>& may_run)
      : scene_(scene), camera_(camera), may_run_(may_run) {
    for (std::uint32_t column = 0; column < camera.width; ++column)
      tangent_x_.push_back(static_cast<float>(camera.tangent_x(column + 0.5)));
  }

  void add(std::int64_t row, const ScreenRows& rows, std::int64_t first_point, std::vector<SamplePart>& parts,
           std::vector<SampleRun>& runs) {
    rows_ = &rows;
    first_point_ = static_cast<std::size_t>(first_point);
    const auto y = static_cast<std::uint32_t>(row);
    tangent_y_ = static_cast<float>(camera_.tangent_y(y + 0.5));
    const auto width = static_cast<std::uint32_t>(tangent_x_.size());
    for (std::uint32_t column = 0; column < width;) {
      const std::uint32_t side = rows.side[at(column, 0)];
      if (!shows_only(side, column)) {
        divide(column++, y, parts);
        continue;
      }
      const std::uint32_t first = column++;
      const float begin = rows.nearness[at(first, 0)];
      while (column < width && shows_only(side, column) && alike(begin, rows.nearness[at(column, 0)])) ++column;
      if (column - first >= kLeast && side != kNone && !may_run_.empty() && may_run_[scene_.finish_of[side]])
        run(first, column - 1, y, side, runs);
      else
        for (std::uint32_t i = first; i < column; ++i)
          fill(parts.emplace_back(), i, y, side, kAll, N * N, nearness_sum(i), middle(i));
    }
  }

  const Sum& sum() const { return sum_; }

 private:
  static constexpr std::uint32_t kAll = (1U << (N * N)) - 1U;
  static constexpr std::uint32_t kLeast = 4;  // shorter runs do not pay

  /// Of the first point of a row of points of a sample.
  std::size_t at(std::uint32_t column, std::size_t row_of_points) const {
    return first_point_ + row_of_points * static_cast<std::size_t>(rows_->stride) + std::size_t{column} * N;
  }
  bool shows_only(std::uint32_t side, std::uint32_t column) const {
    std::uint32_t other = 0;
    for (std::size_t j = 0; j < N; ++j)
      for (std::size_t i = 0; i < N; ++i) other |= rows_->side[at(column, j) + i] ^ side;
    return other == 0;
  }
  /// Over a longer way a line in single precision would lose what is far.
  static bool alike(float a, float b) {
    constexpr float kMost = 4.0F;
    return b <= kMost * a && a <= kMost * b;
  }
  LineOfSight middle(std::uint32_t column) const { return line_of_sight(camera_, tangent_x_[column], tangent_y_); }
  float nearness_sum(std::uint32_t column) const {
    float sum = 0.0F;
    for (std::size_t j = 0; j < N; ++j)
      for (std::size_t i = 0; i < N; ++i) sum += rows_->nearness[at(column, j) + i];
    return sum;
  }

  void divide(std::uint32_t column, std::uint32_t row, std::vector<SamplePart>& parts) {
    std::array<std::uint32_t, N * N> side;
    std::array<float, N * N> near;
    for (std::size_t k = 0; k < N * N; ++k) {
      side[k] = rows_->side[at(column, k / N) + k % N];
      near[k] = rows_->nearness[at(column, k / N) + k % N];
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
      const PlaceInImage in = middle_of(points, N);
      fill(parts.emplace_back(), column, row, first, points, shown, sum,
           line_of_sight(camera_, tangent_x_[column] + static_cast<float>((in.x - 0.5) * camera_.step_x),
                         tangent_y_ + static_cast<float>((in.y - 0.5) * camera_.step_y)));
    }
  }

  void run(std::uint32_t first, std::uint32_t last, std::uint32_t row, std::uint32_t side,
           std::vector<SampleRun>& runs) {
    constexpr float kPerPoint = 1.0F / (N * N);
    const float begin = kPerPoint * nearness_sum(first), end = kPerPoint * nearness_sum(last);
    runs.push_back({.column = first,
                    .row = row,
                    .samples = last - first + 1,
                    .side = side,
                    .nearness = begin,
                    .step = (end - begin) / static_cast<float>(last - first)});
    const float depth = 1.0F / begin, last_depth = 1.0F / end;
    const auto above = static_cast<float>(camera_.position[2]);
    const LineOfSight from = middle(first), to = middle(last);
    sum_.add(depth * from.length, above + depth * from.rise);
    sum_.add(last_depth * to.length, above + last_depth * to.rise);
    // Heights and depths are the least and the most at the ends, but ranges may be less between them.
    const auto axis =
        static_cast<std::uint32_t>(std::clamp(camera_.axis_x, static_cast<double>(first), static_cast<double>(last)));
    sum_.near = std::min(sum_.near, std::min(depth, last_depth) * middle(axis).length);
    sum_.on_facets += last - first + 1;
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
      ++sum_.on_facets;
    }
  }

  const RenderScene& scene_;
  const Camera& camera_;
  const std::vector<bool>& may_run_;
  std::vector<float> tangent_x_;  ///< of each column
  float tangent_y_ = 0.0F;        ///< of the row
  const ScreenRows* rows_ = nullptr;
  std::size_t first_point_ = 0;
  Sum sum_{};
};

template <int N>
void parts_of(const RenderScene& scene, const Screen& screen, const Camera& camera, const PartsOptions& options,
              VisibleParts& parts) {
  constexpr std::int64_t kSampleRows = Screen::kRows / N;
  std::vector<bool> may_run;
  for (std::size_t finish = 0; options.runs && finish < scene.finish.size(); ++finish)
    may_run.push_back(!has_angles(scene.finish[finish]));
  Sum all;
  std::mutex lock;
  parts.band.resize(static_cast<std::size_t>(screen.bands()));
  parts.runs.resize(parts.band.size());
  const std::int64_t together = std::max<std::int64_t>(screen.bands() / (16 * mtf::threads_of(options.threads)), 1);
  mtf::parallel_for(screen.bands(), together, options.threads, [&](std::int64_t begin, std::int64_t end) {
    ScreenRows rows;
    RowOfSamples<N> samples(scene, camera, may_run);
    for (std::int64_t b = begin; b < end; ++b) {
      screen.draw(b, rows);
      std::vector<SamplePart>& band = parts.band[static_cast<std::size_t>(b)];
      std::vector<SampleRun>& runs = parts.runs[static_cast<std::size_t>(b)];
      band.clear();
      runs.clear();
      for (std::int64_t row = b * kSampleRows; row < std::min((b + 1) * kSampleRows, camera.height); ++row)
        samples.add(row, rows, (row - b * kSampleRows) * N * rows.stride, band, runs);
    }
    const std::scoped_lock guard(lock);
    all.add(samples.sum());
  });
  parts.extent = {all.near, all.far, all.low, all.high};
  parts.on_facets = all.on_facets;
  parts.divided = all.divided;
}

}  // namespace

SamplePart sample_of(const SampleRun& run, std::uint32_t number, const Camera& camera, int n) {
  const std::uint32_t column = run.column + number;
  const LineOfSight line = line_of_sight(camera, static_cast<float>(camera.tangent_x(column + 0.5)),
                                         static_cast<float>(camera.tangent_y(run.row + 0.5)));
  const float depth = 1.0F / (run.nearness + static_cast<float>(number) * run.step);
  return {.column = column,
          .row = run.row,
          .side = run.side,
          .range_m = depth * line.length,
          .height_m = static_cast<float>(camera.position[2]) + depth * line.rise,
          .points = static_cast<std::uint16_t>((1U << (n * n)) - 1U),
          .shown = static_cast<std::uint8_t>(n * n),
          .lit = run.lit};
}

void find_parts(const RenderScene& scene, const Camera& camera, const PartsOptions& options, Screen& screen,
                VisibleParts& parts) {
  screen.place(scene, camera, options.n, options.likely, options.threads);
  parts.camera = camera;
  parts.n = options.n;
  if (options.n == 1) parts_of<1>(scene, screen, camera, options, parts);
  if (options.n == 2) parts_of<2>(scene, screen, camera, options, parts);
  if (options.n == 4) parts_of<4>(scene, screen, camera, options, parts);
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
