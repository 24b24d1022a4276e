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

/// The part of a map of the whole detector that an image at `origin` has.
mtf::Image crop(const mtf::Image& map, Origin origin, std::int64_t width, std::int64_t height) {
  mtf::Image part(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    std::copy_n(map.data() + (origin.y + y) * map.width() + origin.x, width, part.data() + y * width);
  return part;
}

/// factors *= map; an empty image stands for factors of 1.
void multiply(mtf::Image& factors, mtf::Image&& map) {
  if (map.size() == 0) return;
  if (factors.size() == 0)
    factors = std::move(map);
  else
    multiply_by(factors.view(), map.view());
}

std::span<float> values_of(mtf::Image& map) { return {map.data(), static_cast<std::size_t>(map.size())}; }

double mean(mtf::ImageView<const float> factors) {
  if (factors.data == nullptr) return 1.0;
  return mtf::statistics(factors).mean;
}

/// `shading`, as bright on the mean as `own`; an empty image stands for factors of 1, one of the two is none.
mtf::Image as_bright(const mtf::Image& shading, const mtf::Image& own) {
  mtf::Image factors = shading.clone();
  if (factors.size() == 0) {
    factors = mtf::Image(own.width(), own.height());
    std::ranges::fill(values_of(factors), 1.0F);
  }
  const auto scale = static_cast<float>(mean(own.view()) / mean(shading.view()));
  for (float& factor : values_of(factors)) factor *= scale;
  return factors;
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
  return {.vignetting = s.vignetting,
          .nonuniformity = s.nonuniformity,
          .narcissus = s.narcissus,
          .defects = s.defects,
          .blinking = s.blinking,
          .given = {sensor.vignetting, sensor.responsivity, sensor.offset},
          .detector = chain.detector,
          .origin = origin,
          .width = width,
          .height = height,
          .seed = chain.seed,
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
                     std::int64_t height, int threads) {
  const SensorSettings& s = chain.settings;
  const int cores = mtf::threads_of(threads);
  require_on_detector(origin, width, height);
  require_region(chain.detector, origin, width, height);
  PixelMaps maps;
  maps.origin = origin;
  const auto detector_map = [&](const std::shared_ptr<const mtf::Image>& whole, const char* key) {
    if (!whole) return mtf::Image();
    require_size(*whole, key, chain.detector.columns, chain.detector.rows);
    return crop(*whole, origin, width, height);
  };
  if (s.vignetting) {
    const mtf::Image given = detector_map(sensor.vignetting, "vignetting.map");
    maps.corners = mtf::Image(width, height);
    vignetting_map(maps.corners.view(), *s.vignetting, chain.detector, chain.focal_length_mm, origin, given.view(),
                   cores);
  }
  if (const auto& kept = chain.map_source.shading) maps.corners = as_bright(kept->corners, maps.corners);
  mtf::Image responsivity;
  if (const auto& unequal = s.nonuniformity) {
    responsivity = detector_map(sensor.responsivity, "nonuniformity.responsivity");
    if (responsivity.size() == 0 && unequal->prnu > 0.0) {
      responsivity = mtf::Image(width, height);
      responsivity_map(responsivity.view(), unequal->prnu, chain.seed, origin, cores);
    }
    maps.offset = detector_map(sensor.offset, "nonuniformity.offset");
    if (maps.offset.size() == 0 && unequal->dsnu_e > 0.0) {
      maps.offset = mtf::Image(width, height);
      offset_map(maps.offset.view(), unequal->dsnu_e, chain.seed, origin, cores);
    }
  }
  mtf::Image seen = maps.corners.clone(), around;
  multiply(seen, responsivity.clone());
  maps.light = factor_of(chain.gain, seen, 0.0);
  if (chain.events) maps.responsivity = responsivity.clone();
  if (s.narcissus) {
    around = mtf::Image(width, height);
    narcissus_map(around.view(), *s.narcissus, chain.detector, origin);
    for (float& missing : values_of(around)) missing = 1.0F - missing;
  }
  multiply(around, std::move(responsivity));
  maps.glow = glow_of(chain, chain.warm, maps.corners, around, chain.dark_e);
  if (s.defects) maps.defects = find_defects(width, height, *s.defects, chain.seed, origin, cores);
  if (s.blinking) maps.blinking = find_blinking(width, height, *s.blinking, chain.seed, origin);
  return maps;
}

}  // namespace radiometry
