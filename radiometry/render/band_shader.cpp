// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/band_shader.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

/// Of each finish, over all sides and the ground.
std::vector<KelvinRange> ranges_of(const RenderScene& scene) {
  KelvinRanges ranges(scene.finish.size());
  for (std::size_t s = 0; s < scene.finish_of.size(); ++s)
    if (!std::isnan(scene.temperature_k[s]))
      ranges.take(scene.finish_of[s], static_cast<double>(scene.temperature_k[s]));
  ranges.take(scene.ground.finish, scene.ground.temperature_k);
  return ranges.all();
}

constexpr double kRoom_k = 2.0;  // so that temperatures to come are in the tables too

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
  emits_ = emissivity_;
  for (const MadeFinish& made : angular_.made) emits_.push_back(made.emits);
  for (const KelvinRange& range : ranges_of(scene)) range_.push_back({range.lo_k - kRoom_k, range.hi_k + kRoom_k});
  make_folds();
  std::optional<AirView> sky;
  if (scene.air && scene.air->profile.levels.size() > 1)
    sky.emplace(*scene.air, nodes_, scene.altitude_m, scene.facets().lowest_m);
  patch_k_ = patch_temperatures_k(scene, patches);
  sources_ = light_sources(scene, nodes_, all_sides, patches, patch_k_, views, sky ? &*sky : nullptr);
  if (angular_.made.size() < 2) return;  // no mirrors
  sources_.first_elevation = sources_.radiance.size();
  for (std::size_t k = 0; k < kSkyElevations; ++k)
    sources_.radiance.push_back(
        sky_at(scene.sky, nodes_, sky ? &*sky : nullptr, 0.5 * std::numbers::pi - sky_elevation(k)));
}

/// Finishes that were made for angles have the temperatures of those that they show.
void BandShader::make_folds() {
  std::vector<KelvinRange> ranges = range_;
  for (const std::uint32_t like : angular_.like)
    ranges.push_back(like == scene::kNone ? KelvinRange{300.0, 300.0} : range_[like]);
  folds_ = std::make_unique<EmissionFolds>(nodes_, emits_, ranges);
}

void BandShader::temperatures_changed() {
  const std::vector<KelvinRange> now = ranges_of(scene_);
  bool covered = true;
  for (std::size_t m = 0; m < now.size(); ++m)
    covered = covered && now[m].lo_k >= range_[m].lo_k && now[m].hi_k <= range_[m].hi_k;
  if (!covered) {
    for (std::size_t m = 0; m < now.size(); ++m)
      range_[m] = {std::min(range_[m].lo_k, now[m].lo_k - kRoom_k), std::max(range_[m].hi_k, now[m].hi_k + kRoom_k)};
    make_folds();
    tables_.reset();
  }
  for (Shaded& one : shaded_) one.finish = scene::kNone;
}

BandShader::FromHeight BandShader::from_height(double height_m, const AirView* view, const PathGrid& grid,
                                               std::optional<double> nearest_m) const {
  return {height_m,
          BandTables(nodes_, *folds_, emissivity_, sources_, grid, view != nullptr ? view->reference_k() : 300.0,
                     angular_.made),
          Backdrop(scene_, nodes_, sources_, view, height_m, scene_.facets().lowest_m, nearest_m)};
}

