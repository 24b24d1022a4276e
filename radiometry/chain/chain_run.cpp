// SPDX-License-Identifier: Apache-2.0

// One frame through the chain: which parts of the table of stages run for an output, at which positions, and for the
// flat frames of the two-point correction.

#include <algorithm>
#include <utility>

#include "mtf/parallel.h"
#include "radiometry/chain/chain_impl.h"

namespace radiometry {
namespace {

using Part = StageRow::Part;

/// Turns the radiance of the detector's samples into the irradiance on them.
void cast_on_detector(FrameRun& run, mtf::Image& image) {
  const CompiledChain& chain = run.chain;
  const Linear& corners = run.maps.corners;
  multiply_add(image, {irradiance(chain.camera, 1.0) * corners.number, corners.map}, {0.0}, run.threads,
               chain.plan.samples_a_pitch);
  run.lap("irradiance");
}

/// Turns the radiance of the detector's samples into the power that its pixels absorb, less that of the shutter.
void absorb(FrameRun& run, mtf::Image& image) {
  const CompiledChain& chain = run.chain;
  cast_on_detector(run, image);
  std::vector<Directions<double>> light{chain.warm};
  if (chain.events) {
    light.push_back(warming_of(chain, run.number));
    const Directions<double> closed = last_closed(chain, run.number, run.state);
    light.push_back({-closed.cone_e, -closed.around_e});
  }
  double area_m2 = chain.pixel.area_m2() * chain.pixel.quantum_efficiency;
  for (const Directions<double>& volts : light) {
    const Directions<double> watts{volts.cone_e / chain.pixel.volts_per_watt,
                                   volts.around_e / chain.pixel.volts_per_watt};
    multiply_add(image, {std::exchange(area_m2, 1.0)}, glow_of(chain, watts, run.maps.corners, {}, 0.0, run.threads),
                 run.threads, chain.plan.samples_a_pitch);
  }
  run.lap("watts");
}

/// Takes one frame of the detector from radiance to an output stage.
void run_detector(FrameRun& run, mtf::Image& image, OutputStage stage) {
  run.counter.begin(image);
  run.run(Part::detector, image);
  run.counter.count(run.frame.held, run.frame.held_defects);
  for (const Part part : {Part::conversion, Part::correction})
    if (goes_through(part, stage)) run.run(part, image);
}

/// Runs the frames of the positions of [microscan] and puts them together.
void run_positions(FrameRun& run, mtf::Image& image, const Microscan& scan, OutputStage stage) {
  const double border = run.border;
  const NoiseKey key = run.key;
  std::vector<mtf::Image> frames;
  for (int k = 0; k < scan.positions(); ++k) {
    frames.push_back(microscan_frame(image.view(), scan, k));
    run.border = border;
    run.key = microscan_key(key, scan, k);
    run.lap("microscan");
    run_detector(run, frames.back(), stage);
  }
  image = microscan_interlace(frames, scan);
  run.lap("microscan");
}

/// Whether a row without noise changes no other one: nothing between the noise and the output takes anything from other
/// pixels, but for what replaces bad ones.
bool rows_stand_alone(const CompiledChain& chain, OutputStage output) {
  if (chain.settings.microscan) return false;
  return std::ranges::all_of(chain.stages, [&](const StageRow& stage) {
    return stage.whole_image.empty() || stage.part == Part::optics || stage.part == Part::correction ||
           !goes_through(stage.part, output);
  });
}

/// Whether a frame may stay on the device that filters it.
bool may_stay_on_device(const CompiledChain& chain) {
  return chain.plan.presample.report().on_device && !chain.settings.microscan &&
         chain.plan.options.device.device->info().doubles;
}

void require_stage(const CompiledChain& chain, OutputStage stage) {
  require_output_stage(stage, chain.last, chain.adc.has_value(), chain.settings.thermal.has_value());
}

void require_one_plane(const mtf::KeptScene& radiance) {
  if (radiance.planes().size() != 1)
    throw mtf::UsageError("the chain of a sensor takes one plane, not " + std::to_string(radiance.planes().size()));
}

}  // namespace

void multiply_add(mtf::Image& image, const Linear& gain, const Linear& offset, int threads, std::int64_t steps) {
  constexpr std::int64_t kRowsAtOnce = 64;
  const std::int64_t width = image.width();
  for (const SharedMap& map : {gain.map, offset.map})
    if (map && (map->width() * steps != width || map->height() * steps != image.height()))
      throw mtf::UsageError("a map of " + size_of(map->width(), map->height()) + " pixels for an image of " +
                            size_of(width, image.height()));
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
    const auto [of_gain, g, g0] = in_float(gain, false);
    const auto [of_offset, o, o0] = in_float(offset, true);
    for (std::int64_t y = begin; y < end; ++y) {
      const float *gains = row_of(of_gain, y, wide_gains), *offsets = row_of(of_offset, y, wide_offsets);
      float* row = image.data() + y * width;
      for (std::int64_t x = 0; x < width; ++x) row[x] = (g * gains[x] + g0) * row[x] + (o * offsets[x] + o0);
    }
  });
}

