// SPDX-License-Identifier: Apache-2.0

// The test that admits a device, and the times by which a plan reckons.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "mtf/device/device_filter.h"
#include "mtf/device/device_image.h"
#include "mtf/device/device_parts.h"
#include "mtf/device/device_taps.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "mtf/work/stopwatch.h"

namespace mtf {
namespace {

namespace host {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"  // the only casts of C
#include "mtf/device/kernels.cl"
#pragma GCC diagnostic pop
}  // namespace host

constexpr double kMostRms = 3e-7;
constexpr std::int64_t kInputs = 256;  // of kBitsOfInput numbers, four of them random words: 1,024

/// A filter of the test and its scene.
struct Trial {
  AxisTransform x, y;
  double blur_um = 0.0, shift_um = 0.0;  ///< a Gaussian, and with a shift an OTF with phase
  double border_value = 0.0;

  Complex<double> otf(double fx_cy_mm, double fy_cy_mm) const {
    const double a = 2e-3 * blur_um * blur_um * 1e-3 * M_PI * M_PI;
    const double modulus = std::exp(-a * (fx_cy_mm * fx_cy_mm + fy_cy_mm * fy_cy_mm));
    const Complex<double> phase = rotation(-1e-3L * static_cast<long double>(shift_um * (fx_cy_mm - 0.5 * fy_cy_mm)));
    return {modulus * phase.re, modulus * phase.im};
  }
};

AxisTransform trial_axis(std::int64_t samples, std::int64_t length, std::int64_t ratio, Border border) {
  AxisTransform job;
  job.frequency = {Basis::fourier, length, 1.0};
  job.border = border;
  job.samples = samples;
  job.pitch_um = static_cast<double>(ratio);
  job.outputs = samples / ratio;
  job.out_length = length / ratio;
  job.keep = job.frequency.half_count();
  return job;
}

// Mixed factors, a border, aliases and phase; powers of two.
std::array<Trial, 2> trials() {
  return {
      Trial{trial_axis(100, 120, 2, Border::constant), trial_axis(84, 96, 2, Border::constant), 1.1, 0.3, 0.9},
      Trial{trial_axis(1024, 1024, 1, Border::periodic), trial_axis(1024, 1024, 1, Border::periodic), 1.5, 0.0, 0.0}};
}

constexpr float kMean = 0.5F;

/// Noise between 0 and 1, from the words that are tested first.
Image scene_of(const Trial& trial) {
  Image scene(trial.x.samples, trial.y.samples);
  for (std::int64_t i = 0; i < scene.size(); ++i)
    scene.data()[i] = 0x1p-24F * static_cast<float>(host::philox(static_cast<host::u32>(i), 5, 0, 0, 1, 2).x >> 8);
  return scene;
}

DeviceOtf otf_of(const Trial& trial) {
  DeviceOtf otf;
  otf.complex = trial.shift_um != 0.0;
  for (const std::int64_t ky : otf_frequencies(trial.y))
    for (std::int64_t kx = 0; kx < trial.x.keep; ++kx) {
      const Complex<double> h = trial.otf(trial.x.frequency.cy_mm(kx), trial.y.frequency.cy_mm(ky));
      otf.values.push_back(static_cast<float>(h.re));
      if (otf.complex) otf.values.push_back(static_cast<float>(h.im));
    }
  return otf;
}

using Plane = std::vector<Complex<double>>;

void transform(Plane& plane, std::int64_t width, std::int64_t height, bool forward) {
  const fft::ComplexDouble along_x(width, forward), along_y(height, forward);
  for (std::int64_t y = 0; y < height; ++y) along_x.execute(plane.data() + y * width);
  AlignedBuffer<Complex<double>> column(static_cast<std::size_t>(height));
  for (std::int64_t x = 0; x < width; ++x) {
    for (std::int64_t y = 0; y < height; ++y)
      column[static_cast<std::size_t>(y)] = plane[static_cast<std::size_t>(y * width + x)];
    along_y.execute(column.data());
    for (std::int64_t y = 0; y < height; ++y)
      plane[static_cast<std::size_t>(y * width + x)] = column[static_cast<std::size_t>(y)];
  }
}

/// The filtered scene less its mean, in double: on the whole canvas, of which pixels are then picked.
std::vector<double> expected_of(const Trial& trial, const Image& scene) {
  const std::int64_t width = trial.x.frequency.length, height = trial.y.frequency.length;
  const std::vector<std::int64_t> from_x = canvas_sources(trial.x), from_y = canvas_sources(trial.y);
  Plane canvas(static_cast<std::size_t>(width * height));
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) {
      const std::int64_t sx = from_x[static_cast<std::size_t>(x)], sy = from_y[static_cast<std::size_t>(y)];
      const double value = sx < 0 || sy < 0 ? trial.border_value : static_cast<double>(scene.at(sx, sy));
      canvas[static_cast<std::size_t>(y * width + x)].re = value - static_cast<double>(kMean);
    }
  transform(canvas, width, height, true);
  Plane filtered(canvas.size());
  const std::vector<Term> terms_x = axis_terms(trial.x, Parity::even), terms_y = axis_terms(trial.y, Parity::even);
  for (const Term& b : terms_y)
    for (const Term& a : terms_x) {
      const auto at = static_cast<std::size_t>(b.source * width + a.source);
      const Complex<double> h = trial.otf(trial.x.frequency.cy_mm(a.k), trial.y.frequency.cy_mm(b.k));
      filtered[at] = filtered[at] + canvas[at] * h * Complex<double>{a.re, a.im} * Complex<double>{b.re, b.im};
    }
  transform(filtered, width, height, false);
  std::vector<double> pixels;
  const std::int64_t step_x = width / trial.x.out_length, step_y = height / trial.y.out_length;
  for (std::int64_t y = 0; y < trial.y.outputs; ++y)
    for (std::int64_t x = 0; x < trial.x.outputs; ++x)
      pixels.push_back(filtered[static_cast<std::size_t>(y * step_y * width + x * step_x)].re /
                       (static_cast<double>(width) * static_cast<double>(height)));
  return pixels;
}

void require_same_bits(Device::Parts& parts) {
  const std::scoped_lock lock(parts.lock);
  std::vector<std::uint32_t> bits(static_cast<std::size_t>(kInputs) * kBitsOfInput);
  const auto memory = parts.backend->allocate(bits.size() * sizeof bits[0]);
  const std::array<KernelArgument, 2> arguments{memory, static_cast<std::int32_t>(kInputs)};
  parts.backend->launch(parts.queue, "bits", {kInputs, 1, 1}, arguments);
  parts.backend->download(parts.queue, *memory, bits.data(), memory->bytes);
  parts.backend->finish(parts.queue);
  if (parts.fault == DeviceFault::words) bits[kBitsOfInput * 17] ^= 1;
  const std::vector<std::uint32_t> expected = bits_on_host(kInputs);
  constexpr std::array kWhat{"random words", "random words", "random words", "random words", "logarithms",
                             "cosines",      "sines",        "fused sums",   "square roots", "sums in double"};
  constexpr std::size_t kSingle = 8;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (bits[i] == expected[i]) continue;
    if (i % kBitsOfInput < kSingle)
      throw DeviceError(std::string("its ") + kWhat[i % kBitsOfInput] + " are not the processor's to the bit");
    parts.info.doubles = false;  // frames of a chain come back after the filter
  }
}

