// SPDX-License-Identifier: Apache-2.0

// The twin of bench_python.py in C++: the sensor of the first example on a scene of 1280 x 1024 samples, one to a
// pixel. Each line of standard input asks for a round of that many frames, run with a number of threads: "60 1". The
// answer is the processor time and the wall time of a frame in ms, the mean of the round. `fresh` as argument: each
// frame has an image of its own, else all are written to one.

#include <ctime>

#include <chrono>
#include <cstdio>
#include <iostream>
#include <random>
#include <string_view>

#include "mtf/io/config/config.h"
#include "mtf/plan/sensor_plan.h"

namespace {

double cpu_ms() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

}  // namespace

int main(int argc, char** argv) {
  const bool fresh = argc > 1 && std::string_view(argv[1]) == "fresh";
  const mtf::io::ConfigResult sensor = mtf::io::parse_config(
      "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n[optics]\nf_number = 2.0\nwavelength = \"4 "
      "um\"\n"
      "[[presample]]\nkind = \"diffraction\"\n[[presample]]\nkind = \"footprint\"\nwidth = \"15 um\"\n"
      "[[presample]]\nkind = \"jitter\"\nrms = \"20 urad\"\n",
      "sensor");
  mtf::Image scene(1280, 1024);
  std::mt19937 random(1);
  std::normal_distribution<float> values(5.0F, 1.0F);
  for (std::int64_t i = 0; i < scene.size(); ++i) scene.data()[i] = values(random);
  const mtf::SampleGrid grid{1280, 1024, 15.0, 15.0};
  mtf::PlanOptions options{.tolerance = 1e-4};
  options.scene = mtf::summarise(scene.view(), options.border, 0.0);
  const mtf::SensorPlan plan = mtf::compile_sensor(sensor.config.system, grid, options);
  mtf::Image image(plan.out().width, plan.out().height);
  int frames = 0, threads = 1;
  while (std::cin >> frames >> threads) {
    const double cpu = cpu_ms();
    const auto wall = std::chrono::steady_clock::now();
    for (int i = 0; i < frames; ++i) {
      if (fresh) image = mtf::Image(plan.out().width, plan.out().height);
      plan.presample.run(scene.view(), image.view(), 0.0, threads);
    }
    const double wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count();
    std::printf("%.6f %.6f\n", (cpu_ms() - cpu) / frames, wall_ms / frames);
    std::fflush(stdout);
  }
}