void BandShader::use(FromHeight from) {
  camera_height_m_ = from.height_m;
  tables_ = std::make_unique<BandTables>(std::move(from.tables));
  backdrop_ = std::make_unique<Backdrop>(std::move(from.backdrop));
  sunlight_ = 0.0;
  const double black = integral(nodes_, blackbody_at(nodes_, view_ ? view_->reference_k() : 300.0));
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
    return AirView(*scene_.air, nodes_, scene_.altitude_m, from_m, extent.farthest_m);
  };
  for (const double most_m : {48.0, 12.0}) {
    const double apart_m = std::min(most_m, 2.0 * above_m);
    const double low_m = std::max(height_m - (rises ? 1.0 - kAhead : kAhead) * apart_m, ground_m + 0.5 * above_m);
    auto middle = std::make_unique<AirView>(view_from(low_m + 0.5 * apart_m));
    PathGrid grid = path_grid(*middle, nodes_, extent, tolerance_);
    double promised = 0.0;
    const auto end_at = [&](double end_m) {
      const AirView view = view_from(end_m);
      const PathGrid seen = seen_from(view, grid, threads);
      FromHeight end = from_height(end_m, &view, seen, low_m - ground_m);
      promised = std::max(promised, promised_error(band_.curves, curves_, *folds_, end.tables, seen, &view));
      return end;
    };
    FromHeight low = end_at(low_m), high = end_at(low_m + apart_m);
    const BandTables between = BandTables::between(low.tables, high.tables, 0.5);
    promised = std::max(promised, promised_error(band_.curves, curves_, *folds_, between, grid, middle.get()));
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
    backdrop_ =
        std::make_unique<Backdrop>(scene_, nodes_, sources_, view_.get(), camera_height_m, scene_.facets().lowest_m);
    return true;
  }
  constexpr double kLeastAbove_m = 0.1;  // of a camera that has the ground below it
  const bool moves =
      tables_ && camera_height_m != camera_height_m_ && camera_height_m - scene_.facets().lowest_m > kLeastAbove_m;
  if (layered && moves) {
    make_ends(camera_height_m, with_room(extent), threads);
    take_between(camera_height_m);
    return true;
  }
  std::unique_ptr<AirView> view;
  if (with_air_)
    view = std::make_unique<AirView>(*scene_.air, nodes_, scene_.altitude_m, camera_height_m,
                                     with_room(extent).farthest_m);
  PathGrid grid = view ? path_grid(*view, nodes_, with_room(extent), tolerance_) : no_air(nodes_);
  FromHeight own = from_height(camera_height_m, view.get(), grid, std::nullopt);
  promised_ = promised_error(band_.curves, curves_, *folds_, own.tables, grid, view.get());
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
  if (tables_->reflects(finish)) {
    const auto [source, share] = sides.light(number);
    for (std::size_t i = 0; i < source.size(); ++i)
      tables_->add_reflected(finish, source[i], static_cast<double>(share[i]), node, sum);
  }
  sum = sum_of(sum, tables_->path(node));
  Shaded out{.value = {}, .cell = cell, .finish = finish};
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

void BandShader::radiance(const VisibleParts& parts, const VisibleSides& sides, const MirrorRays& mirrors, bool shadows,
                          mtf::Image& out, int threads) const {
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
  const bool sunny = tables_->sunny();
  std::vector<bool> by_angle(scene_.finish.size(), false);  // these come from `mirrors`
  for (std::size_t m = 0; m < by_angle.size(); ++m) by_angle[m] = has_angles(scene_.finish[m]);
  const bool angles = mirrors.size() > 0;
  const int points = parts.n * parts.n;
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
      static_cast<std::int64_t>(parts.band.size()), 1, threads, [&](std::int64_t begin, std::int64_t end) {
        struct Elsewhere {
          std::uint32_t number = scene::kNone;
          Shaded shaded;
        };
        std::array<Elsewhere, 256> elsewhere;
        const auto of_part = [&](const SamplePart& part) {
          if (part.side == scene::kNone)
            return static_cast<float>(backdrop_->radiance(static_cast<double>(part.height_m)));
          if (angles && by_angle[scene_.finish_of[part.side]]) return 0.0F;
          const std::uint32_t number = sides.number(part.side);
          const Shaded* at = &shaded_[number];
          const float root = std::sqrt(part.range_m), height = part.height_m;
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
            const float lit = !shadows ? sides.sun_share(number) : part.lit ? 1.0F : 0.0F;
            if (lit > 0.0F) sum += lit * sides.sun_cosine(number) * mixed(sun[at->finish * places.size() + place]);
          }
          return sum;
        };
        for (std::int64_t band = begin; band < end; ++band)
          for (const SamplePart& part : parts.band[static_cast<std::size_t>(band)]) {
            const float value = of_part(part);
            float& pixel = out.data()[static_cast<std::int64_t>(part.row) * out.width() + part.column];
            const float share = static_cast<float>(part.shown) / static_cast<float>(points);
            pixel = part.shown == points ? value : (part.points & 1U) != 0U ? share * value : pixel + share * value;
          }
      });
  if (angles) add_angles(mirrors, parts, sides, shadows, out, threads);
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
  const std::size_t node = grid_.index(cell);
  return grid_.between(cell, root, height_m,
                       sum_of(tables_->emitted(finish, temperature_k, node), tables_->path(node)));
}

double BandShader::path_radiance(double range_m, double height_m) const {
  const double root = std::sqrt(range_m);
  const PathGrid::Cell cell = grid_.cell_at(root, height_m);
  return grid_.between(cell, root, height_m, tables_->path(grid_.index(cell)));
}

}  // namespace radiometry::render
