// SPDX-License-Identifier: Apache-2.0
#include "mtf/device/device_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mtf/device/device_image.h"
#include "mtf/device/device_parts.h"
#include "mtf/engines/kept_plane.h"
#include "mtf/engines/mean_and_deviation.h"
#include "mtf/parallel.h"
#include "mtf/units.h"

namespace mtf {
namespace {

// As kernels.cl has them.
struct DeviceTermX {
  std::int32_t k;
  float re, im;
};
struct DeviceTermY {
  std::int32_t source, otf, mirror_source, mirror_otf;
  float re, im;
};
static_assert(sizeof(DeviceTermX) == 12 && sizeof(DeviceTermY) == 24);

std::int32_t narrow(std::int64_t n) { return static_cast<std::int32_t>(n); }
std::size_t size_of(std::int64_t n) { return static_cast<std::size_t>(n); }

/// Frequencies k >= 0 of a real transform.
std::int64_t half_of(std::int64_t length) { return length / 2 + 1; }

/// Bytes of a half spectrum, or of the padded rows of floats in its place.
std::int64_t plane_bytes(std::int64_t width, std::int64_t height) { return 8 * half_of(width) * height; }

std::int64_t otf_bytes(const AxisTransform& x, const AxisTransform& y, bool complex) {
  return (complex ? 8 : 4) * x.keep * (2 * y.keep);
}

/// Floating-point steps of both transforms, next to those of one of a plane of 2^20.
double transform_work(const AxisTransform& x, const AxisTransform& y) {
  const auto steps = [](std::int64_t width, std::int64_t height) {
    const double samples = static_cast<double>(width) * static_cast<double>(height);
    return samples * std::log2(2.0 + samples);
  };
  return 0.5 * (steps(x.frequency.length, y.frequency.length) + steps(x.out_length, y.out_length));
}

/// Terms in the order of what they add to, and where those of each begin; `targets` of them.
template <class T>
struct TermLists {
  std::vector<std::int32_t> first;
  std::vector<T> terms;
};
template <class T>
TermLists<T> listed(const AxisTransform& job, std::int64_t targets, auto make) {
  std::vector<std::vector<T>> of(size_of(targets));
  for (const Term& term : axis_terms(job, Parity::even))
    if (term.target < targets) of[size_of(term.target)].push_back(make(term));
  TermLists<T> lists{{0}, {}};
  for (const std::vector<T>& terms : of) {
    lists.terms.insert(lists.terms.end(), terms.begin(), terms.end());
    lists.first.push_back(narrow(static_cast<std::int64_t>(lists.terms.size())));
  }
  return lists;
}

class DeviceFilter final : public SpectralFilter {
 public:
  DeviceFilter(std::shared_ptr<const Device> device, const AxisTransform& x, const AxisTransform& y, DeviceOtf otf)
      : device_(std::move(device)), x_(x), y_(y), complex_(otf.complex), gain_(gain_of(otf)) {
    Device::Parts& parts = device_->parts();
    const std::scoped_lock lock(parts.lock);
    const double scale = 1.0 / (static_cast<double>(x.frequency.length) * static_cast<double>(y.frequency.length));
    for (float& value : otf.values) value *= static_cast<float>(scale);
    otf_ = sent(otf.values);
    from_x_ = sent(narrowed(canvas_sources(x)));
    from_y_ = sent(narrowed(canvas_sources(y)));
    const auto terms_x = listed<DeviceTermX>(x, half_of(x.out_length), [](const Term& term) {
      return DeviceTermX{term.k, static_cast<float>(term.re), static_cast<float>(term.im)};
    });
    first_x_ = sent(terms_x.first);
    terms_x_ = sent(terms_x.terms);
    std::vector<std::int32_t> row_of(size_of(2 * y.keep - 1));  // of the OTF, from frequency -(keep - 1) on
    std::int32_t rows = 0;
    for (const std::int64_t k : otf_frequencies(y)) row_of[size_of(k + y.keep - 1)] = rows++;
    const auto terms_y = listed<DeviceTermY>(y, y.out_length, [&](const Term& term) {
      const std::int64_t length = y.frequency.length;
      return DeviceTermY{term.source,
                         term.otf,
                         narrow((length - term.k) % length),
                         row_of[size_of(y.keep - 1 - term.k)],
                         static_cast<float>(term.re),
                         static_cast<float>(term.im)};
    });
    first_y_ = sent(terms_y.first);
    terms_y_ = sent(terms_y.terms);
    parts.fft(forward());  // which take long to make
    parts.fft(inverse());
  }

