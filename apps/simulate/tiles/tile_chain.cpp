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
std::optional<radiometry::OutputStage> earlier_stage(const RadiometricChain& chain) {
  using radiometry::OutputStage;
  const radiometry::Sensor& sensor = chain.loaded.sensor;
  for (int i = static_cast<int>(chain.stage) - 1; i >= 0; --i) {
    const auto stage = static_cast<OutputStage>(i);
    if (stage == OutputStage::dn && !sensor.settings.adc) continue;
    if (!may_have_stage(stage, sensor.settings.thermal.has_value())) continue;
    if (whole_image_stages(chain.system, sensor, stage).empty()) return stage;
  }
  return std::nullopt;
}

}  // namespace

std::string stages_of_the_whole(const SensorRun& sensor) {
  const RadiometricChain* chain = sensor.chain();
  return chain ? whole_image_stages(chain->system, chain->loaded.sensor, chain->stage) : std::string();
}

void require_tileable(const SensorRun& sensor) {
  const std::string whole = stages_of_the_whole(sensor);
  if (whole.empty()) return;
  const auto stage = earlier_stage(*sensor.chain());
  throw mtf::UsageError("--memory: the image goes through in tiles, and these stages of " +
                        one_line(sensor.config().file) + " need all of it at once: " + whole +
                        "; leave out --memory, or remove their tables" +
                        (stage ? ", or take the image before them with --stage " + output_stage_name(*stage) : ""));
}

mtf::System<double> tiled_system(const SensorRun& sensor) {
  mtf::System<double> system = sensor.system();
  if (sensor.is_linear()) return system;
  system.list(mtf::Stage::readout).clear();
  system.list(mtf::Stage::postsample).clear();
  return system;
}

double read_as_light(const SensorRun& sensor, const std::string& file, TileScene& source, std::int64_t memory,
                     int threads, RunWatch& watch) {
  const mtf::io::SensorConfig& config = sensor.config();
  if (sensor.is_linear()) return config.scene.border_value;
  const LoadedSensor& loaded = sensor.chain()->loaded;
  require_light_of_windows(config, loaded, source.scene, one_line(file));
  const mtf::SampleGrid detector = mtf::detector_grid(config.system, source.scene.grid);
  at_its_place(config, [&] { require_maps(loaded.sensor, detector.width, detector.height); });
  const std::vector<mtf::Survey> values =
      survey_all(source, {.every = 0, .memory = memory, .threads = threads, .step = "range"}, watch);
  const LightOfWindows light =
      at_its_place(config, [&] { return light_of_windows(config, loaded, source.scene, values.front().statistics); });
  source.read = [values_of = std::move(source.read), convert = light.convert](
                    std::size_t channel, std::int64_t x, std::int64_t y, mtf::ImageView<float> out) {
    values_of(channel, x, y, out);
    convert(out);
  };
  return light.border_value;
}

void count_memory(const SensorRun& sensor, mtf::TileOptions& options) {
  if (sensor.is_linear()) return;
  options.receiver_bytes = tile_bytes_a_pixel(sensor.chain()->loaded.sensor);
  options.held_bytes = map_bytes(sensor.chain()->loaded.sensor);
}

ChainOfTiles::ChainOfTiles(const SensorRun& sensor, const mtf::TiledSensorPlan& plan, radiometry::Origin first,
                           int threads, std::optional<ChainReport>& report)
    : first_(first), threads_(std::max(1, mtf::threads_of(threads) / plan.report().in_flight)), report_(report) {
  const RadiometricChain* chain = sensor.chain();
  if (chain == nullptr) return;
  const mtf::SampleGrid whole = mtf::detector_grid(sensor.config().system, plan.in());
  at_its_place(sensor.config(), [&] {
    chain_.emplace(plan.inner(), chain->system, chain->loaded.sensor, whole.width, whole.height, chain->stage);
  });
}

void ChainOfTiles::run(const mtf::Tile& tile, Planes filtered, const Take& take) {
  if (!chain_) return take(tile, filtered, {});
  const mtf::ImageView<const float>& light = filtered.front();
  mtf::Image image(light.width, light.height);
  for (std::int64_t y = 0; y < light.height; ++y) std::copy_n(light.row(y), light.width, image.view().row(y));
  const radiometry::ChainFrame frame =
      chain_->run(std::move(image), {first_.x + tile.region.x, first_.y + tile.region.y}, 0, threads_);
  {
    const std::scoped_lock guard(lock_);
    report_->add(frame);
    for (const auto& [stage, ms] : frame.timing_ms) radiometry::add_time(report_->timing_ms, stage, ms);
  }
  const mtf::ImageView<const float> output = frame.image.view();
  take(tile, {&output, 1}, counts_of(frame));
}

std::size_t ChainOfTiles::counts_a_tile() const { return chain_ ? counts_of({}).size() : 0; }

void ChainOfTiles::add(const mtf::io::TileCounts& counts) {
  if (!chain_) return;
  radiometry::ChainFrame frame;
  const auto places = counts_in(frame);
  for (std::size_t i = 0; i < counts.size(); ++i) *places[i] = counts[i];
  report_->add(frame);
}

}  // namespace apps
