// SPDX-License-Identifier: Apache-2.0
#include "apps/live/frames.h"

#include <algorithm>
#include <cmath>

#include "apps/simulate/simulate_parts.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/work/stopwatch.h"

namespace apps::live {
namespace {

constexpr std::size_t kKept = 6;  // frames: two pages with the ones they show and the one they ask for

/// Every so many columns of so many rows.
mtf::Image some_of(mtf::ImageView<const float> image, std::int64_t every) {
  mtf::Image some((image.width + every - 1) / every, (image.height + every - 1) / every);
  for (std::int64_t y = 0; y < some.height(); ++y)
    for (std::int64_t x = 0; x < some.width(); ++x) some.at(x, y) = image.at(x * every, y * every);
  return some;
}

/// The values between which all but a share of both ends lie, of some thousand pixels.
std::pair<double, double> usual_range(mtf::ImageView<const float> image) {
  constexpr std::int64_t kSamples = 4096;
  constexpr double kShare = 0.005;
  std::vector<float> values;
  const std::int64_t count = image.width * image.height;
  const std::int64_t step = std::max<std::int64_t>(1, count / kSamples) | 1;  // odd: no column is met again and again
  for (std::int64_t i = 0; i < count; i += step) {
    const float value = image.at(i % image.width, i / image.width);
    if (std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return {0.0, 0.0};
  const auto at = [&](double share) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return static_cast<double>(*place);
  };
  return {at(kShare), at(1.0 - kShare)};
}

}  // namespace

PixelBytes pixel_bytes(mtf::ImageView<const float> image, int every, int threads) {
  constexpr std::int64_t kRowsAtOnce = 64;
  const mtf::Image some = every > 1 ? some_of(image, every) : mtf::Image();
  const mtf::ImageView<const float> sent = every > 1 ? some.view() : image;
  PixelBytes pixels;
  pixels.width = sent.width, pixels.height = sent.height;
  const mtf::Statistics s = mtf::statistics(image, threads);  // of a moving picture the same as at rest
  pixels.low = s.min, pixels.high = s.max;
  std::tie(pixels.dark, pixels.bright) = usual_range(sent);
  const auto low = static_cast<float>(pixels.low);
  const float scale = pixels.high > pixels.low ? static_cast<float>(65535.0 / (pixels.high - pixels.low)) : 0.0F;
  pixels.bytes.resize(static_cast<std::size_t>(2 * sent.width * sent.height));
  mtf::parallel_for(sent.height, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      const float* row = sent.row(y);
      char* out = pixels.bytes.data() + 2 * y * sent.width;
      for (std::int64_t x = 0; x < sent.width; ++x) {
        // Not-a-number fails both comparisons and becomes the least value.
        const float n = (row[x] - low) * scale + 0.5F;
        const auto whole = static_cast<std::uint16_t>(n >= 65535.0F ? 65535.0F : n > 0.0F ? n : 0.0F);
        out[2 * x] = static_cast<char>(whole & 0xff);
        out[2 * x + 1] = static_cast<char>(whole >> 8);
      }
    }
  });
  return pixels;
}

FrameMaker::FrameMaker(SceneSource scene, SimulateOptions image, std::uint64_t first_id)
    : source_(std::move(scene)), image_(std::move(image)), count_(first_id) {
  if (!source_.image) files_ = FrameNames::parse(source_.file);
  if (files_) numbers_ = files_->find(std::nullopt);
}
FrameMaker::FrameMaker(DrawScene draw, std::uint64_t first_id) : draw_(std::move(draw)), count_(first_id) {}

SceneSource FrameMaker::source_of(std::int64_t number) const {
  SceneSource source = clone(source_);
  if (files_) source.file = files_->name(number);
  return source;
}

KeptFrame FrameMaker::of_image(const Sensor& sensor, const FrameRequest& request) {
  const std::int64_t file = files_ ? request.number : 0;
  if (!live_ || file != file_number_ || request.tolerance != made_for_.tolerance || request.stage != made_for_.stage) {
    // The present one stays until another one is there.
    image_.tolerance = request.tolerance, image_.stage = request.stage;
    live_.emplace(source_of(file), image_);
    made_for_ = request;
    file_number_ = file;
  }
  KeptFrame frame;
  // A camera with other parameters is another camera, whose correction is its own: what one command would show.
  frame.image = live_->image(*sensor, request.number, request.correction(), request.preview ? request.every : 1);
  frame.correction_lags = live_->correction_lags();
  frame.noise_rows = live_->noise_rows();
  frame.passing = frame.correction_lags || frame.noise_rows > 1;
  frame.names = live_->names();
  frame.warnings = live_->warnings();
  if (const std::string failed = device_words(image_.device); !failed.empty()) frame.warnings.push_back(failed);
  frame.plan = std::make_shared<const mtf::SensorPlan>(live_->plan());
  frame.range = live_->integer_range();
  return frame;
}

std::shared_ptr<const KeptFrame> FrameMaker::frame(const Sensor& sensor, const FrameRequest& request) {
  // What was made while the page loaded is what it asks for first; an image of a preview is that at rest, too.
  FrameRequest asked = request;
  if (!draw_) asked.preview = false;
  asked.every = 1;
  const auto lags = [](const KeptFrame& kept) {
    return kept.light_lags || kept.correction_lags || kept.noise_rows > 1 || !kept.solving.empty();
  };
  if (!kept_.empty() && !lags(*kept_.back()) && sensor == last_sensor_) {
    FrameRequest last = last_request_;
    last.may_lag = asked.may_lag, last.tab = asked.tab;
    if (last == asked) return kept_.back();
  }
  const mtf::Stopwatch watch;
  const auto frame = std::make_shared<KeptFrame>(draw_ ? draw_(sensor, request) : of_image(sensor, request));
  frame->ms = watch.ms();
  frame->id = ++count_;
  last_sensor_ = sensor;
  last_request_ = asked;
  kept_.push_back(frame);
  if (kept_.size() > kKept) kept_.pop_front();
  return frame;
}

std::shared_ptr<const KeptFrame> FrameMaker::kept(std::uint64_t id) const {
  for (const auto& frame : kept_)
    if (frame->id == id) return frame;
  return nullptr;
}

std::shared_ptr<const mtf::io::Scene> FrameMaker::scene(const Sensor& sensor, std::int64_t number) {
  if (draw_) throw mtf::UsageError("a 3-D scene comes with its frames");
  const std::int64_t file = files_ ? number : 0;
  const bool same = scene_ && file == scene_number_ && same_values(scene_sensor_->scene, sensor->scene);
  if (!same) {
    SceneSource source = source_of(file);
    complete_name(source);
    scene_ = std::make_shared<const mtf::io::Scene>(take_scene(*sensor, source));
    scene_number_ = file;
  }
  scene_sensor_ = sensor;
  return scene_;
}

}  // namespace apps::live