  void run(const std::vector<Channel>& channels, int threads) const override {
    std::vector<Channel> about;
    for (const Channel& channel : channels) about.push_back(about_its_mean(channel, threads));
    Device::Parts& parts = device_->parts();
    std::unique_lock lock(parts.lock);
    if (parts.lost) throw DeviceError(parts.info.name + " does not run again: " + *parts.failure);
    try {
      if (parts.fault == DeviceFault::run) throw DeviceError("a fault that was asked for");
      if (parts.fault == DeviceFault::memory) throw DeviceMemoryError("no memory left, as was asked for");
      for (std::size_t c = 0; c < about.size(); ++c) filter(about[c], c + 1, threads);
    } catch (const DeviceError& error) {
      parts.fail(error);
    }
    if (stays(about.front())) {
      *about.front().stays = std::make_unique<DeviceImage>(device_, x_.outputs, y_.outputs, std::move(lock));
      return;
    }
    // Nothing is written before all has been filtered: whoever takes over finds the planes as they were.
    for (std::size_t c = 0; c < about.size(); ++c) deliver(about[c], parts.pinned(c + 1, image_bytes()), threads);
  }

  std::int64_t run_bytes(std::int64_t channels, int) const override {
    return static_cast<std::int64_t>(scene_bytes()) + channels * static_cast<std::int64_t>(image_bytes());
  }
  std::int64_t filter_bytes() const override { return static_cast<std::int64_t>(otf_->bytes); }
  double largest_gain() const override { return gain_; }

 private:
  using Memory = std::shared_ptr<const DeviceMemory>;
  using Place = Device::Parts::Place;

  static std::vector<std::int32_t> narrowed(const std::vector<std::int64_t>& list) {
    std::vector<std::int32_t> narrow_list;
    for (const std::int64_t n : list) narrow_list.push_back(narrow(n));
    return narrow_list;
  }
  static double gain_of(const DeviceOtf& otf) {
    float largest = 0.0F;
    for (std::size_t i = 0; i < otf.values.size(); i += otf.complex ? 2 : 1)
      largest = std::max(largest, otf.complex ? std::hypot(otf.values[i], otf.values[i + 1]) : std::abs(otf.values[i]));
    return static_cast<double>(largest);
  }
  FftShape forward() const { return {x_.frequency.length, y_.frequency.length, 1, true}; }
  FftShape inverse() const { return {x_.out_length, y_.out_length, 1, false}; }
  std::size_t scene_bytes() const { return size_of(4 * x_.samples * y_.samples); }
  std::size_t image_bytes() const { return size_of(4 * x_.outputs * y_.outputs); }

  /// Whether differences or products may leave the range of float, or be so small that a device takes them for 0. The
  /// host then scales the plane.
  static bool is_extreme(const Channel& channel) { return std::abs(std::ilogb(channel.scale)) > 100; }
  static bool stays(const Channel& channel) { return channel.stays != nullptr && !is_extreme(channel); }

  /// With the mean of all samples, which a plane that comes again is read for once.
  Channel about_its_mean(Channel channel, int threads) const {
    if (!channel.sampled) return channel;
    if (channel.kept == nullptr) return recentred(channel, x_.border, threads);
    if (!channel.kept->all) channel.kept->all = mean_and_deviation(channel.in, threads, channel.kept->flat);
    channel.mean = channel.kept->all->mean;
    channel.scale = scale_for(canvas_deviation(*channel.kept->all, x_.border, channel.border_value));
    channel.sampled = false;
    return channel;
  }

