// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf bench` measures against: one plane, one sensor, and the exact image in double.

#include <array>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/codecs/opencv_filters.h"
#include "mtf/io/scene.h"
#include "mtf/plan/sensor_plan.h"

namespace apps {

struct BenchJob {
  mtf::System<double> system;
  mtf::SampleGrid in, out;
  mtf::PlanOptions options;  ///< border, aperture, scene and its spectrum, rigor, device and threads; each plan has its
                             ///< own tolerance
  double border_value = 0.0;
  mtf::Image scene;
  std::vector<double> exact;  ///< the reference image
  double scale = 1.0;         ///< std of the scene; of a uniform one its value, or 1
  bool flat = false;
};

/// One plane and its sensor, the exact image not yet made. Throws RuntimeError when pixels are not finite, UsageError
/// when the exact image would not fit the machine's memory.
BenchJob make_job(const mtf::io::SensorConfig& config, mtf::io::Scene& scene, std::size_t plane, int threads);

/// Error of an image, relative to the scale of the job.
struct Realised {
  double rms = 0.0, largest = 0.0;
};
Realised realised_error(const BenchJob& job, mtf::ImageView<const float> image);

/// A method that was tried: ready to run again, its error known.
struct Contender {
  std::string method, detail;
  std::function<void()> run;
  Realised error;
  std::array<std::int64_t, 2> size{};  ///< lengths of its transforms, of the scene when it has none
  std::int64_t bytes = 0;              ///< filter, and buffers of one run
};

// Plain OpenCV for the same task, as an experienced user would write it: cv::dft with the exact OTF on a padded image,
// filter2D with the kernel cut to the smallest size that is exact enough, sepFilter2D where the kernel factors; then,
// for scenes finer than the pitch, picking the detector's samples.

/// Names of the methods, in the order of mtf::io::OpenCvJob::Method.
inline constexpr std::array<std::string_view, 3> kRivalNames{"opencv_dft", "opencv_filter2d", "opencv_sep"};

class Rivals {
 public:
  /// Makes the point spread. The job has to outlive this; its images go to `out`. Methods that take longer
  /// than `slowest_ms` are left out. Throws RuntimeError when OpenCV is not there.
  Rivals(const BenchJob& job, mtf::ImageView<float> out, double slowest_ms);

  /// Why OpenCV cannot do this job: stages after the sampling, or a pitch that is no whole number of samples.
  static std::string obstacle(const BenchJob& job);

  /// One of each kind, of the smallest kernel or padding whose own error is within the tolerance; the largest that is
  /// tried where none is.
  std::vector<Contender> at(double tolerance);
  /// What was left out for its run time.
  const std::vector<std::string>& too_slow() const { return too_slow_; }

 private:
  using Method = mtf::io::OpenCvJob::Method;
  struct Side {
    std::int64_t samples, period, stride, first;
    bool between;  ///< a detector centre lies halfway between two samples
  };
  Side side(std::int64_t samples, double step, double pitch) const;
  double spread(std::int64_t shift_x, std::int64_t shift_y) const;
  mtf::io::OpenCvJob kernel_job(Method method, std::int64_t radius) const;
  mtf::io::OpenCvJob transform_job(std::int64_t pad) const;
  struct Trial {
    Contender contender;
    double ms;
  };
  Trial make(Method method, std::int64_t extent) const;
  bool fits(Method method, std::int64_t extent, double tolerance);
  std::vector<std::int64_t> pads() const;

  const BenchJob* job_;
  mtf::ImageView<float> out_;
  Side x_, y_;
  std::vector<double> spread_;  ///< shift (0, 0) in the middle: [period / 2]
  double sum_ = 0.0;
  bool separable_ = false;
  double slowest_ms_;
  std::map<std::pair<Method, std::int64_t>, double> error_;  ///< of what was tried
  std::map<std::pair<Method, std::int64_t>, Contender> best_;
  std::vector<std::string> too_slow_;
};

}  // namespace apps
