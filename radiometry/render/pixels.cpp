// SPDX-License-Identifier: Apache-2.0

// The radiance of samples from the values that their sides have at the nodes of the path grid. Parts are taken one by
// one; all samples of a run share a side, nearly always a cell, and its six values.

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/math/clones.h"
#include "mtf/parallel.h"
#include "radiometry/render/band_shader.h"

namespace radiometry::render {
namespace {

/// What the weights of a cell need; how far outside a place still counts as in it.
struct CellPlace {
  float root, per_root, height, per_height;
  float least_t, most_t, least_u, most_u;

  float t(float at) const { return (at - root) * per_root; }
  float u(float at) const { return (at - height) * per_height; }
  bool holds(float t_at, float u_at) const {
    return t_at >= least_t && t_at <= most_t && u_at >= least_u && u_at <= most_u;
  }
};

std::vector<CellPlace> places_of(const PathGrid& grid) {
  constexpr float kSlack = 1e-4F;  // of a cell, at the ends of which neighbours agree
  constexpr float kFar = std::numeric_limits<float>::infinity();
  std::vector<CellPlace> places;
  for (std::size_t layer = 0; layer < grid.layers(); ++layer)
    for (std::size_t cell = 0; cell < grid.cells(); ++cell)
      places.push_back({.root = static_cast<float>(grid.root[2 * cell]),
                        .per_root = static_cast<float>(1.0 / (grid.root[2 * cell + 2] - grid.root[2 * cell])),
                        .height = static_cast<float>(grid.height_m[layer]),
                        .per_height = static_cast<float>(1.0 / (grid.height_m[layer + 1] - grid.height_m[layer])),
                        .least_t = cell == 0 ? -kFar : -kSlack,
                        .most_t = cell + 1 == grid.cells() ? kFar : 1.0F + kSlack,
                        .least_u = layer == 0 ? -kFar : -kSlack,
                        .most_u = layer + 1 == grid.layers() ? kFar : 1.0F + kSlack});
  return places;
}

using SixFloats = std::array<float, 6>;

inline float between(const SixFloats& v, float t, float u) {
  t = t < 0.0F ? 0.0F : t > 1.0F ? 1.0F : t;
  u = u < 0.0F ? 0.0F : u > 1.0F ? 1.0F : u;
  const float a = (1.0F - t) * (1.0F - 2.0F * t), b = 4.0F * t * (1.0F - t), c = t * (2.0F * t - 1.0F);
  const float low = a * v[0] + b * v[1] + c * v[2], high = a * v[3] + b * v[4] + c * v[5];
  return low + u * (high - low);
}

/// A row of samples as a camera looks along it: tangents of angles grow by `step_x` from one to the next.
struct RowOfSight {
  float x, step_x, one_and_y2;  ///< of the first; 1 + the square of the tangent along y
  float above, rise, rise_x;    ///< height of the camera, and how much higher the end of a line is, over its depth
};

/// The radiance of `count` samples of a run from its first; returns whether one of them is outside of the cell.
MTFKIT_CLONES bool shade_run(const RowOfSight& sight, float nearness, float step, const CellPlace& place,
                             const SixFloats& values, int count, float* out) {
  int outside = 0;
  for (int k = 0; k < count; ++k) {
    const auto number = static_cast<float>(k);
    const float x = sight.x + number * sight.step_x;
    const float depth = 1.0F / (nearness + number * step);
    const float root = std::sqrt(depth * std::sqrt(sight.one_and_y2 + x * x));
    const float height = sight.above + depth * (sight.rise + x * sight.rise_x);
    const float t = place.t(root), u = place.u(height);
    outside |= static_cast<int>(t < place.least_t) | static_cast<int>(t > place.most_t) |
               static_cast<int>(u < place.least_u) | static_cast<int>(u > place.most_u);
    out[k] = between(values, t, u);
  }
  return outside != 0;
}

}  // namespace

class BandShader::Pixels {
 public:
  Pixels(const BandShader& shader, const VisibleParts& parts, const VisibleSides& sides, bool angles, bool shadows)
      : shader_(shader), parts_(parts), sides_(sides), shadows_(shadows), places_(places_of(shader.grid_)) {
    const PathGrid& grid = shader.grid_;
    const std::size_t finishes = shader.scene_.finish.size();
    for (std::size_t m = 0; angles && m < finishes; ++m) by_angle_.push_back(has_angles(shader.scene_.finish[m]));
    for (std::size_t m = 0; shader.tables_->sunny() && m < finishes; ++m)
      for (std::uint16_t layer = 0; layer < grid.layers(); ++layer)
        for (std::uint16_t cell = 0; cell < grid.cells(); ++cell) {
          const SixValues wide = shader.tables_->sunlit(m, grid.index({cell, layer}));
          SixFloats& narrow = sun_.emplace_back();
          for (std::size_t k = 0; k < 6; ++k) narrow[k] = static_cast<float>(wide[k]);
        }
  }