void FrameRun::lap(std::string_view stage) { add_time(frame.timing_ms, stage, std::exchange(watch, {}).ms()); }

void FrameRun::run(Part part, mtf::Image& image) {
  for (const StageRow& stage : chain.stages) {
    if (stage.part != part || (stage.in_sequence && state == nullptr)) continue;
    const auto own = maps.detector->of_stages.find(stage.name);
    map = own != maps.detector->of_stages.end() ? own->second : nullptr;
    if (on_device != nullptr && stage.step_on_device != nullptr &&
        (stage.stays == nullptr || frames() > 1 || stage.stays(*this))) {
      stage.step_on_device(*this, *on_device);
    } else {
      bring_back(image);
      stage.step(*this, image);
    }
    if (stage.border != nullptr) stage.border(*this);
    lap(on_device ? "device" : stage.timing);
  }
}

void FrameRun::bring_back(mtf::Image& image) {
  if (!on_device) return;
  std::vector<mtf::ImageView<float>> views{image.view()};
  while (std::ssize(views) < frames()) {
    ChainFrame& other = others.emplace_back();
    other.image = mtf::Image(image.width(), image.height());
    other.held = frame.held, other.held_defects = frame.held_defects;
    views.push_back(other.image.view());
  }
  const std::vector<mtf::DeviceImage::Held> pixels = on_device->download(views, threads);
  on_device.reset();
  given = {};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    ChainFrame& one = i == 0 ? frame : others[i - 1];
    const auto& [well, least, most] = pixels[i];
    one.well.high += well, one.held.full_well += well;
    one.adc.low += least, one.held.least_count += least;
    one.adc.high += most, one.held.most_count += most;
  }
  lap("device");
}

void FrameRun::run_to(OutputStage stage) {
  frame.held.volts = frame.held_defects.volts = chain.pixel.thermal();
  if (stage < OutputStage::electrons) bring_back(frame.image);
  if (stage == OutputStage::radiance) return;
  if (stage == OutputStage::irradiance) {
    cast_on_detector(*this, frame.image);
    return;
  }
  if (stage == OutputStage::watts) {
    absorb(*this, frame.image);
    return;
  }
  if (const auto& scan = chain.settings.microscan)
    run_positions(*this, frame.image, *scan, stage);
  else
    run_detector(*this, frame.image, stage);
  if (goes_through(Part::display, stage)) run(Part::display, frame.image);
  bring_back(frame.image);
}

ChainFrame Chain::run(mtf::Image radiance, std::uint32_t number, OutputStage stage, double border_value, int threads,
                      ChainState* state, bool whole_levels) const {
  return run_scene(std::move(radiance), nullptr, number, stage, border_value, threads, state, 1, whole_levels);
}

ChainFrame Chain::run(mtf::KeptScene& radiance, std::uint32_t number, OutputStage stage, double border_value,
                      int threads, ChainState* state, std::int64_t noise_rows, bool whole_levels) const {
  require_one_plane(radiance);
  return run_scene({}, &radiance, number, stage, border_value, threads, state, noise_rows, whole_levels);
}

ChainFrame Chain::run_scene(mtf::Image radiance, mtf::KeptScene* kept, std::uint32_t number, OutputStage stage,
                            double border_value, int threads, ChainState* state, std::int64_t noise_rows,
                            bool whole_levels) const {
  require_stage(*compiled_, stage);
  const mtf::DeviceChoice& device = compiled_->plan.options.device;
  const std::optional<std::uint32_t> last = state != nullptr ? state->last : std::nullopt;
  const auto made = [&](bool on_device) {
    if (state != nullptr) state->last = last;
    FrameRun run{.chain = *compiled_,
                 .maps = *compiled_->maps,
                 .threads = mtf::threads_of(threads),
                 .key = {compiled_->seed, number},
                 .number = number,
                 .kept = kept,
                 .border = border_value,
                 .whole_levels = whole_levels};
    run.may_stay = on_device;
    if (!on_device && rows_stand_alone(*compiled_, stage)) run.noise_rows = std::max<std::int64_t>(1, noise_rows);
    run.frame.image = std::move(radiance);
    try {
      run.run(Part::optics, run.frame.image);
      if (state != nullptr && stage >= OutputStage::watts) {
        run.state = state;
        if (state->last && number > *state->last) run.frames_passed = number - *state->last;
        state->last = number;
      }
      run.run_to(stage);
    } catch (...) {
      radiance = std::move(run.given);
      throw;
    }
    return std::move(run.frame);
  };
  const bool moves = compiled_->settings.distortion && kept == nullptr;
  // A frame comes back before a stage that remembers changes its state: it can be made once more by the processor.
  try {
    return made(may_stay_on_device(*compiled_) && !moves);
  } catch (const mtf::DeviceError&) {
    if (device.insisted) throw;
  }
  return made(false);
}

