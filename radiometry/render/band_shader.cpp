// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/band_shader.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "mtf/parallel.h"
#include "radiometry/scene/table_error.h"

namespace radiometry::render {
namespace {

/// Of each finish, over all sides and the ground, and so much more at both ends.
std::vector<KelvinRange> ranges_of(const RenderScene& scene, double room_k) {
  KelvinRanges ranges(scene.finish.size());
  for (std::size_t s = 0; s < scene.finish_of.size(); ++s)
    if (!std::isnan(scene.temperature_k[s]))
      ranges.take(scene.finish_of[s], static_cast<double>(scene.temperature_k[s]));
  ranges.take(scene.ground.finish, scene.ground.temperature_k);
  std::vector<KelvinRange> out = ranges.all();
  for (KelvinRange& range : out) range = {range.lo_k - room_k, range.hi_k + room_k};
  return out;
}

constexpr double kRoom_k = 2.0;  // so that temperatures to come are in the tables too

/// Wider than it has to be, so that a camera that moves a little keeps it.
PathExtent with_room(const PathExtent& extent) {
  constexpr double kFarther = 1.25, kNearer = 0.8, kHigher = 0.1;
  const double room = kHigher * (extent.highest_m - extent.lowest_m);
  return {kNearer * extent.nearest_m, kFarther * extent.farthest_m, extent.lowest_m - room, extent.highest_m + room};
}

/// The same together with what the present tables cover, unless that is much more: otherwise a camera that goes to and
/// fro has to wait for new tables again and again.
PathExtent with_room(const PathExtent& extent, const PathExtent& present) {
  constexpr double kMuch = 2.0, kFlat_m = 1.0;
  const PathExtent own = with_room(extent),
                   both{std::min(own.nearest_m, present.nearest_m), std::max(own.farthest_m, present.farthest_m),
                        std::min(own.lowest_m, present.lowest_m), std::max(own.highest_m, present.highest_m)};
  const auto ranges = [](const PathExtent& of) { return std::log(of.farthest_m / of.nearest_m); };
  const auto heights = [](const PathExtent& of) { return of.highest_m - of.lowest_m; };
  const bool much = !(ranges(both) <= kMuch * ranges(own) && both.farthest_m <= kMuch * own.farthest_m &&
                      heights(both) <= kMuch * std::max(heights(own), kFlat_m));
  return much ? own : both;
}

}  // namespace

BandShader::BandShader(RenderBand band, const RenderScene& scene, const Patches& patches, const scene::Views& views,
                       double tolerance, bool with_air)
    : band_(std::move(band)),
      scene_(scene),
      tolerance_(tolerance),
      with_air_(with_air && scene.air.has_value()),
      patches_(&patches),
      surfaces_(band_.curves, scene, patches, views, ranges_of(scene, kRoom_k), scene.facets().lowest_m) {}

void BandShader::temperatures_changed() {
  const std::vector<KelvinRange> now = ranges_of(scene_, 0.0), &known = surfaces_.range;
  bool covered = true;
  for (std::size_t m = 0; m < now.size(); ++m)
    covered = covered && now[m].lo_k >= known[m].lo_k && now[m].hi_k <= known[m].hi_k;
  if (!covered) {
    std::vector<KelvinRange> both = ranges_of(scene_, kRoom_k);
    for (std::size_t m = 0; m < both.size(); ++m)
      both[m] = {std::min(known[m].lo_k, both[m].lo_k), std::max(known[m].hi_k, both[m].hi_k)};
    surfaces_.cover(std::move(both));
    tables_.reset();
  }
  for (Shaded& one : shaded_) one.finish = scene::kNone;
}

BandShader::FromHeight BandShader::from_height(double height_m, const AirView* view, const PathGrid& grid,
                                               std::optional<double> nearest_m) const {
  return {height_m, surfaces_.tables(grid, view),
          Backdrop(scene_, surfaces_.nodes, surfaces_.sources, view, height_m, scene_.facets().lowest_m, nearest_m)};
}

void BandShader::use(FromHeight from) {
  camera_height_m_ = from.height_m;
  tables_ = std::make_unique<BandTables>(std::move(from.tables));
  backdrop_ = std::make_unique<Backdrop>(std::move(from.backdrop));
  sunlight_ = 0.0;
  const double black = integral(surfaces_.nodes, blackbody_at(surfaces_.nodes, view_ ? view_->reference_k() : 300.0));
  for (std::size_t m = 0; m < scene_.finish.size(); ++m)
    for (const double value : tables_->sunlit(m, 0)) sunlight_ = std::max(sunlight_, value / black);
  for (Shaded& one : shaded_) one.finish = scene::kNone;
}

bool BandShader::take_between(double height_m) {
  if (!low_ || height_m < low_->height_m || height_m > high_->height_m) return false;
  const double share = (height_m - low_->height_m) / (high_->height_m - low_->height_m);
  use({height_m, BandTables::between(low_->tables, high_->tables, share),
       Backdrop::between(low_->backdrop, high_->backdrop, share)});
  return true;
}

/// The promise is that of the middle between both heights, where straight lines err most, and of the ends. The lower
/// end is at least half as far above the ground as the camera is, so that the ground has one table of ranges for both.
void BandShader::make_ends(double height_m, const PathExtent& extent, int threads) {
  constexpr double kAhead = 0.9;  // of the way between the ends lies before a camera that goes on
  const double ground_m = scene_.facets().lowest_m, above_m = height_m - ground_m;
  const bool rises = height_m > camera_height_m_;
  const auto view_from = [&](double from_m) {
    return AirView(*scene_.air, surfaces_.nodes, scene_.altitude_m, from_m, extent.farthest_m);
  };
  for (const double most_m : {48.0, 12.0}) {
    const double apart_m = std::min(most_m, 2.0 * above_m);
    const double low_m = std::max(height_m - (rises ? 1.0 - kAhead : kAhead) * apart_m, ground_m + 0.5 * above_m);
    auto middle = std::make_unique<AirView>(view_from(low_m + 0.5 * apart_m));
    PathGrid grid = path_grid(*middle, surfaces_.nodes, extent, tolerance_);
    double promised = 0.0;
    const auto end_at = [&](double end_m) {
      const AirView view = view_from(end_m);
      const PathGrid seen = seen_from(view, grid, threads);
      FromHeight end = from_height(end_m, &view, seen, low_m - ground_m);
      promised =
          std::max(promised, promised_error(band_.curves, surfaces_.curves, *surfaces_.folds, end.tables, seen, &view));
      return end;
    };
    FromHeight low = end_at(low_m), high = end_at(low_m + apart_m);
    const BandTables between = BandTables::between(low.tables, high.tables, 0.5);
    promised = std::max(promised,
                        promised_error(band_.curves, surfaces_.curves, *surfaces_.folds, between, grid, middle.get()));
    if (promised > std::max(tolerance_, kBetweenHeights) && most_m > 12.0) continue;
    view_ = std::move(middle);
    grid_ = std::move(grid);
    low_ = std::move(low), high_ = std::move(high);
    promised_ = promised;
    return;
  }
}

bool BandShader::prepare(double camera_height_m, const PathExtent& extent, int threads) {
  const bool covered = tables_ && grid_.extent.covers(extent);
  if (covered && camera_height_m == camera_height_m_) return false;
  if (covered && take_between(camera_height_m)) return true;
  const bool layered = with_air_ && scene_.air->profile.levels.size() > 1;
  if (covered && !layered) {
    camera_height_m_ = camera_height_m;
    backdrop_ = std::make_unique<Backdrop>(scene_, surfaces_.nodes, surfaces_.sources, view_.get(), camera_height_m,
                                           scene_.facets().lowest_m);
    return true;
  }
  const PathExtent wanted = tables_ ? with_room(extent, grid_.extent) : with_room(extent);
  constexpr double kLeastAbove_m = 0.1;  // of a camera that has the ground below it
  const bool moves =
      tables_ && camera_height_m != camera_height_m_ && camera_height_m - scene_.facets().lowest_m > kLeastAbove_m;
  if (layered && moves) {
    make_ends(camera_height_m, wanted, threads);
    take_between(camera_height_m);
    return true;
  }
  std::unique_ptr<AirView> view;
  if (with_air_)
    view =
        std::make_unique<AirView>(*scene_.air, surfaces_.nodes, scene_.altitude_m, camera_height_m, wanted.farthest_m);
  PathGrid grid = view ? path_grid(*view, surfaces_.nodes, wanted, tolerance_) : no_air(surfaces_.nodes);
  FromHeight own = from_height(camera_height_m, view.get(), grid, std::nullopt);
  promised_ = promised_error(band_.curves, surfaces_.curves, *surfaces_.folds, own.tables, grid, view.get());
  low_.reset(), high_.reset();
  view_ = std::move(view);
  grid_ = std::move(grid);
  use(std::move(own));
  return true;
}

BandShader::Shaded BandShader::shaded(const VisibleSides& sides, std::size_t number, PathGrid::Cell cell) const {
  const std::uint32_t side = sides.side(number), finish = scene_.finish_of[side];
  const std::size_t node = grid_.index(cell);
  SixValues sum = tables_->emitted(finish, static_cast<double>(scene_.temperature_k[side]), node);
  if (tables_->reflects(finish)) tables_->add_light(finish, sides.light(number), node, sum);
  sum = sum_of(sum, tables_->path(node));
  Shaded out{.cell = cell, .finish = finish};
  for (std::size_t k = 0; k < sum.size(); ++k) out.value[k] = static_cast<float>(sum[k]);
  return out;
}

std::size_t BandShader::shade(const VisibleSides& sides, const Point& camera, int threads) {
  using scene::operator-;
  shaded_.resize(sides.size());
  std::atomic<std::size_t> count = 0;
  mtf::parallel_for(static_cast<std::int64_t>(sides.size()), 1024, threads, [&](std::int64_t begin, std::int64_t end) {
    std::size_t here = 0;
    for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
      if (!sides.shown(n)) continue;
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

double BandShader::reflected_error_k(const VisibleSides& sides, const VisibleSides::OtherViews& other,
                                     const Point& camera) const {
  using scene::operator-;
  std::vector<double> differences;  // of sides that reflect
  double variance = 0.0;
  for (std::size_t k = 0; k < other.number.size(); ++k) {
    const std::size_t number = other.number[k];
    const std::uint32_t finish = scene_.finish_of[sides.side(number)];
    if (!tables_->reflects(finish)) continue;
    const scene::Point& centre = sides.facet(number).centre;
    const double root = std::sqrt(scene::length(centre - camera));
    const PathGrid::Cell cell = grid_.cell_at(root, centre[2]);
    const auto light_of = [&](std::uint32_t source) {
      SixValues all{};
      tables_->add_reflected(finish, source, 1.0, grid_.index(cell), all);
      return grid_.between(cell, root, centre[2], all);
    };
    const auto [source, share] = sides.light(number);
    double mean = 0.0, square = 0.0, again = 0.0;
    for (std::size_t i = 0; i < source.size(); ++i) {
      const double light = light_of(source[i]), part = static_cast<double>(share[i]) * light;
      mean += part;
      square += part * light;
    }
    for (std::size_t i = other.first[k]; i < other.first[k + 1]; ++i)
      again += static_cast<double>(other.share[i]) * light_of(other.source[i]);
    differences.push_back(std::numbers::sqrt2 / 2.0 * (again - mean));  // each set has half of the variance
    if (again != mean) variance += std::max(0.0, square - mean * mean) / sides.rays();
  }
  constexpr double kAt_k = 300.0, kStep_k = 0.5;
  const auto black = [&](double kelvin) { return integral(surfaces_.nodes, blackbody_at(surfaces_.nodes, kelvin)); };
  const double per_k = (black(kAt_k + kStep_k) - black(kAt_k - kStep_k)) / (2.0 * kStep_k);
  const std::size_t count = differences.size();
  return scene::error_of(std::move(differences), variance, count).rms / per_k;
}

double BandShader::emissivity(std::size_t finish, double temperature_k) const {
  const std::vector<double> black = blackbody_at(surfaces_.nodes, std::max(temperature_k, 50.0));
  double sum = 0.0;
  for (std::size_t k = 0; k < black.size(); ++k)
    sum += surfaces_.nodes.weight[k] * surfaces_.emissivity[finish][k] * black[k];
  return sum / integral(surfaces_.nodes, black);
}

double BandShader::own_radiance(std::size_t finish, double temperature_k, double range_m, double height_m) const {
  const double root = std::sqrt(range_m);
  const PathGrid::Cell cell = grid_.cell_at(root, height_m);
  const std::size_t node = grid_.index(cell);
  return grid_.between(cell, root, height_m,
                       sum_of(tables_->emitted(finish, temperature_k, node), tables_->path(node)));
}

double BandShader::path_radiance(double range_m, double height_m) const {
  const double root = std::sqrt(range_m);
  const PathGrid::Cell cell = grid_.cell_at(root, height_m);
  return grid_.between(cell, root, height_m, tables_->path(grid_.index(cell)));
}

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
