// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/bench_rivals.h"

#include <algorithm>
#include <cmath>

#include "apps/bench/machine.h"
#include "apps/check/reference_fft.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

// The reference holds half a spectrum of every scene row and of every output row, complex, in double.
void require_memory(const BenchJob& job) {
  const double half = 0.5 * static_cast<double>(mtf::canvas_length(job.options.border, job.in.width)) + 1.0;
  const double bytes = 16.0 * half * static_cast<double>(job.in.height + job.out.height) +
                       16.0 * static_cast<double>(job.out.width * job.out.height);
  const auto machine = static_cast<double>(this_machine().memory_bytes);
  if (bytes > 0.5 * machine)
    throw mtf::UsageError("the exact image of a " + std::to_string(job.in.width) + "x" + std::to_string(job.in.height) +
                          " scene takes " + std::to_string(std::llround(bytes / 1048576.0)) +
                          " MiB, more than half of this machine's memory; cut the scene");
}

using mtf::io::OpenCvJob;

constexpr std::int64_t kLargestRadius = 31;    // kernels of up to 63 samples
constexpr int kWavelengths = 64;               // of a band: far below the rounding of float
constexpr std::int64_t kLongestSpread = 2048;  // what lies beyond half of it is far below any tolerance

// The lengths that OpenCV's transform is quick at.
std::int64_t next_quick(std::int64_t n) {
  const auto quick = [](std::int64_t m) {
    for (const std::int64_t p : {2, 3, 5})
      while (m % p == 0) m /= p;
    return m == 1;
  };
  while (!quick(n)) ++n;
  return n;
}

bool is_separable(const BenchJob& job) {
  const auto& list = job.system.list(mtf::Stage::presample);
  return job.options.aperture.kind != mtf::SceneAperture::Kind::curve &&
         std::all_of(list.begin(), list.end(), [&](const mtf::Entry<double>& entry) {
           return entry.component.traits(job.system.context()).separable;
         });
}

}  // namespace

BenchJob make_job(const mtf::io::SensorConfig& config, mtf::io::Scene& scene, std::size_t plane, int threads) {
  BenchJob job;
  job.system = config.system;
  job.in = scene.grid;
  job.out = mtf::detector_grid(config.system, scene.grid);
  job.options.border = config.scene.border;
  job.options.aperture = mtf::io::scene_aperture(config.scene, scene.grid);
  job.border_value = config.scene.border_value;
  job.scene = std::move(scene.planes[plane]);
  const mtf::Statistics s = mtf::statistics(job.scene.view());
  if (s.not_finite > 0)
    throw mtf::RuntimeError("channel " + scene.names[plane] + ": " + std::to_string(s.not_finite) +
                            " pixels are NaN or infinite, the first at column " + std::to_string(s.first_x) + ", row " +
                            std::to_string(s.first_y) + "; replace them before a benchmark");
  job.options.scene = mtf::summarise(job.scene.view(), job.options.border, job.border_value);
  job.options.spectrum = mtf::scene_spectrum(job.scene.view(), job.options.border, threads);
  job.options.threads = threads;
  job.flat = !job.options.scene;
  job.scale = !job.flat ? s.std : s.mean != 0.0 ? std::abs(s.mean) : 1.0;
  require_memory(job);
  return job;
}

Realised realised_error(const BenchJob& job, mtf::ImageView<const float> image) {
  double squares = 0.0, largest = 0.0;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      const double d = std::abs(image.at(x, y) - job.exact[static_cast<std::size_t>(y * image.width + x)]);
      squares += d * d;
      largest = d > largest || std::isnan(d) ? d : largest;  // a NaN stays
    }
  const double rms = std::sqrt(squares / (static_cast<double>(image.width) * static_cast<double>(image.height)));
  // A uniform plane is right to the last bit of a float where it differs from the reference by its rounding only.
  if (job.flat && largest <= std::ldexp(job.scale, -23)) return {};
  return {rms / job.scale, largest / job.scale};
}

std::string Rivals::obstacle(const BenchJob& job) {
  if (!job.system.list(mtf::Stage::readout).empty() || !job.system.list(mtf::Stage::postsample).empty())
    return "the sensor has filters after the sampling";
  if (!mtf::is_whole(job.out.step_x_um / job.in.step_x_um) || !mtf::is_whole(job.out.step_y_um / job.in.step_y_um))
    return "the pitch is not a whole number of scene samples";
  return "";
}

