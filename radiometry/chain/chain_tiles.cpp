// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain/chain_tiles.h"

#include <algorithm>

#include "mtf/parallel.h"
#include "radiometry/chain/chain_impl.h"

namespace radiometry {

TiledChain::TiledChain(const mtf::SensorPlan& tile, const mtf::System<double>& system, const Sensor& sensor,
                       std::int64_t columns, std::int64_t rows, OutputStage stage)
    : sensor_(sensor), stage_(stage) {
  if (const std::string whole = whole_image_stages(system, sensor, stage); !whole.empty())
    throw mtf::UsageError("stages that need the whole image cannot run in tiles: " + whole);
  auto compiled = std::make_shared<CompiledChain>(tile, system, sensor, columns, rows);
  require_output_stage(stage, compiled->last, compiled->adc.has_value(), sensor.settings.thermal.has_value());
  require_maps(sensor, compiled->detector.columns, compiled->detector.rows);
  // Refuses settings of maps before any tile has been made.
  pixel_maps(*compiled, map_source(*compiled, sensor, {}, 1, 1), 1);
  compiled_ = std::move(compiled);
}

ChainFrame TiledChain::run(mtf::Image radiance, Origin origin, std::uint32_t frame, int threads) const {
  const MapSource source = map_source(*compiled_, sensor_, origin, radiance.width(), radiance.height());
  const PixelMaps maps = pixel_maps(*compiled_, source, threads);
  FrameRun run{.chain = *compiled_,
               .maps = maps,
               .threads = mtf::threads_of(threads),
               .key = {compiled_->seed, frame},
               .number = frame};
  run.frame.image = std::move(radiance);
  run.run_to(stage_);
  return std::move(run.frame);
}

double tile_bytes_a_pixel(const mtf::System<double>& system, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  const auto one = [](bool there) { return there ? 1.0 : 0.0; };
  const auto& unequal = s.nonuniformity;
  const bool corners = s.vignetting.has_value(), around = s.narcissus.has_value();
  const bool responsivity = unequal && (sensor.responsivity || unequal->has_prnu());
  // Dark current of 0 has no stage, and all the same its map.
  const bool dark = unequal && unequal->dcnu > 0.0;
  const auto own = static_cast<double>(std::ranges::count_if(stage_table(), [&](const StageRow& row) {
    return row.map != nullptr && (dark || row.words(system, sensor).on);
  }));
  // The image, the map of a file that vignetting is cut from, the maps of pixel_maps(), and that of a shutter that
  // closes now and then.
  const bool shutter = s.thermal && s.thermal->shutter_k, closes = s.thermal && s.thermal->closes();
  const double planes = 1.0 + 2.0 * one(corners) + own + one(responsivity) + one(corners && responsivity) +
                        one(around) + one(around && responsivity) + one(shutter && corners) + one(closes);
  // Lists of single pixels grow by doubling; each pixel is in the list of those held apart too.
  const double listed = (s.defects ? s.defects->dead_fraction + s.defects->hot_fraction : 0.0) +
                        (s.blinking ? 2.0 * s.blinking->fraction : 0.0);
  return sizeof(float) * planes + 2.0 * (sizeof(DefectivePixel) + sizeof(std::int64_t)) * listed;
}

std::int64_t map_bytes(const Sensor& sensor) {
  std::int64_t pixels = 0;
  for (const auto& map : {sensor.responsivity, sensor.offset, sensor.vignetting})
    if (map) pixels += map->size();
  return static_cast<std::int64_t>(sizeof(float)) * pixels;
}

}  // namespace radiometry
