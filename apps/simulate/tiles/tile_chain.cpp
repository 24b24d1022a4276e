// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/tiles/tile_chain.h"

#include <algorithm>

#include "apps/sensor/sensor_place.h"
#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/parallel.h"

namespace apps {
namespace {

/// The counts of a frame that reports sum up, in the order in which they are kept with a tile.
template <class Frame>
auto counts_in(Frame& frame) {
  return std::array{&frame.well.low,
                    &frame.well.high,
                    &frame.adc.low,
                    &frame.adc.high,
                    &frame.held.pixels,
                    &frame.held.full_well,
                    &frame.held.most_count,
                    &frame.held.least_count,
                    &frame.held_defects.pixels,
                    &frame.held_defects.full_well,
                    &frame.held_defects.most_count,
                    &frame.held_defects.least_count};
}

mtf::io::TileCounts counts_of(const radiometry::ChainFrame& frame) {
  mtf::io::TileCounts counts;
  for (const std::int64_t* count : counts_in(frame)) counts.push_back(*count);
  return counts;
}

/// The last output stage before the one wanted whose image can be made in tiles.
std::optional<radiometry::OutputStage> earlier_stage(const RadiometricChain& radiometric) {
  using radiometry::OutputStage;
  const radiometry::Sensor& sensor = radiometric.loaded.sensor;
  for (int i = static_cast<int>(radiometric.stage) - 1; i >= 0; --i) {
    const auto stage = static_cast<OutputStage>(i);
    if (stage == OutputStage::dn && !sensor.settings.adc) continue;
    if (!may_have_stage(stage, sensor.settings.thermal.has_value())) continue;
    if (whole_image_stages(radiometric.system, sensor, stage).empty()) return stage;
  }
  return std::nullopt;
}

}  // namespace

std::string stages_of_the_whole(const RadiometricChain& radiometric) {
  return whole_image_stages(radiometric.system, radiometric.loaded.sensor, radiometric.stage);
}

void require_tileable(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric) {
  const std::string whole = stages_of_the_whole(radiometric);
  if (whole.empty()) return;
  const auto stage = earlier_stage(radiometric);
  throw mtf::UsageError("--memory: the image goes through in tiles, and these stages of " + one_line(config.file) +
                        " need all of it at once: " + whole + "; leave out --memory, or remove their tables" +
                        (stage ? ", or take the image before them with --stage " + output_stage_name(*stage) : ""));
}

mtf::System<double> presample_of(const RadiometricChain& radiometric) {
  mtf::System<double> system = radiometric.system;
  system.list(mtf::Stage::readout).clear();
  system.list(mtf::Stage::postsample).clear();
  return system;
}

double read_as_light(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric, const std::string& file,
                     TileScene& source, std::int64_t memory, int threads, RunWatch& watch) {
  require_light_of_windows(config, radiometric.loaded, source.scene, one_line(file));
  const mtf::SampleGrid detector = mtf::detector_grid(config.system, source.scene.grid);
  at_its_place(config, [&] { require_maps(radiometric.loaded.sensor, detector.width, detector.height); });
  const std::vector<mtf::Survey> values =
      survey_all(source, {.every = 0, .memory = memory, .threads = threads, .step = "range"}, watch);
  const LightOfWindows light = at_its_place(
      config, [&] { return light_of_windows(config, radiometric.loaded, source.scene, values.front().statistics); });
  source.read = [values_of = std::move(source.read), convert = light.convert](
                    std::size_t channel, std::int64_t x, std::int64_t y, mtf::ImageView<float> out) {
    values_of(channel, x, y, out);
    convert(out);
  };
  return light.border_value;
}

void count_memory(const RadiometricChain& radiometric, mtf::TileOptions& options) {
  options.receiver_bytes = tile_bytes_a_pixel(radiometric.loaded.sensor);
  options.held_bytes = map_bytes(radiometric.loaded.sensor);
}

ChainOfTiles::ChainOfTiles(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric,
                           const mtf::TiledSensorPlan& plan, radiometry::Origin first, int threads, ChainReport& report)
    : chain_(at_its_place(config,
                          [&] {
                            const mtf::SampleGrid whole = mtf::detector_grid(config.system, plan.in());
                            return radiometry::TiledChain(plan.inner(), radiometric.system, radiometric.loaded.sensor,
                                                          whole.width, whole.height, radiometric.stage);
                          })),
      first_(first),
      threads_(std::max(1, mtf::threads_of(threads) / plan.report().in_flight)),
      report_(report) {}

ChainOfTiles::Result ChainOfTiles::run(const mtf::Tile& tile, mtf::ImageView<const float> light) {
  mtf::Image image(light.width, light.height);
  for (std::int64_t y = 0; y < light.height; ++y) std::copy_n(light.row(y), light.width, image.view().row(y));
  radiometry::ChainFrame frame =
      chain_.run(std::move(image), {first_.x + tile.region.x, first_.y + tile.region.y}, 0, threads_);
  const std::scoped_lock guard(lock_);
  report_.add(frame);
  for (const auto& [stage, ms] : frame.timing_ms) radiometry::add_time(report_.timing_ms, stage, ms);
  return {std::move(frame.image), counts_of(frame)};
}

std::size_t ChainOfTiles::counts_a_tile() { return counts_of({}).size(); }

void ChainOfTiles::add(const mtf::io::TileCounts& counts) {
  radiometry::ChainFrame frame;
  const auto places = counts_in(frame);
  for (std::size_t i = 0; i < counts.size(); ++i) *places[i] = counts[i];
  report_.add(frame);
}

}  // namespace apps
