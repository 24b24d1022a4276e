// SPDX-License-Identifier: Apache-2.0
#include "mtf/device/device_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mtf/device/device_planes.h"
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
      : planes_(std::move(device), {x.samples, y.samples}, {x.outputs, y.outputs}),
        x_(x),
        y_(y),
        complex_(otf.complex),
        gain_(gain_of(otf)) {
    Device::Parts& parts = planes_.parts();
    const std::scoped_lock lock(parts.lock);
    const double scale = 1.0 / (static_cast<double>(x.frequency.length) * static_cast<double>(y.frequency.length));
    for (float& value : otf.values) value *= static_cast<float>(scale);
    otf_ = planes_.sent(otf.values);
    from_x_ = planes_.sent(narrowed(canvas_sources(x)));
    from_y_ = planes_.sent(narrowed(canvas_sources(y)));
    const auto terms_x = listed<DeviceTermX>(x, half_of(x.out_length), [](const Term& term) {
      return DeviceTermX{term.k, static_cast<float>(term.re), static_cast<float>(term.im)};
    });
    first_x_ = planes_.sent(terms_x.first);
    terms_x_ = planes_.sent(terms_x.terms);
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
    first_y_ = planes_.sent(terms_y.first);
    terms_y_ = planes_.sent(terms_y.terms);
    parts.fft(forward());  // which take long to make
    parts.fft(inverse());
  }

  void run(const std::vector<Channel>& channels, int threads) const override {
    std::vector<Channel> about;
    for (const Channel& channel : channels) about.push_back(about_its_mean(channel, threads));
    planes_.run(about, threads, [this](const DevicePlane& plane) { filter(plane); });
  }

  std::int64_t run_bytes(std::int64_t channels, int) const override { return planes_.bytes(channels); }
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

  void filter(const DevicePlane& plane) const {
    Device::Parts& parts = planes_.parts();
    const std::int64_t width = x_.frequency.length, height = y_.frequency.length, columns = half_of(width);
    const std::int64_t out_width = x_.out_length, out_height = y_.out_length, out_columns = half_of(out_width);
    const DeviceMemory& canvas = parts.memory(Place::canvas, size_of(plane_bytes(width, height)));
    const DeviceMemory& spectrum = parts.memory(Place::spectrum, size_of(plane_bytes(out_width, out_height)));
    planes_.launch("gather", width, height,
                   {canvas, plane.scene, from_x_, from_y_, narrow(width), narrow(height), narrow(2 * columns),
                    narrow(x_.samples), plane.mean, plane.scale, plane.border});
    parts.fft(forward()).run(canvas);
    planes_.launch("fold", out_columns, out_height,
                   {spectrum, canvas, otf_, first_x_, terms_x_, first_y_, terms_y_, narrow(out_columns),
                    narrow(out_height), narrow(columns), narrow(x_.keep), std::int32_t{complex_}});
    parts.fft(inverse()).run(spectrum);
    planes_.launch("scatter", x_.outputs, y_.outputs,
                   {plane.image, spectrum, narrow(x_.outputs), narrow(y_.outputs), narrow(2 * out_columns),
                    plane.unscale, plane.out_mean, plane.beyond});
  }

  DevicePlanes planes_;  // its device outlives the memory below
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
  return memory_obstacle(info, largest, device_bytes(x, y, complex));
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
  const double share = transform_work(x, y) / (0x1p20 * 20.0);
  return transfers_ms(test, x.samples * y.samples, x.outputs * y.outputs) + test.filter_ms[0] +
         std::max(0.0, test.filter_ms[1] - test.filter_ms[0]) * share;
}

std::shared_ptr<const SpectralFilter> make_device_filter(std::shared_ptr<const Device> device, const AxisTransform& x,
                                                         const AxisTransform& y, DeviceOtf otf) {
  return std::make_shared<DeviceFilter>(std::move(device), x, y, std::move(otf));
}

}  // namespace mtf
