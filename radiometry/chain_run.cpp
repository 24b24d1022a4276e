// SPDX-License-Identifier: Apache-2.0

// One frame through the chain: the order of chain.h, stage by stage.

#include <algorithm>
#include <chrono>
#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/chain_impl.h"

namespace radiometry {
namespace {

/// Notes what each stage took.
class Laps {
 public:
  explicit Laps(ChainFrame& frame) : frame_(frame) {}
  void lap(std::string_view stage) {
    const auto now = std::chrono::steady_clock::now();
    frame_.timing_ms.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
    last_ = now;
  }

 private:
  ChainFrame& frame_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void filter(const mtf::Plan& plan, mtf::Image& image, double border_value, int threads) {
  std::vector<mtf::Image> planes;
  planes.push_back(std::move(image));
  image = std::move(mtf::run_in_place(plan, std::move(planes), border_value, threads).front());
}

/// image = light x image + glow, electrons of weighted radiance.
void collect(mtf::Image& image, const Factor& light, const Factor& glow, int threads) {
  const std::int64_t width = image.width();
  mtf::parallel_for(image.height(), 64, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      float* row = image.data() + y * width;
      const float* gains = light.uniform() ? nullptr : light.map.data() + y * width;
      const float* offsets = glow.uniform() ? nullptr : glow.map.data() + y * width;
      const auto gain = static_cast<float>(light.number), offset = static_cast<float>(glow.number);
      if (gains == nullptr && offsets == nullptr)
        for (std::int64_t x = 0; x < width; ++x) row[x] = gain * row[x] + offset;
      else if (offsets == nullptr)
        for (std::int64_t x = 0; x < width; ++x) row[x] = gains[x] * row[x] + offset;
      else if (gains == nullptr)
        for (std::int64_t x = 0; x < width; ++x) row[x] = gain * row[x] + offsets[x];
      else
        for (std::int64_t x = 0; x < width; ++x) row[x] = gains[x] * row[x] + offsets[x];
    }
  });
}

void scale(mtf::Image& image, double factor, int threads) {
  collect(image, {.number = factor, .map = {}}, {.number = 0.0, .map = {}}, threads);
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

ChainFrame Chain::run(mtf::Image radiance, std::uint32_t number, Tap tap, double border_value, int threads) const {
  const Impl& impl = *impl_;
  const SensorSettings& settings = impl.settings;
  if (tap > last())
    throw mtf::UsageError("tap " + std::string(kTapNames[static_cast<std::size_t>(tap)]) +
                          ": this sensor has no such stage; its last one is " +
                          std::string(kTapNames[static_cast<std::size_t>(last())]));
  const int cores = mtf::threads_of(threads);
  ChainFrame frame;
  frame.image = std::move(radiance);
  mtf::Image& image = frame.image;
  Laps laps(frame);

  filter(impl.plan.presample, image, border_value, threads);
  double border = impl.plan.presample.dc() * border_value;
  laps.lap("presample");
  if (tap == Tap::radiance) return frame;

  if (tap == Tap::irradiance) {
    scale(image, irradiance(impl.camera, 1.0), threads);
    laps.lap("irradiance");
    return frame;
  }

  collect(image, impl.light, impl.glow, threads);
  border = impl.light.number * border + impl.glow.number;
  if (!impl.defects.empty()) apply_defects(image.view(), impl.defects);
  laps.lap("collect");

  const NoiseKey key{settings.noise ? static_cast<std::uint64_t>(settings.noise->seed) : 0, number};
  if (settings.noise && settings.noise->shot) {
    shot_noise(image.view(), key, impl.origin, cores);
    laps.lap("shot");
  }
  if (std::isfinite(impl.pixel.full_well_e)) {
    frame.well = fill_well(image.view(), impl.pixel.full_well_e, cores);
    laps.lap("full well");
  }
  if (impl.plan.readout) {
    filter(*impl.plan.readout, image, border, threads);
    border *= impl.plan.readout->dc();
    laps.lap("readout");
  }
  if (impl.offset.size() > 0) {
    add_map(image.view(), impl.offset.view());
    laps.lap("offset");
  }
  if (settings.noise) {
    const DetectorSettings& detector = *settings.detector;
    if (const double rms = std::hypot(detector.read_e, detector.reset_e, detector.other_e); rms > 0.0) {
      add_gaussian(image.view(), rms, key, Stream::read, impl.origin, cores);
      laps.lap("read");
    }
    if (has_line_noise(*settings.noise)) {
      add_line_noise(image, *settings.noise, key, impl.origin);
      laps.lap("rows and columns");
    }
  }
  if (settings.noise_3d) {
    add_noise_3d(image.view(), *settings.noise_3d, key, impl.origin, cores);
    laps.lap("3-D noise");
  }
  if (tap == Tap::electrons) return frame;

  if (impl.adc) {
    frame.adc = digitise(image.view(), *impl.adc, cores);
    border = border / impl.adc->electrons_per_count + impl.adc->offset_counts;
    laps.lap("adc");
  }
  if (tap == Tap::dn) return frame;

  if (impl.plan.post) {
    filter(*impl.plan.post, image, border, threads);
    laps.lap("postsample");
  }
  if (settings.agc) {
    apply(image.view(), tone_curve(image.view(), *settings.agc), cores);
    laps.lap("agc");
  }
  return frame;
}

}  // namespace radiometry
