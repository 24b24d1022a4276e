// SPDX-License-Identifier: Apache-2.0

// One frame through the chain: the order of chain.h, stage by stage.

#include <algorithm>
#include <chrono>
#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/chain_impl.h"
#include "radiometry/stages/detector/held_counter.h"

namespace radiometry {
namespace {

void filter(const mtf::Plan& plan, mtf::Image& image, double border_value, int threads) {
  std::vector<mtf::Image> planes;
  planes.push_back(std::move(image));
  image = std::move(mtf::run_in_place(plan, std::move(planes), border_value, threads).front());
}

/// Rows and columns, those that change and those that stay.
void add_line_noise(mtf::Image& image, const NoiseSettings& noise, const NoiseKey& key, Origin origin) {
  const NoiseKey fixed{key.seed, 0};
  if (noise.row_e > 0.0) add_row_noise(image.view(), noise.row_e, key, Stream::temporal_row, origin);
  if (noise.column_e > 0.0) add_column_noise(image.view(), noise.column_e, key, Stream::temporal_column, origin);
  if (noise.fixed_row_e > 0.0) add_row_noise(image.view(), noise.fixed_row_e, fixed, Stream::fixed_row, origin);
  if (noise.fixed_column_e > 0.0)
    add_column_noise(image.view(), noise.fixed_column_e, fixed, Stream::fixed_column, origin);
}

bool has_line_noise(const NoiseSettings& noise) {
  return noise.row_e > 0.0 || noise.column_e > 0.0 || noise.fixed_row_e > 0.0 || noise.fixed_column_e > 0.0;
}

}  // namespace

void multiply_add(mtf::Image& image, const Factor& gain, const Factor& offset, int threads) {
  const std::int64_t width = image.width();
  mtf::parallel_for(image.height(), 64, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      float* row = image.data() + y * width;
      const float* gains = gain.uniform() ? nullptr : gain.map.data() + y * width;
      const float* offsets = offset.uniform() ? nullptr : offset.map.data() + y * width;
      const auto g = static_cast<float>(gain.number), o = static_cast<float>(offset.number);
      if (gains == nullptr && offsets == nullptr)
        for (std::int64_t x = 0; x < width; ++x) row[x] = g * row[x] + o;
      else if (offsets == nullptr)
        for (std::int64_t x = 0; x < width; ++x) row[x] = gains[x] * row[x] + o;
      else if (gains == nullptr)
        for (std::int64_t x = 0; x < width; ++x) row[x] = g * row[x] + offsets[x];
      else
        for (std::int64_t x = 0; x < width; ++x) row[x] = gains[x] * row[x] + offsets[x];
    }
  });
}

/// The stages of one frame, each of which notes what it took.
struct Chain::Impl::Run {
  const Impl& chain;
  int threads;
  ChainFrame frame{};
  double border = 0.0;  ///< what a constant border is worth at this place of the chain
  HeldCounter counter{};
  std::chrono::steady_clock::time_point last = std::chrono::steady_clock::now();