Rivals::Side Rivals::side(std::int64_t samples, double step, double pitch) const {
  const std::int64_t stride = std::llround(pitch / step);
  const std::int64_t period = std::min(mtf::canvas_length(job_->options.border, samples), kLongestSpread);
  return {samples, period, stride, (stride - 1) / 2, stride % 2 == 0};
}

Rivals::Rivals(const BenchJob& job, mtf::ImageView<float> out, double slowest_ms)
    : job_(&job),
      out_(out),
      x_(side(job.in.width, job.in.step_x_um, job.out.step_x_um)),
      y_(side(job.in.height, job.in.step_y_um, job.out.step_y_um)),
      separable_(is_separable(job)),
      slowest_ms_(slowest_ms) {
  static_cast<void>(mtf::io::opencv_filter({.width = 1,
                                            .height = 1,
                                            .kernel_width = 1,
                                            .kernel_height = 1,
                                            .kernel = {1.0},
                                            .kernel_x = {1.0},
                                            .kernel_y = {1.0}}));  // is it there?
  // The response to one bright sample, taken at the detector centres.
  const mtf::SampleGrid grid{x_.period, y_.period, job.in.step_x_um, job.in.step_y_um};
  std::vector<double> point(static_cast<std::size_t>(x_.period * y_.period), 0.0);
  point[static_cast<std::size_t>(y_.period / 2 * x_.period + x_.period / 2)] = 1.0;
  mtf::System<double> system = job.system;
  system.band_nodes = kWavelengths;
  const check::OtfColumn exact = check::exact_otf(system, {mtf::Stage::presample}, job.options.aperture, job.in);
  const double shift_x_mm = x_.between ? 0.5e-3 * job.in.step_x_um : 0.0;
  const double shift_y_mm = y_.between ? 0.5e-3 * job.in.step_y_um : 0.0;
  const check::OtfColumn shifted = [&](double fx, std::span<const double> fy, std::span<std::complex<double>> h) {
    exact(fx, fy, h);
    for (std::size_t i = 0; i < fy.size(); ++i)
      h[i] *= std::polar(1.0, 2.0 * M_PI * (fx * shift_x_mm + fy[i] * shift_y_mm));
  };
  spread_ = check::reference_image_fft(mtf::ImageView<const double>{point.data(), x_.period, y_.period, x_.period},
                                       grid, grid, shifted, mtf::Border::periodic, 0.0, job.options.threads);
  for (const double value : spread_) sum_ += value;
  separable_ = separable_ && std::abs(sum_) > 1e-6;
}

double Rivals::spread(std::int64_t shift_x, std::int64_t shift_y) const {
  const std::int64_t x = x_.period / 2 + shift_x, y = y_.period / 2 + shift_y;
  if (x < 0 || y < 0 || x >= x_.period || y >= y_.period) return 0.0;
  return spread_[static_cast<std::size_t>(y * x_.period + x)];
}

OpenCvJob Rivals::kernel_job(Method method, std::int64_t radius) const {
  OpenCvJob job;
  job.method = method;
  // Halfway between two samples the point spread is even about -1/2: shifts -radius .. radius - 1.
  job.kernel_width = 2 * radius + (x_.between ? 0 : 1);
  job.kernel_height = 2 * radius + (y_.between ? 0 : 1);
  job.origin_x = job.origin_y = radius;
  double sum = 0.0;
  job.kernel_x.assign(static_cast<std::size_t>(job.kernel_width), 0.0);
  job.kernel_y.assign(static_cast<std::size_t>(job.kernel_height), 0.0);
  for (std::int64_t y = 0; y < job.kernel_height; ++y)
    for (std::int64_t x = 0; x < job.kernel_width; ++x) {
      const double value = spread(x - radius, y - radius);
      job.kernel.push_back(value);
      job.kernel_x[static_cast<std::size_t>(x)] += value;
      job.kernel_y[static_cast<std::size_t>(y)] += value;
      sum += value;
    }
  // The mean is kept, as everybody does who cuts a kernel.
  if (std::abs(sum) < 0.1 * std::abs(sum_) || sum == 0.0) return job;
  for (double& value : job.kernel) value *= sum_ / sum;
  for (double& value : job.kernel_x) value *= sum_ / sum;
  for (double& value : job.kernel_y) value /= sum;
  return job;
}

