// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain/chain_steps.h"

#include <span>
#include <utility>

#include "mtf/parallel.h"

namespace radiometry {
namespace {

void filter(const mtf::Plan& plan, FrameRun& run, mtf::Image& image) {
  std::vector<mtf::Image> planes;
  planes.push_back(std::move(image));
  image = std::move(mtf::run_in_place(plan, std::move(planes), run.border, run.threads).front());
}

FocalPlane focal_plane_of(const FrameRun& run, const mtf::SampleGrid& grid) {
  return on_grid(run.chain.detector, run.maps.origin(), grid.width, grid.height, grid.step_x_um, grid.step_y_um);
}

/// Limits the charge and counts the pixels that are held. `limit` is fill_well or above_well.
template <class Limit>
void hold_well(FrameRun& run, mtf::Image& image, const Limit& limit) {
  const HeldCounter::Counts held = run.counter.run(image, [&](mtf::ImageView<float> electrons) {
    return limit(electrons, run.chain.pixel.full_well_e, run.threads);
  });
  run.frame.well.high += held.all.high;
  run.frame.held.full_well += held.light().high;
  run.frame.held_defects.full_well += held.stuck.high;
}

/// Adds light of the camera itself to a frame of volts.
void add_glow(FrameRun& run, mtf::Image& image, const Directions<double>& light) {
  if (light.cone_e == 0.0 && light.around_e == 0.0) return;
  multiply_add(image, {},
               glow_of(run.chain, light, run.maps.corners, run.maps.detector->responsivity, 0.0, run.threads),
               run.threads);
  run.border += light.total_e();
}

/// Where no flat frames can be made, a tenth of the scene or more may be saturated as well; the message names both.
const TwoPoint& correction_of(const FrameRun& run) {
  try {
    return run.chain.correction(run.threads);
  } catch (const mtf::UsageError& refused) {
    const HeldPixels& held = run.frame.held;
    if (held.share() < 0.1) throw;
    throw mtf::UsageError(std::string(refused.what()) + ". The scene is saturated too: " + where_held(held));
  }
}

}  // namespace

void multiply_add(mtf::Image& image, const Linear& gain, const Linear& offset, int threads, std::int64_t steps) {
  constexpr std::int64_t kRowsAtOnce = 64;
  const std::int64_t width = image.width();
  for (const SharedMap& map : {gain.map, offset.map})
    if (map && (map->width() * steps != width || map->height() * steps != image.height()))
      throw mtf::UsageError("a map of " + std::to_string(map->width()) + " x " + std::to_string(map->height()) +
                            " pixels for an image of " + std::to_string(width) + " x " +
                            std::to_string(image.height()));
  const std::vector<float> ones(static_cast<std::size_t>(width), 1.0F);
  mtf::parallel_for(image.height(), kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> wide_gains, wide_offsets;
    // A row of a map, as wide as the image.
    const auto row_of = [&](const SharedMap& map, std::int64_t y, std::vector<float>& wide) {
      if (!map) return ones.data();
      const float* row = map->data() + y / steps * map->width();
      if (steps == 1) return row;
      wide.resize(static_cast<std::size_t>(width));
      for (std::int64_t x = 0; x < width; ++x) wide[static_cast<std::size_t>(x)] = row[x / steps];
      return std::as_const(wide).data();
    };
    const auto g = static_cast<float>(gain.number), g0 = static_cast<float>(gain.added);
    const auto o = static_cast<float>(offset.map ? offset.number : offset.number + offset.added),
               o0 = static_cast<float>(offset.map ? offset.added : 0.0);
    for (std::int64_t y = begin; y < end; ++y) {
      const float *gains = row_of(gain.map, y, wide_gains), *offsets = row_of(offset.map, y, wide_offsets);
      float* row = image.data() + y * width;
      for (std::int64_t x = 0; x < width; ++x) row[x] = (g * gains[x] + g0) * row[x] + (o * offsets[x] + o0);
    }
  });
}