std::int64_t Chain::batch_size(OutputStage stage) const {
  constexpr std::int64_t kFrames = 16;
  const CompiledChain& chain = *compiled_;
  const FrameRun run{.chain = chain, .maps = *chain.maps, .threads = 1};
  const auto stays = [&](const StageRow& row) {
    if (row.part == Part::optics) return row.name == "presample";
    if (row.in_sequence || !goes_through(row.part, stage)) return true;
    return row.step_on_device != nullptr && (row.stays == nullptr || row.stays(run));
  };
  if (!may_stay_on_device(chain) || stage < OutputStage::electrons || chain.settings.distortion || chain.events ||
      !std::ranges::all_of(chain.stages, stays))
    return 1;
  std::int64_t frames = kFrames;
  const mtf::SampleGrid& out = chain.plan.out();
  while (frames > 1 &&
         !mtf::DeviceImage::has_room(chain.plan.options.device.device->info(), out.width, out.height, frames))
    frames /= 2;
  return frames;
}

std::vector<ChainFrame> Chain::run_batch(mtf::KeptScene& radiance, const Batch& batch, OutputStage stage,
                                         double border_value, int threads, bool whole_levels) const {
  require_one_plane(radiance);
  require_stage(*compiled_, stage);
  std::vector<ChainFrame> frames;
  if (batch.count > 1 && batch_size(stage) > 1) try {
      FrameRun run{.chain = *compiled_,
                   .maps = *compiled_->maps,
                   .threads = mtf::threads_of(threads),
                   .key = {compiled_->seed, batch.first},
                   .number = batch.first,
                   .kept = &radiance,
                   .border = border_value,
                   .whole_levels = whole_levels,
                   .may_stay = true};
      run.run(Part::optics, run.frame.image);
      if (run.on_device) {
        run.on_device->repeat(batch.count, batch.step);
        run.run_to(stage);
        frames = std::move(run.others);
        frames.insert(frames.begin(), std::move(run.frame));
        for (auto& [name, ms] : frames.front().timing_ms) ms /= static_cast<double>(batch.count);
        for (ChainFrame& frame : frames) frame.timing_ms = frames.front().timing_ms;
      }
    } catch (const mtf::DeviceMemoryError&) {  // it may have room for one at a time
    } catch (const mtf::DeviceError&) {
      if (compiled_->plan.options.device.insisted) throw;
    }
  for (std::int64_t i = std::ssize(frames); i < batch.count; ++i)
    frames.push_back(run(radiance, batch.first + static_cast<std::uint32_t>(i) * batch.step, stage, border_value,
                         threads, nullptr, 1, whole_levels));
  return frames;
}

void Chain::prepare(OutputStage stage, int threads) const {
  if (stage == OutputStage::display && compiled_->settings.correction) compiled_->correction(mtf::threads_of(threads));
}

std::shared_ptr<const TwoPoint> CompiledChain::correction(int threads) const {
  const CompiledChain& owner = corrected_by ? *corrected_by : *this;
  // Not std::call_once: what ends the measurement (mtf::Stopped) cannot leave it, glibc aborts the program.
  const std::scoped_lock lock(owner.measuring);
  if (!owner.measured) owner.measured = std::make_shared<const TwoPoint>(owner.measure(threads));
  return owner.measured;
}

std::shared_ptr<const TwoPoint> CompiledChain::known_correction() const {
  const CompiledChain& owner = corrected_by ? *corrected_by : *this;
  const std::unique_lock lock(owner.measuring, std::try_to_lock);
  return lock ? owner.measured : nullptr;
}

TwoPoint CompiledChain::measure(int threads) const {
  const std::int64_t steps = plan.samples_a_pitch;
  CorrectionSettings flats = *settings.correction;
  if (settings.thermal) flats.low = 0.0, flats.high = 1.0;
  const auto radiance_of = [&](double fill) {
    if (settings.thermal)
      return scene_radiance(curves, {.temperature_k = fill == flats.low ? *flats.cold_k : *flats.hot_k}, {});
    require_reachable(flats, fill, glow_e(), pixel.full_well_e);
    return (fill * pixel.full_well_e - glow_e()) / gain;
  };
  HeldPixels saturated{.volts = settings.thermal.has_value()};
  const auto flat = [&](double fill, std::uint32_t number, mtf::ImageView<float> out) {
    FrameRun run{.chain = *this, .maps = *maps, .threads = threads, .key = {seed, number}, .border = radiance_of(fill)};
    mtf::Image image(out.width, out.height);
    std::fill_n(image.data(), image.size(), static_cast<float>(run.border));
    run_detector(run, image, OutputStage::dn);
    require_unsaturated(flats, fill, run.frame.held);
    saturated += run.frame.held;
    copy(image.view(), out);
  };
  TwoPoint correction = measure_correction(plan.out().width / steps, plan.out().height / steps, flats, flat);
  correction.saturated = saturated;
  return correction;
}

}  // namespace radiometry
