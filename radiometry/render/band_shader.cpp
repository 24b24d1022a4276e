// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/band_shader.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

/// Of each finish, over all sides and the ground.
std::vector<KelvinRange> ranges_of(const RenderScene& scene) {
  std::vector<KelvinRange> range(scene.finish.size(), {1e9, 0.0});
  const auto take = [&](std::uint32_t finish, double kelvin) {
    range[finish] = {std::min(range[finish].lo_k, kelvin), std::max(range[finish].hi_k, kelvin)};
  };
  for (std::size_t s = 0; s < scene.finish_of.size(); ++s)
    if (!std::isnan(scene.temperature_k[s])) take(scene.finish_of[s], static_cast<double>(scene.temperature_k[s]));
  take(scene.ground.finish, scene.ground.temperature_k);
  for (KelvinRange& one : range)
    if (one.lo_k > one.hi_k) one = {300.0, 300.0};
  return range;
}

/// Wider than it has to be, so that a camera that moves a little keeps it.
PathExtent with_room(const PathExtent& extent) {
  constexpr double kFarther = 1.25, kNearer = 0.8, kHigher = 0.1;
  const double room = kHigher * (extent.highest_m - extent.lowest_m);
  return {kNearer * extent.nearest_m, kFarther * extent.farthest_m, extent.lowest_m - room, extent.highest_m + room};
}

}  // namespace

BandShader::BandShader(RenderBand band, const RenderScene& scene, const Patches& patches, const scene::Views& views,
                       double tolerance, bool with_air)
    : band_(std::move(band)),
      scene_(scene),
      tolerance_(tolerance),
      with_air_(with_air && scene.air.has_value()),
      patches_(&patches) {
  for (const Finish& finish : scene.finish) curves_.push_back(finish.emissivity);
  nodes_ = band_nodes(band_.curves, curves_);
  for (const Spectrum& curve : curves_) emissivity_.push_back(at_nodes(nodes_, curve));
  const std::vector<std::vector<double>> all_sides = hemispherical_emissivity(scene, emissivity_);
  angular_ = angular_finishes(scene, emissivity_, all_sides);
  std::vector<std::vector<double>> emits = emissivity_;
  std::vector<KelvinRange> ranges = ranges_of(scene);
  for (std::size_t m = 0; m < angular_.made.size(); ++m) {
    emits.push_back(angular_.made[m].emits);
    ranges.push_back(angular_.like[m] == scene::kNone ? KelvinRange{300.0, 300.0} : ranges[angular_.like[m]]);
  }
  folds_ = std::make_unique<EmissionFolds>(nodes_, emits, ranges);
  std::optional<AirView> sky;
  if (scene.air && scene.air->profile.levels.size() > 1)
    sky.emplace(*scene.air, nodes_, scene.altitude_m, ground_height_m(scene.facets()));
  patch_k_ = patch_temperatures_k(scene, patches);
  sources_ = light_sources(scene, nodes_, all_sides, patches, patch_k_, views, sky ? &*sky : nullptr);
  if (angular_.made.size() < 2) return;  // no mirrors
  sources_.first_elevation = sources_.radiance.size();
  for (std::size_t k = 0; k < kSkyElevations; ++k)
    sources_.radiance.push_back(
        sky_at(scene.sky, nodes_, sky ? &*sky : nullptr, 0.5 * std::numbers::pi - sky_elevation(k)));
}

bool BandShader::prepare(double camera_height_m, const PathExtent& extent) {
  if (tables_ && camera_height_m == camera_height_m_ && grid_.extent.covers(extent)) return false;
  camera_height_m_ = camera_height_m;
  if (with_air_) {
    view_ = std::make_unique<AirView>(*scene_.air, nodes_, scene_.altitude_m, camera_height_m,
                                      with_room(extent).farthest_m);
    grid_ = path_grid(*view_, nodes_, with_room(extent), tolerance_);
  } else {
    grid_ = no_air(nodes_);
  }
  tables_ = std::make_unique<BandTables>(nodes_, *folds_, emissivity_, sources_, grid_,
                                         view_ ? view_->reference_k() : 300.0, angular_.made);
  promised_ = promised_error(band_.curves, curves_, *folds_, *tables_, grid_, view_.get());
  backdrop_ = std::make_unique<Backdrop>(scene_, nodes_, sources_, view_.get(), camera_height_m,
                                         ground_height_m(scene_.facets()));
  sunlight_ = 0.0;
  const double black = integral(nodes_, blackbody_at(nodes_, view_ ? view_->reference_k() : 300.0));
  for (std::size_t m = 0; m < scene_.finish.size(); ++m)
    for (const double value : tables_->sunlit(m, 0)) sunlight_ = std::max(sunlight_, value / black);
  for (Shaded& one : shaded_) one.finish = scene::kNone;
  return true;
}

