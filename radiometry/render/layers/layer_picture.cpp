// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/layers/layer_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/units.h"
#include "radiometry/render/angles/angular_finishes.h"
#include "radiometry/scene/tracing/zenith_rings.h"

namespace radiometry::render {
namespace {

using scene::operator*;

constexpr double kHottest_k = 3000.0, kFarthest_m = 1e6;

[[noreturn]] void refuse(std::int64_t x, std::int64_t y, const std::string& what) {
  throw mtf::UsageError("layers: column " + std::to_string(x) + ", row " + std::to_string(y) + ": " + what);
}

bool has_surface(const SurfaceLayers& layers, std::int64_t x, std::int64_t y) { return layers.finish.at(x, y) >= 0.0F; }

Vector unit_direction(const Camera& camera, std::int64_t x, std::int64_t y) {
  const Vector d = camera.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
  return (1.0 / scene::length(d)) * d;
}

/// What the tables have to cover.
struct Survey {
  PathExtent extent{std::numeric_limits<double>::infinity(), 0.0, std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  std::vector<KelvinRange> range{};
  std::size_t surfaces = 0;
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
      ++out.surfaces;
    }
  if (out.surfaces == 0) throw mtf::UsageError("layers: no pixel shows a surface: all materials are below 0");
  out.range = ranges.all();
  return out;
}

/// One band of the picture.
class LayerShader {
 public:
  LayerShader(const RenderScene& scene, const RenderBand& band, const Camera& camera, const Survey& survey,
              const LayerOptions& options)
      : scene_(scene), camera_(camera), rings_(options.rings) {
    std::vector<Spectrum> curves;
    for (const Finish& finish : scene.finish) {
      curves.push_back(finish.emissivity);
      for (double& value : curves.back().value) value = std::min(1.0, value * hemispherical_mean(finish.by_angle));
    }
    const BandNodes nodes = band_nodes(band.curves, curves);
    std::vector<std::vector<double>> emissivity;
    for (const Spectrum& curve : curves) emissivity.push_back(at_nodes(nodes, curve));
    const EmissionFolds folds(nodes, emissivity, survey.range);
    std::optional<AirView> sky, view;
    if (scene.air && scene.air->profile.levels.size() > 1)
      sky.emplace(*scene.air, nodes, scene.altitude_m, survey.extent.lowest_m);
    if (scene.air) view.emplace(*scene.air, nodes, scene.altitude_m, camera.position[2], survey.extent.farthest_m);
    const Patches none{};
    const scene::Views unseen{
        .rings = options.rings, .sky = {}, .ground = {}, .surfaces = {}, .rays = {}, .patches = {}};
    const LightSources sources = light_sources(scene, nodes, emissivity, none, {}, unseen, sky ? &*sky : nullptr);
    grid_ = view ? path_grid(*view, nodes, survey.extent, options.tolerance) : no_air(nodes);
    tables_ =
        std::make_unique<BandTables>(nodes, folds, emissivity, sources, grid_, view ? view->reference_k() : 300.0);
    promised_ = promised_error(band.curves, curves, folds, *tables_, grid_, view ? &*view : nullptr);
    backdrop_ = std::make_unique<Backdrop>(scene, nodes, sources, view ? &*view : nullptr, camera.position[2],
                                           survey.extent.lowest_m);
  }

  double promised() const { return promised_; }

  float radiance(const SurfaceLayers& layers, std::int64_t x, std::int64_t y) const {
    const Vector d = unit_direction(camera_, x, y);
    if (!has_surface(layers, x, y)) return static_cast<float>(backdrop_->radiance(d[2]));
    const auto finish = static_cast<std::size_t>(layers.finish.at(x, y));
    const auto range_m = static_cast<double>(layers.range_m.at(x, y));
    const double root = std::sqrt(range_m), height = camera_.position[2] + range_m * d[2];
    const PathGrid::Cell cell = grid_.cell_at(root, height);
    const std::size_t node = grid_.index(cell);
    SixValues sum = tables_->emitted(finish, static_cast<double>(layers.temperature_k.at(x, y)), node);
    if (tables_->reflects(finish)) {
      Vector normal = -1.0 * d;
      if (!layers.normal.empty())
        normal = {static_cast<double>(layers.normal[0].at(x, y)), static_cast<double>(layers.normal[1].at(x, y)),
                  static_cast<double>(layers.normal[2].at(x, y))};
      const double size = scene::length(normal);
      if (!(size > 0.0 && std::isfinite(size))) refuse(x, y, "its normal has no direction");
      std::vector<double> zones(static_cast<std::size_t>(rings_.rings()) + 1, 0.0);
      rings_.add_shares(std::clamp(normal[2] / size, -1.0, 1.0), 1.0, zones);
      for (std::size_t zone = 0; zone < zones.size(); ++zone)
        if (zones[zone] != 0.0) tables_->add_reflected(finish, zone, zones[zone], node, sum);
      if (tables_->sunny() && !layers.normal.empty()) {
        const double facing = scene::dot(normal, scene_.sun->to_sun) / (size * scene::length(scene_.sun->to_sun));
        const double lit = layers.sunlit ? std::clamp(static_cast<double>(layers.sunlit->at(x, y)), 0.0, 1.0) : 1.0;
        const SixValues sun = tables_->sunlit(finish, node);
        for (std::size_t k = 0; k < 6; ++k) sum[k] += lit * std::max(facing, 0.0) * sun[k];
      }
    }
    return static_cast<float>(grid_.between(cell, root, height, sum_of(sum, tables_->path(node))));
  }

 private:
  const RenderScene& scene_;
  const Camera& camera_;
  scene::ZenithRings rings_;
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
  require_sizes(camera, layers);
  const Survey survey = survey_of(scene, camera, layers);
  LayerFrame frame{.radiance = {}, .promised = {}, .surfaces = survey.surfaces, .ground_m = survey.extent.lowest_m};
  for (const RenderBand& band : bands) {
    const LayerShader shader(scene, band, camera, survey, options);
    mtf::Image image(camera.width, camera.height);
    mtf::parallel_for(camera.height, 8, options.threads, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t y = begin; y < end; ++y)
        for (std::int64_t x = 0; x < camera.width; ++x) image.at(x, y) = shader.radiance(layers, x, y);
    });
    frame.promised.push_back(shader.promised());
    frame.radiance.push_back(std::move(image));
  }
  return frame;
}

}  // namespace radiometry::render
