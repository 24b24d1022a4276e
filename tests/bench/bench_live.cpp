// SPDX-License-Identifier: Apache-2.0

// Pictures of the live view without a browser: before each of them a slider takes another value, as the page gives it.
// Output: what a picture takes from the edit to the bytes for the page, ms, minimum and median, its processor time, and
// that of the bytes alone.
// Usage: bench_live SENSOR SCENE NAME LOW HIGH UNIT [every [pictures]]; every: of 1 no preview
//   bench_live camera.toml scene.exr jitter.rms 1 4 um 4

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <vector>

#include "apps/live/edits.h"
#include "apps/live/frames.h"
#include "apps/sensor/sensor_air.h"
#include "mtf/io/config/config.h"

namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

double processor_ms() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

void run(char** argv, int every, int count) {
  const double low = std::atof(argv[4]), high = std::atof(argv[5]);
  apps::live::EditedSensor edited(
      std::make_shared<const mtf::io::SensorConfig>(mtf::io::load_config(argv[1], nullptr, apps::sensor_schema())));
  apps::live::FrameMaker maker({.file = argv[2]}, apps::SimulateOptions{});
  constexpr int kFirst = 5;  // not counted
  std::vector<double> times, bytes;
  double processor = 0.0;
  for (int i = 0; i < kFirst + count; ++i) {
    const Clock::time_point begin = Clock::now();
    const double processor_before = processor_ms();
    const std::string value = std::to_string(low + (high - low) * i / (kFirst + count)) + " " + argv[6];
    const std::vector<apps::live::Edit> edits{{apps::live::Edit::Kind::set, argv[3], value}};
    const auto frame = maker.frame(edited.with(edits), {.number = i, .preview = every > 1, .every = every});
    const Clock::time_point made = Clock::now();
    apps::live::pixel_bytes(frame->image.planes.front().view(), every, 0);
    if (i < kFirst) continue;
    times.push_back(ms_since(begin));
    bytes.push_back(ms_since(made));
    processor += (processor_ms() - processor_before) / count;
  }
  std::ranges::sort(times);
  std::ranges::sort(bytes);
  const auto middle = static_cast<std::size_t>(count / 2);
  std::printf("picture %.1f %.1f ms, processor %.1f ms, bytes %.1f %.1f ms\n", times.front(), times[middle], processor,
              bytes.front(), bytes[middle]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7) {
    std::fprintf(stderr, "usage: bench_live SENSOR SCENE NAME LOW HIGH UNIT [every [pictures]]\n");
    return 2;
  }
  try {
    run(argv, argc > 7 ? std::atoi(argv[7]) : 1, argc > 8 ? std::max(1, std::atoi(argv[8])) : 60);
  } catch (const mtf::Error& error) {
    std::fprintf(stderr, "bench_live: %s\n", error.what());
    return 1;
  }
  return 0;
}
