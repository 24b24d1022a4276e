// SPDX-License-Identifier: Apache-2.0

// What differs from pixel to pixel in a chain, for the pixels of an image or of a tile: maps from files are cut, random
// ones are made from the numbers of each pixel's place on the detector. With it the light of the camera itself: warm
// optics and housing, and the closed shutter of a thermal camera over a sequence (thermal_settings.h).

#include <limits>

#include "mtf/engines/statistics.h"
#include "mtf/parallel.h"
#include "radiometry/chain/chain_impl.h"
#include "radiometry/chain/chain_tiles.h"

namespace radiometry {
namespace {

void require_size(const mtf::Image& map, const char* key, std::int64_t columns, std::int64_t rows) {
  if (map.width() == columns && map.height() == rows) return;
  throw mtf::UsageError(std::string(key) + ": the map has " + std::to_string(map.width()) + "x" +
                        std::to_string(map.height()) + " pixels, the detector " + std::to_string(columns) + "x" +
                        std::to_string(rows) + "; give a map of the whole detector");
}

SharedMap shared(mtf::Image map) {
  return map.size() > 0 ? std::make_shared<const mtf::Image>(std::move(map)) : nullptr;
}

double mean(const SharedMap& map, int threads) { return map ? mtf::statistics(map->view(), threads).mean : 1.0; }

SharedMap product(const SharedMap& a, const SharedMap& b, int threads) {
  if (!a || !b) return a ? a : b;
  mtf::Image both = a->clone();
  multiply_add(both, {1.0, b}, {0.0}, threads);
  return shared(std::move(both));
}

DetectorMaps detector_maps(const DetectorSource& source, int threads) {
  const std::int64_t width = source.width, height = source.height;
  DetectorMaps maps;
  if (const auto& unequal = source.nonuniformity) {
    mtf::Image responsivity = part_of(source.responsivity, "nonuniformity.responsivity", source);
    if (responsivity.size() == 0 && unequal->has_prnu()) {
      responsivity = mtf::Image(width, height);
      responsivity_map(responsivity.view(), {unequal->prnu, unequal->prnu_row, unequal->prnu_column}, source.seed,
                       source.origin, threads);
    }
    maps.responsivity = shared(std::move(responsivity));
  }
  for (const StageRow& row : stage_table())
    if (SharedMap map = row.map != nullptr ? shared(row.map(source, threads)) : nullptr)
      maps.of_stages.emplace(row.name, std::move(map));
  maps.own_light = maps.responsivity;
  if (source.narcissus) {
    mtf::Image left(width, height);
    narcissus_map(left.view(), *source.narcissus, source.plane, source.origin);
    multiply_add(left, {-1.0}, {1.0}, threads);
    maps.own_light = product(shared(std::move(left)), maps.responsivity, threads);
  }
  if (source.defects) maps.defects = find_defects(width, height, *source.defects, source.seed, source.origin, threads);
  if (source.blinking) maps.blinking = find_blinking(width, height, *source.blinking, source.seed, source.origin);
  return maps;
}

/// The vignetting of the settings.
SharedMap corners_of(const MapSource& source, int threads) {
  if (!source.vignetting) return nullptr;
  const DetectorSource& d = source.detector;
  const mtf::Image given = part_of(source.given_vignetting, "vignetting.map", d);
  mtf::Image corners(d.width, d.height);
  vignetting_map(corners.view(), *source.vignetting, d.plane, source.focal_length_mm, d.origin, given.view(), threads);
  return shared(std::move(corners));
}

Directions<double> difference(const Directions<double>& a, const Directions<double>& b) {
  return {a.cone_e - b.cone_e, a.around_e - b.around_e};
}

Directions<double> open_at(const CompiledChain& chain, const CameraEmission& camera) {
  return own_light(chain.camera, chain.pixel, own_radiances(chain.curves, camera));
}

Directions<double> closed_at(const CompiledChain& chain, const CameraEmission& camera) {
  return closed_shutter(chain.camera, chain.pixel, own_radiances(chain.curves, camera));
}

}  // namespace

mtf::Image part_of(const SharedMap& whole, const char* key, const DetectorSource& source) {
  if (!whole) return {};
  require_size(*whole, key, source.plane.columns, source.plane.rows);
  return copy_of(part_of(whole->view(), {source.origin.x, source.origin.y, source.width, source.height}));
}

void require_maps(const Sensor& sensor, std::int64_t columns, std::int64_t rows) {
  const auto check = [&](const std::shared_ptr<const mtf::Image>& map, const char* key, const std::string& file,
                         float least) {
    if (!map) return;
    require_size(*map, key, columns, rows);
    require_numbers(std::string(key) + ": " + (file.empty() ? "the map" : file), map->view(), least);
  };
  if (const auto& corners = sensor.settings.vignetting) check(sensor.vignetting, "vignetting.map", corners->map, 0.0F);
  if (const auto& unequal = sensor.settings.nonuniformity) {
    check(sensor.responsivity, "nonuniformity.responsivity", unequal->responsivity, 0.0F);
    check(sensor.offset, "nonuniformity.offset", unequal->offset, std::numeric_limits<float>::lowest());
  }
}

MapSource map_source(const CompiledChain& chain, const Sensor& sensor, Origin origin, std::int64_t width,
                     std::int64_t height) {
  const SensorSettings& s = chain.settings;
  return {.detector = {.nonuniformity = s.nonuniformity,
                       .narcissus = s.narcissus,
                       .defects = s.defects,
                       .blinking = s.blinking,
                       .responsivity = sensor.responsivity,
                       .offset = sensor.offset,
                       .plane = chain.detector,
                       .origin = origin,
                       .width = width,
                       .height = height,
                       .seed = chain.seed},
          .vignetting = s.vignetting,
          .given_vignetting = sensor.vignetting,
          .focal_length_mm = chain.focal_length_mm,
          .gain = chain.gain,
          .dark_e = chain.dark_e,
          .warm = chain.warm,
          .cone_sr = cone_sr(chain.camera),
          .around_sr = around_cone_sr(chain.camera),
          .shutter = s.thermal && s.thermal->shutter_k,
          .closes = chain.events.has_value()};
}

PixelMaps pixel_maps(const CompiledChain& chain, const MapSource& source, int threads, const PixelMaps* before) {
  const int cores = mtf::threads_of(threads);
  const DetectorSource& d = source.detector;
  require_on_detector(d.origin, d.width, d.height);
  require_region(d.plane, d.origin, d.width, d.height);
  PixelMaps maps{.made_from = source};
  const bool same_detector = before != nullptr && before->made_from.detector == d;
  maps.detector = same_detector ? before->detector : std::make_shared<const DetectorMaps>(detector_maps(d, cores));
  const bool same_corners = same_detector && !before->made_from.shading && same_shading(before->made_from, source);
  maps.corners = {1.0, same_corners ? before->corners.map : corners_of(source, cores)};
  if (source.shading) {
    const SharedMap& kept = source.shading->corners.map;
    maps.corners = {mean(maps.corners.map, cores) / mean(kept, cores), kept};
  }
  maps.light = {chain.gain * maps.corners.number, same_detector && before->corners.map == maps.corners.map
                                                      ? before->light.map
                                                      : product(maps.corners.map, maps.detector->responsivity, cores)};
  maps.glow = glow_of(chain, chain.warm, maps.corners, maps.detector->own_light, chain.dark_e, cores);
  return maps;
}

Linear glow_of(const CompiledChain& chain, const Directions<double>& light, const Linear& corners,
               const SharedMap& sensitivity, double added, int threads) {
  const bool shutter = chain.settings.thermal && chain.settings.thermal->shutter_k;
  if (!shutter || (!corners.map && corners.number == 1.0)) return {light.total_e(), sensitivity, added};
  // v of the cone is left, and pi - v cone around it.
  const double cone = cone_sr(chain.camera), around = around_cone_sr(chain.camera);
  const double around_per_sr = around > 0.0 ? light.around_e / around : 0.0;
  const double always = mtf::kPi * around_per_sr, by_cone = light.cone_e - cone * around_per_sr;
  if (!corners.map) return {always + by_cone * corners.number, sensitivity, added};
  mtf::Image seen = corners.map->clone();
  multiply_add(seen, {by_cone * corners.number}, {always}, threads);
  multiply_add(seen, {1.0, sensitivity}, {added}, threads);
  return {1.0, std::make_shared<const mtf::Image>(std::move(seen))};
}

Directions<double> warming_of(const CompiledChain& chain, std::uint32_t frame) {
  const double by_k = chain.events->warming_k(frame);
  if (by_k == 0.0) return {};
  return difference(open_at(chain, warmed(chain.emission, by_k)), open_at(chain, chain.emission));
}

Directions<double> last_closed(const CompiledChain& chain, std::uint32_t frame, ChainState* state) {
  const std::uint32_t last = chain.events->closing_before(frame);
  const ShutterClosing now{last, warmed(chain.emission, chain.events->warming_k(last))};
  if (state != nullptr && (!state->closing || state->closing->frame != last)) state->closing = now;
  return closed_at(chain, state != nullptr ? state->closing->camera : now.camera);
}

}  // namespace radiometry
