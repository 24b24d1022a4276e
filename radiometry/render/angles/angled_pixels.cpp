// SPDX-License-Identifier: Apache-2.0

// Pixels of surfaces whose radiance depends on the angle: angular_finishes.h has the sum.

#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/render/band_shader.h"

namespace radiometry::render {

InMirror BandShader::in_mirror(const MirrorRays& mirrors, std::size_t k, const VisibleSides& sides) const {
  InMirror out{.rise = static_cast<double>(mirrors.rise[k])};
  const std::uint32_t side = mirrors.side[k];
  if (side == scene::kNone) return out;
  const std::uint32_t number = sides.number(side);
  out.finish = scene_.finish_of[side], out.patch = patches_->patch_of[side];
  out.temperature_k = static_cast<double>(scene_.temperature_k[side]);
  out.sun = static_cast<double>(sides.sun_share(number)) * static_cast<double>(sides.sun_cosine(number));
  return out;
}

void BandShader::add_angles(const MirrorRays& mirrors, const VisibleParts& parts, const VisibleSides& sides,
                            bool shadows, mtf::Image& out, int threads) const {
  std::vector<float> values(mirrors.size());
  mtf::parallel_for(
      static_cast<std::int64_t>(mirrors.size()), 1 << 10, threads, [&](std::int64_t begin, std::int64_t end) {
        // Neighbours on one side in one cell differ in angles and sun alone.
        std::uint32_t known = scene::kNone;
        PathGrid::Cell known_cell;
        SurfaceLight light;
        for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
          const SamplePart& part = parts.band[mirrors.of[k].band][mirrors.of[k].part];
          const std::uint32_t side = part.side, finish = scene_.finish_of[side];
          const std::size_t number = sides.number(side);
          const double root = std::sqrt(static_cast<double>(part.range_m)), height = static_cast<double>(part.height_m);
          const PathGrid::Cell cell = grid_.cell_at(root, height);
          const std::size_t node = grid_.index(cell);
          if (known != side || !(known_cell == cell)) {
            known = side, known_cell = cell;
            light = surfaces_.light(*tables_, node, finish, static_cast<double>(scene_.temperature_k[side]),
                                    sides.light(number));
          }
          const double lit = !shadows ? static_cast<double>(sides.sun_share(number)) : part.lit ? 1.0 : 0.0;
          const SeenAt at{.relative = static_cast<double>(mirrors.relative[k]),
                          .gloss = scene_.finish[finish].gloss,
                          .sun = lit * static_cast<double>(sides.sun_cosine(number)),
                          .mirror = in_mirror(mirrors, k, sides)};
          const SixValues sum = surfaces_.seen(*tables_, node, finish, light, at);
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