/// Where the device does not run the largest kernel of a chain, frames come back after the filter.
void try_pixels(const std::shared_ptr<const Device>& device) {
  Device::Parts& parts = device->parts();
  if (!parts.info.doubles) return;
  try {
    Image image(32, 8);
    DeviceImage there(device, image.width(), image.height(), std::unique_lock(parts.lock));
    there.multiply_add({{}, 0.0F}, {{}, 100.0F});
    there.shot_noise({});
    there.download(image.view(), 1);
  } catch (const DeviceError&) {
    parts.info.doubles = parts.lost = false;
    parts.failure.reset();
  }
}

/// The rms error relative to the scene's std.
double error_of(const Trial& trial, const Image& scene, const Image& image) {
  const std::vector<double> expected = expected_of(trial, scene);
  double squares = 0.0, about_mean = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double pixel = static_cast<double>(image.data()[i]) - static_cast<double>(kMean);
    squares += (pixel - expected[i]) * (pixel - expected[i]);
  }
  for (std::int64_t i = 0; i < scene.size(); ++i)
    about_mean += std::pow(static_cast<double>(scene.data()[i]) - static_cast<double>(kMean), 2);
  return std::sqrt(squares / static_cast<double>(image.size()) / (about_mean / static_cast<double>(scene.size())));
}

