// SPDX-License-Identifier: Apache-2.0

// What noise costs on a frame of 1280 x 1024: Gaussian numbers added, and Poisson numbers at means from 1e-3 to 1e12,
// flat and with all means in one frame; maps, ADC, and a whole frame from
// mean electrons to counts. Mpixel/s of one core: by the processor time of the thread, which other work on
// the machine disturbs least, and by the clock. Fastest of interleaved runs. The frame is filled anew before each; that
// is timed apart and taken off.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "mtf/version.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/noise/fixed_pattern.h"

namespace {

constexpr std::int64_t kWidth = 1280, kHeight = 1024;

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

int main() {
  mtf::Image frame(kWidth, kHeight);
  const radiometry::NoiseKey key{1, 0};
  std::vector<std::string> names{"copy", "gaussian"};
  std::vector<std::function<void()>> work;
  const auto fill = [&frame](float value) { std::fill_n(frame.data(), frame.size(), value); };
  work.emplace_back([&] { fill(1.0F); });
  work.emplace_back([&] {
    fill(1.0F);
    radiometry::add_gaussian(frame.view(), 3.0, key, radiometry::Stream::read);
  });
  for (const double mean : {0.0, 1e-3, 0.1, 1.0, 10.0, 50.0, 63.0, 65.0, 200.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e9, 1e12}) {
    names.push_back("poisson " + std::to_string(mean));
    work.emplace_back([&, mean] {
      fill(static_cast<float>(mean));
      radiometry::shot_noise(frame.view(), key);
    });
  }
  names.emplace_back("poisson 1e-3 ... 1e7, mixed");
  mtf::Image mixed(kWidth, kHeight);
  for (std::int64_t i = 0; i < mixed.size(); ++i)
    mixed.data()[i] = static_cast<float>(std::pow(10.0, -3.0 + 10.0 * static_cast<double>(i * 7919 % 1009) / 1009.0));
  work.emplace_back([&] {
    std::copy_n(mixed.data(), mixed.size(), frame.data());
    radiometry::shot_noise(frame.view(), key);
  });
  // A frame as a sensor makes it: 2e4 electrons, everything on. The readout is not filtered here.
  mtf::Image gains(kWidth, kHeight), offsets(kWidth, kHeight);
  radiometry::responsivity_map(gains.view(), {0.01}, key.seed);
  radiometry::offset_map(offsets.view(), 50.0, key.seed);
  names.emplace_back("map x image");
  work.emplace_back([&] {
    fill(2e4F);
    radiometry::multiply_by(frame.view(), gains.view());
  });
  names.emplace_back("full well and ADC of 14 bits");
  const radiometry::Adc adc = radiometry::adc_for_well(1e5, 14);
  work.emplace_back([&] {
    fill(2e4F);
    radiometry::fill_well(frame.view(), 1e5);
    radiometry::digitise(frame.view(), adc);
  });
  names.emplace_back("a whole frame, electrons to counts");
  work.emplace_back([&] {
    fill(2e4F);
    radiometry::multiply_by(frame.view(), gains.view());
    radiometry::shot_noise(frame.view(), key);
    radiometry::add_map(frame.view(), offsets.view());
    radiometry::fill_well(frame.view(), 1e5);
    radiometry::add_gaussian(frame.view(), 40.0, key, radiometry::Stream::read);
    radiometry::add_column_noise(frame.view(), 10.0, key, radiometry::Stream::temporal_column);
    radiometry::digitise(frame.view(), adc);
  });
  std::vector<double> cpu(work.size(), 1e300), clock(work.size(), 1e300);
  for (int round = 0; round < 9; ++round)
    for (std::size_t i = 0; i < work.size(); ++i) {
      const double cpu_start = seconds(CLOCK_THREAD_CPUTIME_ID), start = seconds(CLOCK_MONOTONIC);
      work[i]();
      cpu[i] = std::min(cpu[i], seconds(CLOCK_THREAD_CPUTIME_ID) - cpu_start);
      clock[i] = std::min(clock[i], seconds(CLOCK_MONOTONIC) - start);
    }
  std::printf("mtfkit %s (%s); one thread, %lld x %lld\n%-34s %10s %10s\n", mtf::version, mtf::git_commit,
              static_cast<long long>(kWidth), static_cast<long long>(kHeight), "Mpixel/s", "processor", "clock");
  const double pixels = static_cast<double>(frame.size()) * 1e-6;
  for (std::size_t i = 1; i < work.size(); ++i)
    std::printf("%-34s %10.1f %10.1f\n", names[i].c_str(), pixels / (cpu[i] - cpu[0]), pixels / (clock[i] - clock[0]));
}