namespace step {

void distort(FrameRun& run, mtf::Image& scene) {
  const CompiledChain& chain = run.chain;
  const mtf::Image& given = run.kept != nullptr ? run.kept->planes().front() : scene;
  mtf::Image moved(given.width(), given.height());
  radiometry::distort(given.view(), *chain.settings.distortion, focal_plane_of(run, chain.plan.in()), moved.view(), {},
                      chain.plan.options.border, static_cast<float>(run.border), run.threads);
  scene = std::move(moved);
  run.kept = nullptr;
}

void sample(FrameRun& run, mtf::Image& scene) {
  const mtf::Plan& plan = run.chain.plan.presample;
  if (run.kept != nullptr) {
    scene = mtf::Image(plan.out().width, plan.out().height);
    const mtf::ImageView<float> out = scene.view();
    plan.run(*std::exchange(run.kept, nullptr), std::span(&out, 1), run.border, run.threads);
  } else {
    filter(plan, run, scene);
  }
  run.border *= plan.dc();
}

void glare(FrameRun& run, mtf::Image& radiance) {
  const double mean = finite_mean(radiance.view());
  add_glare(radiance.view(), *run.chain.settings.glare, mean, run.threads);
  mtf::Image beyond(1, 1);
  beyond.at(0, 0) = static_cast<float>(run.border);
  add_glare(beyond.view(), *run.chain.settings.glare, mean, 1);
  run.border = beyond.at(0, 0);
}

void ghost(FrameRun& run, mtf::Image& radiance) {
  const Ghost& ghost = *run.chain.settings.ghost;
  const mtf::Image mirrored = ghost_image(radiance.view(), ghost, focal_plane_of(run, run.chain.plan.out()));
  add_ghost(radiance.view(), ghost, mirrored.view(), run.threads);
}

void shutter(FrameRun& run, mtf::Image& radiance) {
  const CompiledChain& chain = run.chain;
  ShutterState& state = run.state->shutter;
  if (run.frames_passed > 1) state = {};
  apply_shutter(radiance.view(), *chain.settings.shutter, chain.frame_time_s, chain.detector.rows, state,
                run.maps.origin().y);
}

void collect(FrameRun& run, mtf::Image& image) {
  const CompiledChain& chain = run.chain;
  multiply_add(image, run.maps.light, run.maps.glow, run.threads);
  run.border = chain.gain * run.border + chain.glow_e();
  if (chain.events) add_glow(run, image, warming_of(chain, run.number));
}

void shutter_offset(FrameRun& run, mtf::Image& volts) {
  const Directions<double> closed = last_closed(run.chain, run.number, run.state);
  add_glow(run, volts, {-closed.cone_e, -closed.around_e});
}

void lag(FrameRun& run, mtf::Image& electrons) {
  apply_lag(electrons.view(), *run.chain.settings.lag, run.frames_passed * run.chain.frame_time_s, run.state->lag);
}

void defects(FrameRun& run, mtf::Image& electrons) {
  apply_defects(electrons.view(), run.maps.detector->defects);
  run.counter.mark(run.maps.detector->defects);
}

void blinking(FrameRun& run, mtf::Image& electrons) {
  const CompiledChain& chain = run.chain;
  run.counter.mark(apply_blinking(electrons.view(), run.maps.detector->blinking, *chain.settings.blinking, run.key,
                                  run.maps.origin()));
}

void shot_noise(FrameRun& run, mtf::Image& electrons) {
  radiometry::shot_noise(electrons.view(), run.key, run.maps.origin(), run.threads, run.noise_rows);
  run.frame.noise_rows = run.noise_rows;
}

void full_well(FrameRun& run, mtf::Image& electrons) {
  hold_well(run, electrons, fill_well);
  run.border = std::min(run.border, run.chain.pixel.full_well_e);
}

void blooming(FrameRun& run, mtf::Image& electrons) {
  hold_well(run, electrons, above_well);
  const Spilled spilled =
      bloom(electrons.view(), *run.chain.settings.blooming, run.chain.pixel.full_well_e, run.threads);
  run.frame.spilled.drained_e += spilled.drained_e;
  run.frame.spilled.left_e += spilled.left_e;
}

void nonlinearity(FrameRun& run, mtf::Image& electrons) {
  apply_response(electrons.view(), *run.chain.response, run.threads);
  run.border = (*run.chain.response)(run.border);
}

void readout(FrameRun& run, mtf::Image& electrons) {
  filter(*run.chain.plan.readout, run, electrons);
  run.border *= run.chain.plan.readout->dc();
}

void offsets(FrameRun& run, mtf::Image& electrons) {
  add_map(electrons.view(), run.maps.detector->offset.view(), run.threads);
}

void read_noise(FrameRun& run, mtf::Image& electrons) {
  add_gaussian(electrons.view(), run.chain.read_e, run.key, Stream::read, run.maps.origin(), run.threads,
               run.noise_rows);
  if (run.chain.slow.strength > 0.0)
    add_frame_flicker(electrons.view(), run.chain.slow, run.key, run.maps.origin(), run.threads, run.noise_rows);
  run.frame.noise_rows = run.noise_rows;
}

void flicker(FrameRun& run, mtf::Image& electrons) {
  const CompiledChain& chain = run.chain;
  add_flicker(electrons.view(), *chain.settings.flicker, chain.detector.columns, chain.detector.rows, run.key,
              run.maps.origin(), run.threads);
}

void line_noise(FrameRun& run, mtf::Image& electrons) {
  const NoiseSettings& noise = *run.chain.settings.noise;
  const NoiseKey fixed{run.key.seed, 0};
  const auto rows = [&](double rms_e, const NoiseKey& key, Stream stream) {
    if (rms_e > 0.0) add_row_noise(electrons.view(), rms_e, key, stream, run.maps.origin());
  };
  const auto columns = [&](double rms_e, const NoiseKey& key, Stream stream) {
    if (rms_e > 0.0) add_column_noise(electrons.view(), rms_e, key, stream, run.maps.origin());
  };
  rows(noise.row_e, run.key, Stream::temporal_row);
  columns(noise.column_e, run.key, Stream::temporal_column);
  rows(noise.fixed_row_e, fixed, Stream::fixed_row);
  columns(noise.fixed_column_e, fixed, Stream::fixed_column);
}

void noise_3d(FrameRun& run, mtf::Image& electrons) {
  add_noise_3d(electrons.view(), *run.chain.settings.noise_3d, run.key, run.maps.origin(), run.threads);
}

void convert(FrameRun& run, mtf::Image& electrons) {
  const Adc& adc = *run.chain.adc;
  const HeldCounter::Counts held =
      run.counter.run(electrons, [&](mtf::ImageView<float> values) { return digitise(values, adc, run.threads); });
  run.frame.adc.low += held.all.low;
  run.frame.adc.high += held.all.high;
  const auto add = [](HeldPixels& sum, const Clipped& clipped) {
    sum.least_count += clipped.low;
    sum.most_count += clipped.high;
  };
  add(run.frame.held, held.light());
  add(run.frame.held_defects, held.stuck);
  run.border = run.border / adc.electrons_per_count + adc.offset_counts;
}

void correct(FrameRun& run, mtf::Image& counts) {
  const TwoPoint& maps = correction_of(run);
  run.lap("flat frames");
  radiometry::correct(counts.view(), maps, run.threads);
  if (run.chain.settings.correction->replace_bad && !maps.bad.empty()) replace_bad(counts.view(), maps.bad);
}

void postsample(FrameRun& run, mtf::Image& image) { filter(*run.chain.plan.post, run, image); }

void agc(FrameRun& run, mtf::Image& image) {
  const AutomaticGain& agc = *run.chain.settings.agc;
  apply(image.view(), tone_curve(image.view(), agc, run.threads), run.threads);
  if (agc.polarity == Polarity::black_hot) invert_polarity(image.view(), agc.most_level);
}

}  // namespace step
}  // namespace radiometry