/// A rhombus of 41 taps on a scene, against the processor's sums, and its time.
void try_taps(const std::shared_ptr<const Device>& device, const Image& scene) {
  Device::Parts& parts = device->parts();
  constexpr std::int64_t kHalf = 4, kCount = 2 * kHalf + 1, kUsed = 2 * kHalf * (kHalf + 1) + 1;
  const TapAxis x{scene.width(), scene.width(), 1, -kHalf, kCount},
      y{scene.height(), scene.height(), 1, -kHalf, kCount};
  std::vector<float> taps;
  for (std::int64_t r = -kHalf; r <= kHalf; ++r)
    for (std::int64_t t = -kHalf; t <= kHalf; ++t)
      taps.push_back(std::abs(r) + std::abs(t) > kHalf ? 0.0F
                                                       : static_cast<float>(1 + (5 * r + 3 * t + 100) % 7) / 164.0F);
  Image image(scene.width(), scene.height()), expected(scene.width(), scene.height());
  const auto channel_to = [&](Image& out) {
    return Channel{.in = scene.view(), .out = out.view(), .mean = static_cast<double>(kMean)};
  };
  make_direct_engine(x, y, Border::reflect, taps)->run({channel_to(expected)}, 1);
  const auto there = make_device_taps(device, x, y, Border::reflect, taps);
  double least = std::numeric_limits<double>::infinity(), squares = 0.0, about_mean = 0.0;
  parts.kernels_ms = 0.0;
  for (int i = 0; i < 3; ++i) {
    there->run({channel_to(image)}, 1);
    least = std::min(least, *parts.kernels_ms);
  }
  parts.kernels_ms.reset();
  parts.tap_ns = 1e6 * least / static_cast<double>(kUsed * scene.size());
  for (std::int64_t i = 0; i < scene.size(); ++i) {
    squares += std::pow(static_cast<double>(image.data()[i]) - static_cast<double>(expected.data()[i]), 2);
    about_mean += std::pow(static_cast<double>(scene.data()[i]) - static_cast<double>(kMean), 2);
  }
  if (const double rms = std::sqrt(squares / about_mean); !(rms <= kMostRms))
    throw DeviceError("its sums of " + std::to_string(kUsed) + " samples differ from the processor's by " +
                      significant(rms, 2) + " of their standard deviation, rms, against " + significant(kMostRms, 1) +
                      " allowed");
}

/// Milliseconds from ordinary memory to the device, or back: the least of a few.
double transfer_ms(Device::Parts& parts, std::size_t bytes, bool up) {
  const PinnedMemory& pinned = parts.pinned(0, bytes);
  const DeviceMemory& memory = parts.memory(Device::Parts::Place::scene, bytes);
  std::vector<std::byte> ordinary(bytes);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 4; ++i) {
    const Stopwatch watch;
    if (up) {
      std::memcpy(pinned.data, ordinary.data(), bytes);
      parts.backend->upload(parts.queue, pinned.data, memory, bytes);
    } else {
      parts.backend->download(parts.queue, memory, pinned.data, bytes);
    }
    parts.backend->finish(parts.queue);
    if (!up) std::memcpy(ordinary.data(), pinned.data, bytes);
    least = std::min(least, watch.ms());
  }
  return least;
}

}  // namespace

std::vector<std::uint32_t> bits_on_host(std::int64_t inputs) {
  std::vector<std::uint32_t> bits(static_cast<std::size_t>(inputs) * kBitsOfInput);
  for (std::int64_t i = 0; i < inputs; ++i)
    host::bits_of_input(bits.data() + static_cast<std::size_t>(i) * kBitsOfInput, static_cast<int>(i));
  return bits;
}

void admit(const std::shared_ptr<const Device>& device) {
  Device::Parts& parts = device->parts();
  require_same_bits(parts);
  const bool later = parts.fault >= DeviceFault::run;
  const DeviceFault asked = std::exchange(parts.fault, later ? DeviceFault::none : parts.fault);
  try_pixels(device);
  const std::array<Trial, 2> all = trials();
  for (std::size_t t = 0; t < all.size(); ++t) {
    const Trial& trial = all[t];
    const auto filter = make_device_filter(device, trial.x, trial.y, otf_of(trial));
    const Image scene = scene_of(trial);
    Image image(trial.x.outputs, trial.y.outputs);
    double least = std::numeric_limits<double>::infinity();
    parts.kernels_ms = 0.0;
    for (int i = 0; i < 5; ++i) {
      filter->run({{.in = scene.view(), .out = image.view(), .mean = kMean, .border_value = trial.border_value}}, 1);
      least = std::min(least, *parts.kernels_ms);
    }
    parts.kernels_ms.reset();
    parts.test.filter_ms[t] = least;
    const double rms = parts.test.rms[t] = error_of(trial, scene, image);
    if (!(rms <= kMostRms))
      throw DeviceError("its filter of " + size_text(trial.x.samples, trial.y.samples) + " samples errs by " +
                        significant(rms, 2) + " of their standard deviation, rms, against " + significant(kMostRms, 1) +
                        " allowed");
    constexpr double kMargin = 2.0;  // of an error that two scenes have shown
    parts.test.rounding = std::max(parts.test.rounding, kMargin * rms / (0x1p-24 * rounding_units(trial.x, trial.y)));
  }
  try_taps(device, scene_of(all[1]));
  const std::scoped_lock lock(parts.lock);
  parts.fault = asked;
  constexpr std::size_t kLarge = std::size_t{4} << 20, kSmall = 4096;
  const double small_up = transfer_ms(parts, kSmall, true), small_down = transfer_ms(parts, kSmall, false);
  parts.test.transfer_ms = small_up + small_down;
  const auto rate = [&](bool up, double small) {
    return 1e6 * std::max(0.0, transfer_ms(parts, kLarge, up) - small) / static_cast<double>(kLarge - kSmall);
  };
  parts.test.upload_ns = rate(true, small_up);
  parts.test.download_ns = rate(false, small_down);
}

}  // namespace mtf
