// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf bench` measures against: one plane, one sensor, and the exact image in double.

#include <array>
#include <functional>
#include <string>
#include <vector>

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

}  // namespace apps