  /// Times of a stage that runs for several positions add up.
  void lap(std::string_view stage) {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last).count();
    last = now;
    auto& all = frame.timing_ms;
    const auto known = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.first == stage; });
    if (known == all.end())
      all.emplace_back(stage, ms);
    else
      known->second += ms;
  }

  /// Scene radiance to radiance at the detector's samples.
  void optics(mtf::Image& image) {
    const SensorSettings& s = chain.settings;
    if (s.distortion) {
      const mtf::SampleGrid& grid = chain.plan.in();
      const FocalPlane scene =
          on_grid(chain.detector, chain.origin, grid.width, grid.height, grid.step_x_um, grid.step_y_um);
      mtf::Image moved(image.width(), image.height());
      distort(image.view(), *s.distortion, scene, moved.view(), {}, chain.plan.options.border,
              static_cast<float>(border), threads);
      image = std::move(moved);
      lap("distortion");
    }
    filter(chain.plan.presample, image, border, threads);
    border *= chain.plan.presample.dc();
    lap("presample");
    if (s.glare) {
      add_glare(image.view(), *s.glare, finite_mean(image.view()), threads);
      lap("veiling glare");
    }
    if (s.ghost) {
      const mtf::SampleGrid& grid = chain.plan.out();
      const FocalPlane samples =
          on_grid(chain.detector, chain.origin, grid.width, grid.height, grid.step_x_um, grid.step_y_um);
      const mtf::Image ghosts = ghost_image(image.view(), *s.ghost, samples);
      add_ghost(image.view(), *s.ghost, ghosts.view(), threads);
      lap("ghost");
    }
  }

  /// Radiance of a frame of the detector to mean electrons. Frames that were left out are time that has passed.
  void collect(mtf::Image& image, std::uint32_t number, ChainState* state) {
    const SensorSettings& s = chain.settings;
    const std::uint32_t steps = state != nullptr && state->last && number > *state->last ? number - *state->last : 1;
    if (s.shutter && state != nullptr) {
      if (steps > 1) state->shutter = {};
      apply_shutter(image.view(), *s.shutter, chain.frame_time_s, chain.detector.rows, state->shutter, chain.origin.y);
      lap("shutter");
    }
    multiply_add(image, chain.light, chain.glow, threads);
    border = chain.gain * border + chain.glow.number;
    lap("collect");
    if (s.lag && state != nullptr) {
      apply_lag(image.view(), *s.lag, steps * chain.frame_time_s, state->lag);
      lap("lag");
    }
    if (state != nullptr) state->last = number;
  }

  /// Mean electrons to what the readout gives.
  void detect(mtf::Image& image, const NoiseKey& key) {
    const SensorSettings& s = chain.settings;
    counter.begin(image);
    if (!chain.defects.empty()) apply_defects(image.view(), chain.defects);
    counter.mark(chain.defects);
    if (!chain.blinking.empty())
      counter.mark(apply_blinking(image.view(), chain.blinking, *s.blinking, key, chain.origin));
    counter.count(frame.held, frame.held_defects);
    if (s.defects || s.blinking) lap("defects");
    if (s.noise && s.noise->shot) {
      shot_noise(image.view(), key, chain.origin, threads);
      lap("shot");
    }
    const double well_e = chain.pixel.full_well_e;
    const auto hold_well = [&](const auto& stage) {
      const HeldCounter::Counts held =
          counter.run(image, [&](mtf::ImageView<float> electrons) { return stage(electrons, well_e, threads); });
      frame.well.high += held.all.high;
      frame.held.full_well += held.light().high;
      frame.held_defects.full_well += held.stuck.high;
    };
    if (s.blooming) {
      hold_well(above_well);
      const Spilled spilled = bloom(image.view(), *s.blooming, well_e, threads);
      frame.spilled.drained_e += spilled.drained_e;
      frame.spilled.left_e += spilled.left_e;
      lap("blooming");
    } else if (std::isfinite(well_e)) {
      hold_well(fill_well);
      lap("full well");
    }
    if (chain.response) {
      apply_response(image.view(), *chain.response, threads);
      lap("nonlinearity");
    }
    if (chain.plan.readout) {
      filter(*chain.plan.readout, image, border, threads);
      border *= chain.plan.readout->dc();
      lap("readout");
    }
    if (chain.offset.size() > 0) {
      add_map(image.view(), chain.offset.view());
      lap("offset");
    }
    if (s.noise && chain.read_e > 0.0) {
      add_gaussian(image.view(), chain.read_e, key, Stream::read, chain.origin, threads);
      lap("read");
    }
    if (s.flicker) {
      add_flicker(image.view(), *s.flicker, chain.detector.columns, chain.detector.rows, key, chain.origin, threads);
      lap("flicker");
    }
    if (s.noise && has_line_noise(*s.noise)) {
      add_line_noise(image, *s.noise, key, chain.origin);
      lap("rows and columns");
    }
    if (s.noise_3d) {
      add_noise_3d(image.view(), *s.noise_3d, key, chain.origin, threads);
      lap("3-D noise");
    }
  }

  void convert(mtf::Image& image) {
    if (!chain.adc) return;
    const HeldCounter::Counts held =
        counter.run(image, [&](mtf::ImageView<float> electrons) { return digitise(electrons, *chain.adc, threads); });
    frame.adc.low += held.all.low;
    frame.adc.high += held.all.high;
    const auto add = [](HeldPixels& sum, const Clipped& clipped) {
      sum.least_count += clipped.low;
      sum.most_count += clipped.high;
    };
    add(frame.held, held.light());
    add(frame.held_defects, held.stuck);
    border = border / chain.adc->electrons_per_count + chain.adc->offset_counts;
    lap("adc");
  }

  /// Where no flat frames can be had, a tenth of the scene or more may be saturated as well: the message names both.
  const TwoPoint& correction() const {
    try {
      return chain.correction(threads);
    } catch (const mtf::UsageError& refused) {
      if (frame.held.share() < 0.1) throw;
      throw mtf::UsageError(std::string(refused.what()) + ". The scene is saturated too: " + where_held(frame.held));
    }
  }

  void correct(mtf::Image& image) {
    if (!chain.settings.correction) return;
    const TwoPoint& maps = correction();
    lap("flat frames");
    radiometry::correct(image.view(), maps);
    if (chain.settings.correction->replace_bad && !maps.bad.empty()) replace_bad(image.view(), maps.bad);
    lap("correction");
  }

  /// One frame of the detector from radiance to a stage.
  void detector(mtf::Image& image, const NoiseKey& key, OutputStage stage, ChainState* state) {
    collect(image, key.frame, state);
    detect(image, key);
    if (stage == OutputStage::electrons) return;
    convert(image);
    if (stage == OutputStage::display) correct(image);
  }

  void positions(mtf::Image& image, const Microscan& scan, const NoiseKey& key, OutputStage stage) {
    const double border_here = border;
    std::vector<mtf::Image> frames;
    for (int k = 0; k < scan.positions(); ++k) {
      frames.push_back(microscan_frame(image.view(), scan, k));
      border = border_here;
      lap("microscan");
      detector(frames.back(), microscan_key(key, scan, k), stage, nullptr);
    }
    image = microscan_interlace(frames, scan);
    lap("microscan");
  }

  void display(mtf::Image& image) {
    if (chain.plan.post) {
      filter(*chain.plan.post, image, border, threads);
      lap("postsample");
    }
    if (const auto& agc = chain.settings.agc) {
      apply(image.view(), tone_curve(image.view(), *agc, threads), threads);
      if (agc->polarity == Polarity::black_hot) invert_polarity(image.view(), agc->most_level);
      lap("agc");
    }
  }
};

