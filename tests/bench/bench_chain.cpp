// SPDX-License-Identifier: Apache-2.0

// The whole chain of a sensor on frames of 1280 x 1024, new noise in each: filter, electrons, fixed pattern, shot,
// read, row and column noise, full well, ADC, two-point correction, AGC, at several mean signals; time of each stage,
// and beside it bare FFTW of the frame's size (r2c + c2r, FFTW_MEASURE, one thread). Two threads, or those of the first
// argument. Minimum and median of interleaved frames, ms.

#include <cstdio>
#include <cstdlib>
#include <map>

#include "mtf/engines/fft/fftw.h"
#include "mtf/version.h"
#include "tests/bench/interleave.h"
#include "tests/mtf/reference.h"
#include "tests/radiometry/chain_cases.h"

namespace {

using namespace radiometry;  // NOLINT: a benchmark program

constexpr std::int64_t kWidth = 1280, kHeight = 1024;

Sensor full_sensor(double electrons) {
  Sensor sensor = test::noisy_sensor();
  sensor.settings.detector->dark_e_s = 0.0;
  sensor.settings.detector->read_e = 50.0;
  sensor.settings.detector->full_well_e = 2.5 * electrons;
  sensor.settings.adc = AdcSettings{.bits = 14};
  sensor.settings.correction = CorrectionSettings{.frames = 4};
  sensor.settings.agc = AutomaticGain{.method = GainMethod::plateau};
  return sensor;
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 2;
  std::printf("mtfkit %s (%s), %s; 1280 x 1024, %d threads; minimum and median, ms\n", mtf::version, mtf::git_commit,
              mtf::fft::version().c_str(), threads);
  const mtf::fft::RealPair2d floor(kWidth, kHeight, mtf::fft::RealPair2d::Place::in, mtf::Rigor::measure);
  for (const double electrons : {1e4, 1e5, 1e6}) {
    const Sensor sensor = full_sensor(electrons);
    mtf::Image scene = mtf::test::random_image(kWidth, kHeight, 1, 1.0, 0.1);
    const double gain =
        electrons_per_radiance(camera_of(test::mwir_system(), sensor), pixel_of(test::mwir_system(), sensor));
    for (std::int64_t i = 0; i < scene.size(); ++i) scene.data()[i] *= static_cast<float>(electrons / gain);
    mtf::PlanOptions options;
    options.scene = mtf::summarise(scene.view(), options.border, 0.0);
    options.separate_readout = true;
    const mtf::SensorPlan plan = mtf::compile_sensor(test::mwir_system(), {kWidth, kHeight, 15.0, 15.0}, options);
    const Chain chain(plan, test::mwir_system(), sensor);
    std::uint32_t number = 0;
    std::vector<std::string_view> order;
    std::map<std::string_view, std::vector<double>> stages;
    const auto frame = [&] {
      const ChainFrame done = chain.run(scene.clone(), number++, OutputStage::display, 0.0, threads);
      for (const auto& [name, ms] : done.timing_ms) {
        if (!stages.contains(name)) order.push_back(name);
        stages[name].push_back(ms);
      }
    };
    const auto t = bench::interleave({frame, [&] { static_cast<void>(scene.clone()); }, [&] { floor.execute(); }}, 21);
    std::printf("mean %.0e e-: frame %.2f %.2f (of it copying the scene %.2f %.2f) | FFTW %.2f %.2f\n", electrons,
                t[0].min_ms, t[0].median_ms, t[1].min_ms, t[1].median_ms, t[2].min_ms, t[2].median_ms);
    for (const std::string_view name : order) {
      std::vector<double>& ms = stages[name];
      std::sort(ms.begin(), ms.end());
      std::printf("    %-18s %6.2f %6.2f\n", std::string(name).c_str(), ms.front(), ms[ms.size() / 2]);
    }
  }
}