  /// The samples on the device: as they are, or about the mean (`on_host`).
  const DeviceMemory& sent_scene(const Channel& channel, bool on_host, int threads) const {
    Device::Parts& parts = device_->parts();
    KeptOnDevice* const kept = channel.kept != nullptr && !on_host ? &channel.kept->on_device : nullptr;
    if (kept != nullptr && kept->device == device_) return *static_cast<const DeviceMemory*>(kept->memory.get());
    const PinnedMemory& from = parts.pinned(0, scene_bytes());
    parallel_for_each(y_.samples, 64, threads, [&](std::int64_t y) {
      float* const row = from.floats() + y * x_.samples;
      if (on_host)
        kernels::center(channel.in.row(y), x_.samples, channel.mean, channel.scale, row);
      else
        std::copy_n(channel.in.row(y), x_.samples, row);
    });
    const Memory own = kept != nullptr ? parts.backend->allocate(scene_bytes()) : nullptr;
    const DeviceMemory& to = own ? *own : parts.memory(Place::scene, scene_bytes());
    parts.backend->upload(parts.queue, from.data, to, scene_bytes());
    if (own) {
      kept->memory = nullptr;  // before the device that it may be of
      kept->device = device_;
      kept->memory = own;
    }
    return to;
  }

  template <class T>
  Memory sent(const std::vector<T>& list) const {
    Device::Parts& parts = device_->parts();
    Memory memory = parts.backend->allocate(list.size() * sizeof(T));
    parts.backend->upload(parts.queue, list.data(), *memory, memory->bytes);
    parts.backend->finish(parts.queue);
    return memory;
  }

  // One plane, to the pinned memory of that number.
  void filter(const Channel& channel, std::size_t number, int threads) const {
    Device::Parts& parts = device_->parts();
    DeviceBackend& device = *parts.backend;
    const std::int64_t width = x_.frequency.length, height = y_.frequency.length, columns = half_of(width);
    const std::int64_t out_width = x_.out_length, out_height = y_.out_length, out_columns = half_of(out_width);
    const bool on_host = is_extreme(channel);
    const DeviceMemory& scene = sent_scene(channel, on_host, threads);
    const DeviceMemory& canvas = parts.memory(Place::canvas, size_of(plane_bytes(width, height)));
    const DeviceMemory& spectrum = parts.memory(Place::spectrum, size_of(plane_bytes(out_width, out_height)));
    const DeviceMemory& image = parts.memory(Place::image, image_bytes());
    const auto launch = [&](const char* kernel, std::int64_t x, std::int64_t y,
                            std::initializer_list<KernelArgument> arguments) {
      device.launch(parts.queue, kernel, {x, y, 1}, {arguments.begin(), arguments.size()});
    };

    const double mean = on_host ? 0.0 : channel.mean, scale = on_host ? 1.0 : channel.scale;
    const double out_mean = on_host ? 0.0 : channel.out_mean();
    const bool timed = parts.kernels_ms.has_value();
    const DeviceBackend::Event start = timed ? device.mark(parts.queue) : 0;
    launch("gather", width, height,
           {canvas, scene, from_x_, from_y_, narrow(width), narrow(height), narrow(2 * columns), narrow(x_.samples),
            static_cast<float>(mean), static_cast<float>(scale),
            static_cast<float>((channel.border_value - channel.mean) * channel.scale)});
    parts.fft(forward()).run(canvas);
    launch("fold", out_columns, out_height,
           {spectrum, canvas, otf_, first_x_, terms_x_, first_y_, terms_y_, narrow(out_columns), narrow(out_height),
            narrow(columns), narrow(x_.keep), std::int32_t{complex_}});
    parts.fft(inverse()).run(spectrum);
    const float float_mean = static_cast<float>(out_mean);
    launch("scatter", x_.outputs, y_.outputs,
           {image, spectrum, narrow(x_.outputs), narrow(y_.outputs), narrow(2 * out_columns),
            static_cast<float>(1.0 / scale), float_mean, static_cast<float>(out_mean - float_mean)});
    const DeviceBackend::Event end = timed ? device.mark(parts.queue) : 0;
    if (stays(channel)) return;
    const PinnedMemory& to = parts.pinned(number, image_bytes());
    device.download(parts.queue, image, to.data, image_bytes());
    device.finish(parts.queue);
    if (timed) parts.kernels_ms = device.ms_between(start, end);
    if (parts.fault == DeviceFault::values) to.floats()[0] += static_cast<float>(1.0 / scale);
  }