OpenCvJob Rivals::transform_job(std::int64_t pad) const {
  OpenCvJob job;
  job.method = Method::dft;
  // A canvas of the border's own period needs no more: the image itself, a mirror's twice that.
  const mtf::Border border = job_->options.border;
  const auto length = [&](std::int64_t n) {
    if (border == mtf::Border::periodic) return n;
    return next_quick(n + 2 * std::min(pad, border == mtf::Border::reflect ? n / 2 : n));
  };
  job.kernel_width = length(x_.samples);
  job.kernel_height = length(y_.samples);
  job.pad_x = (job.kernel_width - x_.samples) / 2;  // the room that a quick length leaves is shared too
  job.pad_y = (job.kernel_height - y_.samples) / 2;
  job.kernel.assign(static_cast<std::size_t>(job.kernel_width * job.kernel_height), 0.0);
  const auto wrapped = [](std::int64_t i, std::int64_t n) { return (i % n + n) % n; };
  for (std::int64_t y = -(y_.period / 2); y < y_.period - y_.period / 2; ++y)
    for (std::int64_t x = -(x_.period / 2); x < x_.period - x_.period / 2; ++x)
      job.kernel[static_cast<std::size_t>(wrapped(y, job.kernel_height) * job.kernel_width +
                                          wrapped(x, job.kernel_width))] += spread(x, y);
  return job;
}

Rivals::Trial Rivals::make(Method method, std::int64_t extent) const {
  OpenCvJob job = method == Method::dft ? transform_job(extent) : kernel_job(method, extent);
  job.width = job_->in.width;
  job.height = job_->in.height;
  job.border = job_->options.border;
  job.border_value = job_->border_value;
  job.first_x = x_.first;
  job.first_y = y_.first;
  job.stride_x = x_.stride;
  job.stride_y = y_.stride;
  Contender contender;
  const std::string size = std::to_string(job.kernel_width) + " x " + std::to_string(job.kernel_height);
  contender.method = kRivalNames[static_cast<std::size_t>(method)];
  contender.detail = method == Method::dft ? "padded to " + size : size + " taps";
  contender.size = {job.width, job.height};
  const std::int64_t image = job.width * job.height, kernel = job.kernel_width * job.kernel_height;
  contender.bytes = 4 * (method == Method::dft ? 4 * kernel : image + kernel);
  contender.run = [filter = mtf::io::opencv_filter(job), scene = job_->scene.view(), out = out_] {
    filter(scene, out);
  };
  const mtf::Stopwatch watch;
  contender.run();
  const double ms = watch.ms();
  contender.error = realised_error(*job_, out_);
  return {std::move(contender), ms};
}

bool Rivals::fits(Method method, std::int64_t extent, double tolerance) {
  const auto [known, fresh] = error_.try_emplace({method, extent}, 0.0);
  if (fresh) known->second = make(method, extent).contender.error.rms;
  return known->second <= tolerance;
}

std::vector<std::int64_t> Rivals::pads() const {
  if (job_->options.border == mtf::Border::periodic) return {0};
  std::vector<std::int64_t> pads;
  const std::int64_t longest = std::max(x_.samples, y_.samples);
  for (std::int64_t pad = 4; pad < longest; pad *= 2) pads.insert(pads.end(), {pad, pad + pad / 2});
  pads.push_back(longest);
  // The point spread in double and float, image, spectrum and result.
  const auto bytes = [&](std::int64_t pad) {
    return 24.0 * static_cast<double>(x_.samples + 2 * pad) * static_cast<double>(y_.samples + 2 * pad);
  };
  const double limit = 0.25 * static_cast<double>(this_machine().memory_bytes);
  while (pads.size() > 1 && bytes(pads.back()) > limit) pads.pop_back();
  return pads;
}

std::vector<Contender> Rivals::at(double tolerance) {
  std::vector<std::int64_t> radii;
  for (std::int64_t r = x_.between || y_.between ? 1 : 0; r <= kLargestRadius; ++r) radii.push_back(r);
  std::vector<Contender> rivals;
  // The error falls with the extent: bisection for the first that fits.
  const auto invite = [&](Method method, const std::vector<std::int64_t>& extents) {
    std::size_t low = 0, high = extents.size() - 1;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (fits(method, extents[middle], tolerance))
        high = middle;
      else
        low = middle + 1;
    }
    const std::pair key{method, extents[low]};
    if (best_.count(key) == 0) {
      Trial trial = make(method, extents[low]);
      if (trial.ms > slowest_ms_) {
        const std::string text = trial.contender.method + ", " + trial.contender.detail;
        if (std::find(too_slow_.begin(), too_slow_.end(), text) == too_slow_.end()) too_slow_.push_back(text);
        return;
      }
      best_.emplace(key, std::move(trial.contender));
    }
    rivals.push_back(best_.at(key));
  };
  invite(Method::dft, pads());
  invite(Method::filter2d, radii);
  if (separable_) invite(Method::sep, radii);
  return rivals;
}

}  // namespace apps
