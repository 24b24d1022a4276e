// SPDX-License-Identifier: Apache-2.0

// Pixels of surfaces whose radiance depends on the angle: angular_finishes.h has the sum.

#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/render/band_shader.h"

namespace radiometry::render {
namespace {

void add(double share, const SixValues& values, SixValues& sum) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += share * values[k];
}

}  // namespace

/// The light of a mirror of that reflectance: a finish of `reflected`, and the one made for it with the finish that it
/// shows.
SixValues BandShader::mirrored(std::size_t reflected, bool white, std::size_t finish, const MirrorRays& mirrors,
                               const VisibleSides& sides, std::size_t k, std::size_t node) const {
  SixValues sum{};
  const std::uint32_t side = mirrors.side[k];
  if (side == scene::kNone) {
    const double elevation = std::asin(std::clamp(static_cast<double>(mirrors.rise[k]), -1.0, 1.0));
    if (elevation < 0.0) {
      tables_->add_reflected(reflected, sources_.ground(), 1.0, node, sum);
      return sum;
    }
    const ElevationPlace place = elevation_place(elevation);
    for (std::size_t i = 0; i < 4; ++i)
      tables_->add_reflected(reflected, sources_.first_elevation + place.first + i, place.weight[i], node, sum);
    return sum;
  }
  const std::uint32_t seen = scene_.finish_of[side], patch = patches_->patch_of[side];
  const std::size_t made = white ? angular_.mirrored_in_white(seen) : angular_.mirrored(finish, seen);
  tables_->add_reflected(reflected, sources_.patch(patch), 1.0, node, sum);
  add(1.0, tables_->emitted(made, static_cast<double>(scene_.temperature_k[side]), node), sum);
  add(-1.0, tables_->emitted(made, patch_k_[patch], node), sum);
  if (!tables_->sunny()) return sum;
  const std::size_t number = sides.number(side);
  add(static_cast<double>(sides.sun_share(number)) * static_cast<double>(sides.sun_cosine(number)),
      tables_->sunlit(made, node), sum);
  return sum;
}

void BandShader::add_angles(const MirrorRays& mirrors, const VisibleParts& parts, const VisibleSides& sides,
                            bool shadows, mtf::Image& out, int threads) const {
  std::vector<float> values(mirrors.size());
  const std::size_t white = angular_.white();
  mtf::parallel_for(
      static_cast<std::int64_t>(mirrors.size()), 1 << 10, threads, [&](std::int64_t begin, std::int64_t end) {
        // Neighbours on one side in one cell differ in angles and sun alone.
        std::uint32_t known = scene::kNone;
        PathGrid::Cell known_cell;
        SixValues emitted{}, diffuse{}, white_diffuse{};
        for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
          const SamplePart& part = parts.band[mirrors.of[k].band][mirrors.of[k].part];
          const std::uint32_t side = part.side, finish = scene_.finish_of[side];
          const std::size_t number = sides.number(side);
          const double root = std::sqrt(static_cast<double>(part.range_m)), height = static_cast<double>(part.height_m);
          const PathGrid::Cell cell = grid_.cell_at(root, height);
          const std::size_t node = grid_.index(cell);
          if (known != side || !(known_cell == cell)) {
            known = side, known_cell = cell;
            emitted = tables_->emitted(finish, static_cast<double>(scene_.temperature_k[side]), node);
            diffuse = white_diffuse = {};
            const auto [source, share] = sides.light(number);
            for (std::size_t n = 0; n < source.size(); ++n) {
              if (tables_->reflects(finish))
                tables_->add_reflected(finish, source[n], static_cast<double>(share[n]), node, diffuse);
              tables_->add_reflected(white, source[n], static_cast<double>(share[n]), node, white_diffuse);
            }
          }
          const auto g = static_cast<double>(mirrors.relative[k]);
          const double gloss = scene_.finish[finish].gloss;
          SixValues sum = tables_->path(node);
          add(g, emitted, sum);
          add(g * (1.0 - gloss), diffuse, sum);
          add((1.0 - g) * (1.0 - gloss), white_diffuse, sum);
          if (tables_->sunny()) {
            const double lit = !shadows ? static_cast<double>(sides.sun_share(number)) : part.lit ? 1.0 : 0.0;
            const double sun = (1.0 - gloss) * lit * static_cast<double>(sides.sun_cosine(number));
            if (sun > 0.0) {
              add(g * sun, tables_->sunlit(finish, node), sum);
              add((1.0 - g) * sun, tables_->sunlit(white, node), sum);
            }
          }
          if (gloss > 0.0) {
            if (tables_->reflects(finish))
              add(g * gloss, mirrored(finish, false, finish, mirrors, sides, k, node), sum);
            if (g != 1.0) add((1.0 - g) * gloss, mirrored(white, true, finish, mirrors, sides, k, node), sum);
          }
          values[k] = static_cast<float>(grid_.between(cell, root, height, sum));
        }
      });
  const auto points = static_cast<float>(parts.n * parts.n);
  for (std::size_t k = 0; k < mirrors.size(); ++k) {
    const SamplePart& part = parts.band[mirrors.of[k].band][mirrors.of[k].part];
    out.at(part.column, part.row) += static_cast<float>(part.shown) / points * values[k];
  }
}

}  // namespace radiometry::render