ChainFrame Chain::run(mtf::Image radiance, std::uint32_t number, OutputStage stage, double border_value, int threads,
                      ChainState* state) const {
  require_output_stage(stage, impl_->last, impl_->adc.has_value());
  Impl::Run run{*impl_, mtf::threads_of(threads)};
  run.border = border_value;
  mtf::Image& image = run.frame.image;
  image = std::move(radiance);
  run.optics(image);
  if (stage == OutputStage::radiance) return std::move(run.frame);
  if (stage == OutputStage::irradiance) {
    multiply_add(image, {.number = irradiance(impl_->camera, 1.0)}, {.number = 0.0}, run.threads);
    if (impl_->corners.size() > 0) {
      const std::int64_t steps = impl_->plan.samples_a_pitch;
      for (std::int64_t y = 0; y < image.height(); ++y)
        for (std::int64_t x = 0; x < image.width(); ++x) image.at(x, y) *= impl_->corners.at(x / steps, y / steps);
    }
    run.lap("irradiance");
    return std::move(run.frame);
  }
  const NoiseKey key{impl_->seed, number};
  if (impl_->settings.microscan)
    run.positions(image, *impl_->settings.microscan, key, stage);
  else
    run.detector(image, key, stage, state);
  if (stage == OutputStage::display) run.display(image);
  return std::move(run.frame);
}

void Chain::prepare(OutputStage stage, int threads) const {
  if (stage == OutputStage::display && impl_->settings.correction) impl_->correction(mtf::threads_of(threads));
}

const TwoPoint& Chain::Impl::correction(int threads) const {
  const Impl& owner = corrected_by ? *corrected_by : *this;
  std::call_once(owner.measured_once, [&] { owner.measured = owner.measure(threads); });
  return owner.measured;
}

TwoPoint Chain::Impl::measure(int threads) const {
  const std::int64_t steps = plan.samples_a_pitch;
  const auto flat = [&](double fill, std::uint32_t number, mtf::ImageView<float> out) {
    require_reachable(*settings.correction, fill, glow.number, pixel.full_well_e);
    Run run{*this, threads};
    run.border = (fill * pixel.full_well_e - glow.number) / gain;
    mtf::Image image(out.width, out.height);
    std::fill_n(image.data(), image.size(), static_cast<float>(run.border));
    run.detector(image, {seed, number}, OutputStage::dn, nullptr);
    require_unsaturated(*settings.correction, fill, run.frame.held);
    for (std::int64_t y = 0; y < out.height; ++y) std::copy_n(image.data() + y * out.width, out.width, out.row(y));
  };
  return measure_correction(plan.out().width / steps, plan.out().height / steps, *settings.correction, flat);
}

}  // namespace radiometry
