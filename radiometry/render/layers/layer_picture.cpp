// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/layers/layer_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/units.h"
#include "radiometry/scene/views.h"

namespace radiometry::render {
namespace {

using scene::operator*;

constexpr double kHottest_k = 3000.0, kFarthest_m = 1e6;

[[noreturn]] void refuse(std::int64_t x, std::int64_t y, const std::string& what) {
  throw mtf::UsageError("layers: column " + std::to_string(x) + ", row " + std::to_string(y) + ": " + what);
}

bool has_surface(const SurfaceLayers& layers, std::int64_t x, std::int64_t y) { return layers.finish.at(x, y) >= 0.0F; }

Vector unit_direction(const Camera& camera, std::int64_t x, std::int64_t y) {
  return scene::unit(camera.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5));
}

/// What the tables have to cover.
struct Survey {
  PathExtent extent{std::numeric_limits<double>::infinity(), 0.0, std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  std::vector<KelvinRange> range{};
  std::size_t surfaces = 0, glossy = 0, angled = 0;
};

void require_sizes(const Camera& camera, const SurfaceLayers& layers) {
  const auto check = [&](const mtf::Image& image, const char* what) {
    if (image.width() == camera.width && image.height() == camera.height) return;
    throw mtf::UsageError(std::string("layers: ") + what + " has " + std::to_string(image.width()) + " x " +
                          std::to_string(image.height()) + " pixels, the sensor takes " + std::to_string(camera.width) +
                          " x " + std::to_string(camera.height) + " samples; render with that resolution");
  };
  check(layers.range_m, "the depth"), check(layers.finish, "the material"),
      check(layers.temperature_k, "the temperature");
  for (const mtf::Image& one : layers.normal) check(one, "the normal");
  if (layers.sunlit) check(*layers.sunlit, "the sunlit share");
}

Survey survey_of(const RenderScene& scene, const Camera& camera, const SurfaceLayers& layers) {
  Survey out;
  KelvinRanges ranges(scene.finish.size());
  ranges.take(scene.ground.finish, scene.ground.temperature_k);
  for (std::int64_t y = 0; y < camera.height; ++y)
    for (std::int64_t x = 0; x < camera.width; ++x) {
      if (!has_surface(layers, x, y)) continue;
      const auto finish = static_cast<double>(layers.finish.at(x, y)),
                 kelvin = static_cast<double>(layers.temperature_k.at(x, y)),
                 range_m = static_cast<double>(layers.range_m.at(x, y));
      if (finish != std::floor(finish) || finish >= static_cast<double>(scene.finish.size()))
        refuse(x, y,
               "there is no material " + mtf::format_double(finish) + "; there are " +
                   std::to_string(scene.finish.size()) + ", from 0 on");
      if (!(kelvin > 0.0 && kelvin <= kHottest_k))
        refuse(x, y,
               mtf::format_double(kelvin) + " K, which no surface has; it is above 0 and at most " +
                   mtf::format_double(kHottest_k) + " K");
      if (!(range_m > 0.0 && range_m <= kFarthest_m))
        refuse(x, y,
               "a surface at a range of " + mtf::format_double(range_m) + " m; it is above 0 and at most " +
                   mtf::format_double(kFarthest_m) + " m");
      constexpr float kRounding = 1e-3F;  // of means over samples
      if (const float lit = layers.sunlit ? layers.sunlit->at(x, y) : 0.0F;
          !(lit >= -kRounding && lit <= 1.0F + kRounding))
        refuse(x, y, mtf::format_double(static_cast<double>(lit)) + " of a surface sunlit; it is a share from 0 to 1");
      const double height = camera.position[2] + range_m * unit_direction(camera, x, y)[2];
      out.extent = {std::min(out.extent.nearest_m, range_m), std::max(out.extent.farthest_m, range_m),
                    std::min(out.extent.lowest_m, height), std::max(out.extent.highest_m, height)};
      ranges.take(static_cast<std::size_t>(finish), kelvin);
      const Finish& shown = scene.finish[static_cast<std::size_t>(finish)];
      ++out.surfaces;
      out.glossy += shown.gloss > 0.0 ? 1 : 0;
      out.angled += has_angles(shown) ? 1 : 0;
    }
  if (out.surfaces == 0) throw mtf::UsageError("layers: no pixel shows a surface: all materials are below 0");
  out.range = ranges.all();
  return out;
}

/// What lies around a surface: the zones of sky and ground with their shares, and the sun.
struct Around {
  std::span<const std::uint32_t> source{};
  std::vector<double> share{};
  Vector normal{};
  double sun = 0.0;  ///< share of the surface in the sun, times its cosine
};

/// One band of the picture.
class LayerShader {
 public:
  LayerShader(const RenderScene& scene, const RenderBand& band, const Camera& camera, const SurfaceLayers& layers,
              const Survey& survey, const LayerOptions& options)
      : scene_(scene),
        camera_(camera),
        layers_(layers),
        rings_(options.rings),
        zones_(static_cast<std::size_t>(options.rings) + 1),
        surfaces_(band.curves, scene, {}, {.rings = options.rings}, survey.range, survey.extent.lowest_m) {
    std::iota(zones_.begin(), zones_.end(), 0U);
    const BandNodes& nodes = surfaces_.nodes;
    std::optional<AirView> air;
    if (scene.air) air.emplace(*scene.air, nodes, scene.altitude_m, camera.position[2], survey.extent.farthest_m);
    const AirView* view = air ? &*air : nullptr;
    grid_ = view != nullptr ? path_grid(*view, nodes, survey.extent, options.tolerance) : no_air(nodes);
    tables_ = std::make_unique<BandTables>(surfaces_.tables(grid_, view));
    promised_ = promised_error(band.curves, surfaces_.curves, *surfaces_.folds, *tables_, grid_, view);
    backdrop_ =
        std::make_unique<Backdrop>(scene, nodes, surfaces_.sources, view, camera.position[2], survey.extent.lowest_m);
    for (const Finish& finish : scene.finish) mean_.push_back(hemispherical_mean(finish.by_angle));
  }