BandShader::Shaded BandShader::shaded(const VisibleSides& sides, std::size_t number, PathGrid::Cell cell) const {
  const std::uint32_t side = sides.side(number), finish = scene_.finish_of[side];
  const std::size_t node = grid_.index(cell);
  SixValues sum = tables_->emitted(finish, static_cast<double>(scene_.temperature_k[side]), node);
  if (tables_->reflects(finish)) {
    const auto [source, share] = sides.light(number);
    for (std::size_t i = 0; i < source.size(); ++i)
      tables_->add_reflected(finish, source[i], static_cast<double>(share[i]), node, sum);
  }
  const SixValues path = tables_->path(node);
  Shaded out{.value = {}, .cell = cell, .finish = finish};
  for (std::size_t k = 0; k < sum.size(); ++k) out.value[k] = static_cast<float>(sum[k] + path[k]);
  return out;
}

std::size_t BandShader::shade(const VisibleSides& sides, const Point& camera, int threads) {
  using scene::operator-;
  shaded_.resize(sides.size());
  std::atomic<std::size_t> count = 0;
  mtf::parallel_for(static_cast<std::int64_t>(sides.size()), 1024, threads, [&](std::int64_t begin, std::int64_t end) {
    std::size_t here = 0;
    for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
      const scene::Point& centre = sides.facet(n).centre;
      const PathGrid::Cell cell = grid_.cell_at(std::sqrt(scene::length(centre - camera)), centre[2]);
      if (shaded_[n].finish != scene::kNone && shaded_[n].cell == cell) continue;
      shaded_[n] = shaded(sides, n, cell);
      ++here;
    }
    count += here;
  });
  return count;
}

