// SPDX-License-Identifier: Apache-2.0
#include "mtf/device/device_taps.h"

#include <algorithm>
#include <cstdint>

#include "mtf/device/device_planes.h"

namespace mtf {
namespace {

/// Samples of the canvas along an axis: all that the taps of its outputs read.
std::int64_t canvas_of(const TapAxis& axis) { return (axis.outputs - 1) * axis.ratio + axis.count; }

std::int32_t narrow(std::int64_t n) { return static_cast<std::int32_t>(n); }

class DeviceTaps final : public Engine {
 public:
  DeviceTaps(std::shared_ptr<const Device> device, const TapAxis& x, const TapAxis& y, Border border,
             const std::vector<float>& taps)
      : planes_(std::move(device), {x.samples, y.samples}, {x.outputs, y.outputs}), x_(x), y_(y) {
    const std::scoped_lock lock(planes_.parts().lock);
    const auto sources = [&](const TapAxis& axis) {
      std::vector<std::int32_t> from;
      for (std::int64_t i = 0; i < canvas_of(axis); ++i)
        from.push_back(narrow(border_source(border, axis.first + i, axis.samples)));
      return planes_.sent(from);
    };
    from_x_ = sources(x);
    from_y_ = sources(y);
    taps_ = planes_.sent(taps);
    std::vector<std::int32_t> spans;  // of each row, from the first tap that is not zero to behind the last
    for (std::int64_t row = 0; row < y.count; ++row) {
      const auto begin = taps.begin() + row * x.count, end = begin + x.count;
      const auto used = [](float tap) { return tap != 0.0F; };
      const auto first = std::find_if(begin, end, used);
      const auto last = std::find_if(std::reverse_iterator(end), std::reverse_iterator(first), used).base();
      spans.push_back(narrow(first - begin));
      spans.push_back(narrow(last - begin));
    }
    spans_ = planes_.sent(spans);
  }

  void run(const std::vector<Channel>& channels, int threads) const override {
    planes_.run(channels, threads, [this](const DevicePlane& plane) {
      const std::int64_t width = canvas_of(x_), height = canvas_of(y_);
      const DeviceMemory& canvas = planes_.parts().memory(Device::Parts::Place::canvas,
                                                          static_cast<std::size_t>(width * height) * sizeof(float));
      planes_.launch("gather", width, height,
                     {canvas, plane.scene, from_x_, from_y_, narrow(width), narrow(height), narrow(width),
                      narrow(x_.samples), plane.mean, plane.scale, plane.border});
      planes_.launch(
          "weigh", x_.outputs, y_.outputs,
          {plane.image, canvas, taps_, spans_, narrow(x_.outputs), narrow(y_.outputs), narrow(width), narrow(x_.ratio),
           narrow(y_.ratio), narrow(x_.count), narrow(y_.count), plane.unscale, plane.out_mean, plane.beyond});
    });
  }
  std::int64_t run_bytes(std::int64_t channels, int) const override { return planes_.bytes(channels); }
  std::int64_t filter_bytes() const override { return static_cast<std::int64_t>(taps_->bytes); }

 private:
  DevicePlanes planes_;  // its device outlives the memory below
  TapAxis x_, y_;
  std::shared_ptr<const DeviceMemory> from_x_, from_y_, taps_, spans_;
};

}  // namespace

std::string device_taps_obstacle(const DeviceInfo& info, const TapAxis& x, const TapAxis& y) {
  const std::int64_t canvas = canvas_of(x) * canvas_of(y);
  return memory_obstacle(info, 4 * std::max({canvas, x.samples * y.samples, x.outputs * y.outputs}),
                         device_taps_bytes(x, y));
}

std::int64_t device_taps_bytes(const TapAxis& x, const TapAxis& y) {
  return 4 * (canvas_of(x) * canvas_of(y) + x.samples * y.samples + x.outputs * y.outputs + x.count * y.count);
}

double device_taps_cost_ms(const Device& device, const TapAxis& x, const TapAxis& y, std::int64_t used) {
  const auto count = static_cast<double>(used) * static_cast<double>(x.outputs) * static_cast<double>(y.outputs);
  return transfers_ms(device.test(), x.samples * y.samples, x.outputs * y.outputs) +
         1e-6 * device.parts().tap_ns * count;
}

std::shared_ptr<const Engine> make_device_taps(std::shared_ptr<const Device> device, const TapAxis& x, const TapAxis& y,
                                               Border border, const std::vector<float>& taps) {
  return std::make_shared<DeviceTaps>(std::move(device), x, y, border, taps);
}

}  // namespace mtf
