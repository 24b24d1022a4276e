// SPDX-License-Identifier: Apache-2.0

// What differs from pixel to pixel in a chain, for the pixels of an image or of a tile: maps from files are cut, random
// ones are made from the numbers of each pixel's place on the detector.

#include <algorithm>
#include <limits>
#include <span>

#include "mtf/parallel.h"
#include "mtf/survey/statistics.h"
#include "radiometry/chain_impl.h"
#include "radiometry/chain_tiles.h"

namespace radiometry {
namespace {

void require_size(const mtf::Image& map, const char* key, std::int64_t columns, std::int64_t rows) {
  if (map.width() == columns && map.height() == rows) return;
  throw mtf::UsageError(std::string(key) + ": the map has " + std::to_string(map.width()) + "x" +
                        std::to_string(map.height()) + " pixels, the detector " + std::to_string(columns) + "x" +
                        std::to_string(rows) + "; give a map of the whole detector");
}

/// The part of a map of the whole detector that an image has; empty where there is no map.
mtf::Image part_of(const std::shared_ptr<const mtf::Image>& whole, const char* key, const DetectorSource& source) {
  if (!whole) return {};
  require_size(*whole, key, source.detector.columns, source.detector.rows);
  mtf::Image part(source.width, source.height);
  for (std::int64_t y = 0; y < source.height; ++y)
    std::copy_n(whole->data() + (source.origin.y + y) * whole->width() + source.origin.x, source.width,
                part.data() + y * source.width);
  return part;
}

std::span<float> values_of(mtf::Image& map) { return {map.data(), static_cast<std::size_t>(map.size())}; }

double mean(mtf::ImageView<const float> factors, int threads) {
  if (factors.data == nullptr) return 1.0;
  return mtf::statistics(factors, threads).mean;
}

/// `shading`, as bright on the mean as `own`; an empty image stands for factors of 1, one of the two is none.
mtf::Image as_bright(const mtf::Image& shading, const mtf::Image& own, int threads) {
  mtf::Image factors = shading.clone();
  if (factors.size() == 0) {
    factors = mtf::Image(own.width(), own.height());
    std::ranges::fill(values_of(factors), 1.0F);
  }
  const auto scale = static_cast<float>(mean(own.view(), threads) / mean(shading.view(), threads));
  for (float& factor : values_of(factors)) factor *= scale;
  return factors;
}

DetectorSource detector_source(const CompiledChain& chain, const Sensor& sensor, Origin origin, std::int64_t width,
                               std::int64_t height) {
  const SensorSettings& s = chain.settings;
  return {.nonuniformity = s.nonuniformity,
          .narcissus = s.narcissus,
          .defects = s.defects,
          .blinking = s.blinking,
          .responsivity = sensor.responsivity,
          .offset = sensor.offset,
          .detector = chain.detector,
          .origin = origin,
          .width = width,
          .height = height,
          .seed = chain.seed};
}

DetectorMaps detector_maps(const DetectorSource& source, int threads) {
  const std::int64_t width = source.width, height = source.height;
  DetectorMaps maps{.made_from = source};
  if (const auto& unequal = source.nonuniformity) {
    maps.responsivity = part_of(source.responsivity, "nonuniformity.responsivity", source);
    if (maps.responsivity.size() == 0 && unequal->prnu > 0.0) {
      maps.responsivity = mtf::Image(width, height);
      responsivity_map(maps.responsivity.view(), unequal->prnu, source.seed, source.origin, threads);
    }
    maps.offset = part_of(source.offset, "nonuniformity.offset", source);
    if (maps.offset.size() == 0 && unequal->dsnu_e > 0.0) {
      maps.offset = mtf::Image(width, height);
      offset_map(maps.offset.view(), unequal->dsnu_e, source.seed, source.origin, threads);
    }
  }
  if (source.narcissus) {
    maps.narcissus = mtf::Image(width, height);
    narcissus_map(maps.narcissus.view(), *source.narcissus, source.detector, source.origin);
    for (float& missing : values_of(maps.narcissus)) missing = 1.0F - missing;
  }
  if (source.defects) maps.defects = find_defects(width, height, *source.defects, source.seed, source.origin, threads);
  if (source.blinking) maps.blinking = find_blinking(width, height, *source.blinking, source.seed, source.origin);
  return maps;
}

}  // namespace

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
  return {.detector = detector_source(chain, sensor, origin, width, height),
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

PixelMaps pixel_maps(const CompiledChain& chain, const Sensor& sensor, Origin origin, std::int64_t width,
                     std::int64_t height, int threads, const PixelMaps* before) {
  const SensorSettings& s = chain.settings;
  const int cores = mtf::threads_of(threads);
  require_on_detector(origin, width, height);
  require_region(chain.detector, origin, width, height);
  PixelMaps maps{.origin = origin};
  const DetectorSource source = detector_source(chain, sensor, origin, width, height);
  maps.detector = before != nullptr && before->detector->made_from == source
                      ? before->detector
                      : std::make_shared<const DetectorMaps>(detector_maps(source, cores));
  if (s.vignetting) {
    const mtf::Image given = part_of(sensor.vignetting, "vignetting.map", source);
    maps.corners = mtf::Image(width, height);
    vignetting_map(maps.corners.view(), *s.vignetting, chain.detector, chain.focal_length_mm, origin, given.view(),
                   cores);
  }
  if (const auto& kept = chain.map_source.shading) maps.corners = as_bright(kept->corners, maps.corners, cores);
  const DetectorMaps& detector = *maps.detector;
  maps.light = factor_of(chain.gain, maps.corners, detector.responsivity, 0.0, cores);
  maps.glow = glow_of(chain, chain.warm, maps.corners, detector.narcissus, detector.responsivity, chain.dark_e, cores);
  return maps;
}

}  // namespace radiometry