void BandShader::radiance(const RayHits& hits, const VisibleSides& sides, std::vector<float>& out, int threads) const {
  out.resize(hits.side.size());
  // What the weights of each cell need, and the sun at its nodes.
  struct CellPlace {
    float root, per_root, height, per_height;
  };
  std::vector<CellPlace> places;
  for (std::size_t layer = 0; layer < grid_.layers(); ++layer)
    for (std::size_t cell = 0; cell < grid_.cells(); ++cell)
      places.push_back({static_cast<float>(grid_.root[2 * cell]),
                        static_cast<float>(1.0 / (grid_.root[2 * cell + 2] - grid_.root[2 * cell])),
                        static_cast<float>(grid_.height_m[layer]),
                        static_cast<float>(1.0 / (grid_.height_m[layer + 1] - grid_.height_m[layer]))});
  const bool sunny = tables_->sunny(), traced = !hits.lit.empty();
  std::vector<std::array<float, 6>> sun;
  for (std::size_t m = 0; sunny && m < scene_.finish.size(); ++m)
    for (std::uint16_t layer = 0; layer < grid_.layers(); ++layer)
      for (std::uint16_t cell = 0; cell < grid_.cells(); ++cell) {
        const SixValues wide = tables_->sunlit(m, grid_.index({cell, layer}));
        std::array<float, 6> narrow{};
        for (std::size_t k = 0; k < 6; ++k) narrow[k] = static_cast<float>(wide[k]);
        sun.push_back(narrow);
      }
  constexpr float kSlack = 1e-4F;  // of a cell, at the ends of which neighbours agree
  const std::size_t cells = grid_.cells();
  const auto last_cell = static_cast<std::uint16_t>(cells - 1),
             last_layer = static_cast<std::uint16_t>(grid_.layers() - 1);

  mtf::parallel_for(
      static_cast<std::int64_t>(hits.side.size()), 1 << 14, threads, [&](std::int64_t begin, std::int64_t end) {
        struct Elsewhere {
          std::uint32_t number = scene::kNone;
          Shaded shaded;
        };
        std::array<Elsewhere, 256> elsewhere;
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const std::uint32_t side = hits.side[i];
          if (side == scene::kNone) {
            out[i] = static_cast<float>(backdrop_->radiance(static_cast<double>(hits.height_m[i])));
            continue;
          }
          const std::uint32_t number = sides.number(side);
          const Shaded* at = &shaded_[number];
          const float root = std::sqrt(hits.range_m[i]), height = hits.height_m[i];
          std::size_t place = at->cell.layer * cells + at->cell.root;
          float t = (root - places[place].root) * places[place].per_root;
          float u = (height - places[place].height) * places[place].per_height;
          const bool inside =
              (t >= -kSlack || at->cell.root == 0) && (t <= 1.0F + kSlack || at->cell.root == last_cell) &&
              (u >= -kSlack || at->cell.layer == 0) && (u <= 1.0F + kSlack || at->cell.layer == last_layer);
          if (!inside) {
            const PathGrid::Cell cell = grid_.cell_at(static_cast<double>(root), static_cast<double>(height));
            Elsewhere& known = elsewhere[number % elsewhere.size()];
            if (known.number != number || !(known.shaded.cell == cell)) known = {number, shaded(sides, number, cell)};
            at = &known.shaded;
            place = cell.layer * cells + cell.root;
            t = (root - places[place].root) * places[place].per_root;
            u = (height - places[place].height) * places[place].per_height;
          }
          t = std::clamp(t, 0.0F, 1.0F);
          u = std::clamp(u, 0.0F, 1.0F);
          const float a = (1.0F - t) * (1.0F - 2.0F * t), b = 4.0F * t * (1.0F - t), c = t * (2.0F * t - 1.0F);
          const auto mixed = [&](const std::array<float, 6>& v) {
            const float low = a * v[0] + b * v[1] + c * v[2], high = a * v[3] + b * v[4] + c * v[5];
            return low + u * (high - low);
          };
          float sum = mixed(at->value);
          if (sunny) {
            const float lit = !traced ? sides.sun_share(number) : hits.lit[i] != 0 ? 1.0F : 0.0F;
            if (lit > 0.0F) sum += lit * sides.sun_cosine(number) * mixed(sun[at->finish * places.size() + place]);
          }
          out[i] = sum;
        }
      });
}

double BandShader::emissivity(std::size_t finish, double temperature_k) const {
  const std::vector<double> black = blackbody_at(nodes_, std::max(temperature_k, 50.0));
  double sum = 0.0;
  for (std::size_t k = 0; k < black.size(); ++k) sum += nodes_.weight[k] * emissivity_[finish][k] * black[k];
  return sum / integral(nodes_, black);
}

double BandShader::own_radiance(std::size_t finish, double temperature_k, double range_m, double height_m) const {
  const double root = std::sqrt(range_m);
  const PathGrid::Cell cell = grid_.cell_at(root, height_m);
  const auto weights = grid_.weights(cell, root, height_m);
  const SixValues own = tables_->emitted(finish, temperature_k, grid_.index(cell)),
                  path = tables_->path(grid_.index(cell));
  double sum = 0.0;
  for (std::size_t k = 0; k < 6; ++k) sum += static_cast<double>(weights[k]) * (own[k] + path[k]);
  return sum;
}

double BandShader::path_radiance(double range_m, double height_m) const {
  const double root = std::sqrt(range_m);
  const PathGrid::Cell cell = grid_.cell_at(root, height_m);
  const auto weights = grid_.weights(cell, root, height_m);
  const SixValues path = tables_->path(grid_.index(cell));
  double sum = 0.0;
  for (std::size_t k = 0; k < 6; ++k) sum += static_cast<double>(weights[k]) * path[k];
  return sum;
}

}  // namespace radiometry::render