  double promised() const { return promised_; }

  float radiance(std::int64_t x, std::int64_t y) const {
    const Vector d = unit_direction(camera_, x, y);
    if (!has_surface(layers_, x, y)) return static_cast<float>(backdrop_->radiance(d[2]));
    const auto finish = static_cast<std::size_t>(layers_.finish.at(x, y));
    const auto range_m = static_cast<double>(layers_.range_m.at(x, y)),
               kelvin = static_cast<double>(layers_.temperature_k.at(x, y));
    const double root = std::sqrt(range_m), height = camera_.position[2] + range_m * d[2];
    const PathGrid::Cell cell = grid_.cell_at(root, height);
    const std::size_t node = grid_.index(cell);
    const bool angles = has_angles(scene_.finish[finish]);
    const Around around = angles || tables_->reflects(finish) ? around_of(x, y, d) : Around{};
    SixValues sum{};
    if (angles) {
      sum = surfaces_.seen(*tables_, node, finish, surfaces_.light(*tables_, node, finish, kelvin, around),
                           seen_at(finish, d, around));
    } else {
      sum = tables_->emitted(finish, kelvin, node);
      tables_->add_light(finish, around, node, sum);
      if (around.sun > 0.0) add(around.sun, tables_->sunlit(finish, node), sum);
      sum = sum_of(sum, tables_->path(node));
    }
    return static_cast<float>(grid_.between(cell, root, height, sum));
  }

 private:
  Around around_of(std::int64_t x, std::int64_t y, const Vector& d) const {
    Vector normal = -1.0 * d;
    if (!layers_.normal.empty())
      normal = {static_cast<double>(layers_.normal[0].at(x, y)), static_cast<double>(layers_.normal[1].at(x, y)),
                static_cast<double>(layers_.normal[2].at(x, y))};
    const double size = scene::length(normal);
    if (!(size > 0.0 && std::isfinite(size))) refuse(x, y, "its normal has no direction");
    Around out{.source = zones_, .share = std::vector(zones_.size(), 0.0)};
    rings_.add_shares(std::clamp(normal[2] / size, -1.0, 1.0), 1.0, out.share);
    out.normal = (1.0 / size) * normal;
    if (!tables_->sunny() || layers_.normal.empty()) return out;
    const double facing = scene::dot(normal, scene_.sun->to_sun) / (size * scene::length(scene_.sun->to_sun));
    const double lit = layers_.sunlit ? std::clamp(static_cast<double>(layers_.sunlit->at(x, y)), 0.0, 1.0) : 1.0;
    out.sun = lit * std::max(facing, 0.0);
    return out;
  }

  /// Mirrors show sky or ground: nothing else is known.
  SeenAt seen_at(std::size_t finish, const Vector& d, const Around& around) const {
    if (layers_.normal.empty()) return {.relative = mean_[finish]};
    const double cosine = std::max(0.0, -scene::dot(d, around.normal));
    return {.relative = relative_emissivity(scene_.finish[finish].by_angle, cosine),
            .gloss = scene_.finish[finish].gloss,
            .sun = around.sun,
            .mirror = {.rise = d[2] + 2.0 * cosine * around.normal[2]}};
  }

  const RenderScene& scene_;
  const Camera& camera_;
  const SurfaceLayers& layers_;
  scene::ZenithRings rings_;
  std::vector<std::uint32_t> zones_;
  BandSurfaces surfaces_;
  std::vector<double> mean_;  ///< by finish: emissivity over the hemisphere over that along the normal
  PathGrid grid_;
  std::unique_ptr<BandTables> tables_;
  std::unique_ptr<Backdrop> backdrop_;
  double promised_ = 0.0;
};

}  // namespace

void ranges_of_depths(const Camera& camera, mtf::Image& depth) {
  for (std::int64_t y = 0; y < depth.height(); ++y)
    for (std::int64_t x = 0; x < depth.width(); ++x) {
      const Vector d = camera.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      depth.at(x, y) = static_cast<float>(static_cast<double>(depth.at(x, y)) * scene::length(d));
    }
}

LayerFrame render_layers(const RenderScene& scene, std::span<const RenderBand> bands, const Camera& camera,
                         const SurfaceLayers& layers, const LayerOptions& options) {
  require_valid_surroundings(scene);
  require_sizes(camera, layers);
  const Survey survey = survey_of(scene, camera, layers);
  LayerFrame frame;
  frame.surfaces = survey.surfaces, frame.ground_m = survey.extent.lowest_m;
  const bool normals = !layers.normal.empty();
  (normals ? frame.mirrors : frame.as_matt) = normals ? survey.glossy : survey.angled;
  if (!normals && scene.sun) frame.unlit = survey.surfaces;
  for (const RenderBand& band : bands) {
    const LayerShader shader(scene, band, camera, layers, survey, options);
    mtf::Image image(camera.width, camera.height);
    mtf::parallel_for_each(camera.height, 8, options.threads, [&](std::int64_t y) {
      for (std::int64_t x = 0; x < camera.width; ++x) image.at(x, y) = shader.radiance(x, y);
    });
    frame.promised.push_back(shader.promised());
    frame.radiance.push_back(std::move(image));
  }
  return frame;
}

}  // namespace radiometry::render