  float of(const SamplePart& part) {
    if (part.side == scene::kNone)
      return static_cast<float>(shader_.backdrop_->radiance(static_cast<double>(part.height_m)));
    if (!by_angle_.empty() && by_angle_[shader_.scene_.finish_of[part.side]]) return 0.0F;  // from mirrors
    const std::uint32_t number = sides_.number(part.side);
    const Shaded* at = &shader_.shaded_[number];
    const float root = std::sqrt(part.range_m), height = part.height_m;
    const CellPlace* place = &places_[place_of(at->cell)];
    if (!place->holds(place->t(root), place->u(height))) {
      const PathGrid::Cell cell = shader_.grid_.cell_at(static_cast<double>(root), static_cast<double>(height));
      Elsewhere& known = elsewhere_[number % elsewhere_.size()];
      if (known.number != number || !(known.shaded.cell == cell))
        known = {number, shader_.shaded(sides_, number, cell)};
      at = &known.shaded;
      place = &places_[place_of(cell)];
    }
    const float t = place->t(root), u = place->u(height), sun = sun_on(number, part.lit);
    const float own = between(at->value, t, u);
    return sun > 0.0F ? own + sun * between(sunlit(*at), t, u) : own;
  }

  void fill(const SampleRun& run, float* row) {
    const std::uint32_t number = sides_.number(run.side);
    const Shaded& at = shader_.shaded_[number];
    SixFloats values = at.value;
    if (const float sun = sun_on(number, run.lit); sun > 0.0F)
      for (std::size_t k = 0; k < 6; ++k) values[k] += sun * sunlit(at)[k];
    const Camera& camera = parts_.camera;
    const double y = camera.tangent_y(run.row + 0.5);
    const RowOfSight sight{.x = static_cast<float>(camera.tangent_x(run.column + 0.5)),
                           .step_x = static_cast<float>(camera.step_x),
                           .one_and_y2 = static_cast<float>(1.0 + y * y),
                           .above = static_cast<float>(camera.position[2]),
                           .rise = static_cast<float>(camera.ahead[2] + y * camera.down[2]),
                           .rise_x = static_cast<float>(camera.right[2])};
    if (!shade_run(sight, run.nearness, run.step, places_[place_of(at.cell)], values, static_cast<int>(run.samples),
                   row + run.column))
      return;
    for (std::uint32_t k = 0; k < run.samples; ++k) row[run.column + k] = of(sample_of(run, k, camera, parts_.n));
  }

 private:
  struct Elsewhere {
    std::uint32_t number = scene::kNone;
    Shaded shaded;
  };
  std::size_t place_of(PathGrid::Cell cell) const { return cell.layer * shader_.grid_.cells() + cell.root; }
  const SixFloats& sunlit(const Shaded& at) const { return sun_[at.finish * places_.size() + place_of(at.cell)]; }
  /// The cosine of the sun on a side, times how much of it is lit; 0 where its light is of no account.
  float sun_on(std::uint32_t number, bool lit) const {
    if (sun_.empty()) return 0.0F;
    return (!shadows_ ? sides_.sun_share(number) : lit ? 1.0F : 0.0F) * sides_.sun_cosine(number);
  }

  const BandShader& shader_;
  const VisibleParts& parts_;
  const VisibleSides& sides_;
  bool shadows_;
  std::vector<CellPlace> places_;
  std::vector<bool> by_angle_;              ///< of each finish; empty where none is
  std::vector<SixFloats> sun_;              ///< of each finish and cell
  std::array<Elsewhere, 256> elsewhere_{};  ///< sides that reach into other cells
};

void BandShader::radiance(const VisibleParts& parts, const VisibleSides& sides, const MirrorRays& mirrors, bool shadows,
                          mtf::Image& out, int threads) const {
  const bool angles = mirrors.size() > 0;
  const auto points = static_cast<float>(parts.n * parts.n);
  const Pixels all(*this, parts, sides, angles, shadows);
  const auto bands = static_cast<std::int64_t>(parts.band.size());
  const std::int64_t together = std::max<std::int64_t>(bands / (16 * mtf::threads_of(threads)), 1);
  mtf::parallel_for(bands, together, threads, [&](std::int64_t begin, std::int64_t end) {
    Pixels pixels = all;
    const auto row = [&](std::uint32_t number) { return out.data() + static_cast<std::int64_t>(number) * out.width(); };
    for (auto band = static_cast<std::size_t>(begin); band < static_cast<std::size_t>(end); ++band) {
      for (const SampleRun& run : parts.runs[band]) pixels.fill(run, row(run.row));
      for (const SamplePart& part : parts.band[band]) {
        const float value = static_cast<float>(part.shown) / points * pixels.of(part);
        float& pixel = row(part.row)[part.column];
        pixel = (part.points & 1U) != 0U ? value : pixel + value;
      }
    }
  });
  if (angles) add_angles(mirrors, parts, sides, shadows, out, threads);
}

}  // namespace radiometry::render
