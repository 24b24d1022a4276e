// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/bench_job.h"

#include <cmath>

#include "apps/bench/machine.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"

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

}  // namespace apps