  void deliver(const Channel& channel, const PinnedMemory& image, int threads) const {
    parallel_for_each(y_.outputs, 64, threads, [&](std::int64_t y) {
      float* const row = image.floats() + y * x_.outputs;
      if (is_extreme(channel)) kernels::restore(row, x_.outputs, channel.out_mean(), 1.0 / channel.scale, row);
      if (channel.take)
        channel.take(y, 0, {row, size_of(x_.outputs)});
      else
        std::copy_n(row, x_.outputs, channel.out.row(y));
    });
  }

  std::shared_ptr<const Device> device_;  // outlives its memory
  AxisTransform x_, y_;
  bool complex_;
  double gain_;
  Memory otf_, from_x_, from_y_, first_x_, terms_x_, first_y_, terms_y_;
};

}  // namespace

std::string device_obstacle(const DeviceInfo& info, const AxisTransform& x, const AxisTransform& y, bool complex) {
  for (const AxisTransform* job : {&x, &y}) {
    const std::int64_t length = job->frequency.length;
    if (job->resampling != Resampling::fold)
      return "the device samples canvases of whole pixels alone, and this has " +
             format_double(static_cast<double>(length) * job->frequency.step_um / job->pitch_um);
    for (const std::int64_t n : {length, job->out_length})
      if (n < 2 || !is_smooth(n))
        return "the device transforms lengths of 2 and more with factors up to 7, not " + std::to_string(n);
  }
  const std::int64_t largest = std::max({plane_bytes(x.frequency.length, y.frequency.length),
                                         plane_bytes(x.out_length, y.out_length), otf_bytes(x, y, complex)});
  const std::int64_t needed = device_bytes(x, y, complex), room = info.bytes / 10 * 9;
  if (largest <= info.largest_bytes && needed <= room) return "";
  return "it needs " + format_double(static_cast<double>(needed)) + " bytes on the device, " +
         format_double(static_cast<double>(largest)) + " of them in one piece; the device gives " +
         format_double(static_cast<double>(room)) + " and " + format_double(static_cast<double>(info.largest_bytes));
}

std::int64_t device_bytes(const AxisTransform& x, const AxisTransform& y, bool complex) {
  const std::int64_t canvas = plane_bytes(x.frequency.length, y.frequency.length),
                     spectrum = plane_bytes(x.out_length, y.out_length);
  // Transforms too long for the cache of a device take a second plane.
  return canvas + spectrum + std::max(canvas, spectrum) + otf_bytes(x, y, complex) + 4 * x.samples * y.samples +
         4 * x.outputs * y.outputs;
}

double device_cost_ms(const Device& device, const AxisTransform& x, const AxisTransform& y) {
  const DeviceTest& test = device.test();
  const double transfers = 1e-6 * 4.0 *
                           (test.upload_ns * static_cast<double>(x.samples * y.samples) +
                            test.download_ns * static_cast<double>(x.outputs * y.outputs));
  const double share = transform_work(x, y) / (0x1p20 * 20.0);
  return test.transfer_ms + transfers + test.filter_ms[0] +
         std::max(0.0, test.filter_ms[1] - test.filter_ms[0]) * share;
}

std::shared_ptr<const SpectralFilter> make_device_filter(std::shared_ptr<const Device> device, const AxisTransform& x,
                                                         const AxisTransform& y, DeviceOtf otf) {
  return std::make_shared<DeviceFilter>(std::move(device), x, y, std::move(otf));
}

}  // namespace mtf
