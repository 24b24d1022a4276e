// SPDX-License-Identifier: Apache-2.0

// What it costs to turn planes of a scene into photon radiance: temperature, band radiance, spectral channels, raw
// counts, and a path for every pixel's range. Planes of 2560 x 2048, curves of 200 samples, one thread, by its
// processor time; fastest of some runs. Copying the plane before each is not counted.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <tuple>
#include <vector>

#include "mtf/version.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/path_planes.h"
#include "radiometry/light/raw_counts.h"

namespace {

constexpr std::int64_t kWidth = 2560, kHeight = 2048;

double seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

mtf::Image spread(double lo, double hi) {
  mtf::Image image(kWidth, kHeight);
  for (std::int64_t i = 0; i < image.size(); ++i)
    image.data()[i] = static_cast<float>(lo + (hi - lo) * static_cast<double>(i * 7919 % 65537) / 65537.0);
  return image;
}

void report(const char* name, const mtf::Image& plane, const std::function<void(mtf::ImageView<float>)>& work) {
  mtf::Image copy(kWidth, kHeight);
  double best = HUGE_VAL;
  for (int run = 0; run < 9; ++run) {
    std::copy_n(plane.data(), plane.size(), copy.data());
    const double start = seconds();
    work(copy.view());
    best = std::min(best, seconds() - start);
  }
  std::printf("%-32s %8.2f ms %8.0f Mpixel/s\n", name, 1e3 * best, 1e-6 * static_cast<double>(plane.size()) / best);
}

}  // namespace

int main() {
  using namespace radiometry;
  std::vector<double> wavelength, efficiency, filter;
  for (int i = 0; i < 200; ++i) {
    wavelength.push_back(2.9 + 0.012 * i);
    efficiency.push_back(0.5 + 0.001 * i);
    filter.push_back(0.8);
  }
  const SceneBand scene{{3.0, 5.0},
                        {make_spectrum("qe", wavelength, efficiency), make_spectrum("filter", wavelength, filter)}};
  std::printf("mtfkit %s (%s); one thread, %lld x %lld\n", mtf::version, mtf::git_commit,
              static_cast<long long>(kWidth), static_cast<long long>(kHeight));

  for (const auto& [name, lo, hi] :
       {std::tuple{"temperature, 280 K to 320 K", 280.0, 320.0}, {"temperature, 1 K to 6000 K", 1.0, 6000.0}}) {
    const double start = seconds();
    const RadianceTable table(BandResponse(scene.band, scene.curves), lo, hi);
    std::printf("%-32s %8.2f ms\n", "its table alone", 1e3 * (seconds() - start));
    report(name, spread(lo, hi), [&](mtf::ImageView<float> plane) { radiance_of_temperature(plane, scene); });
  }
  const mtf::Image warm = spread(280.0, 320.0), emissivity = spread(0.8, 1.0), range = spread(100.0, 2000.0);
  report("with an emissivity plane", warm, [&](mtf::ImageView<float> plane) {
    radiance_of_temperature(plane, scene, {.plane = emissivity.view(), .surroundings_k = 290.0});
  });
  report("band radiance", warm, [](mtf::ImageView<float> plane) { radiance_of_band(plane, 1.5); });
  report("four spectral channels", warm, [&](mtf::ImageView<float> plane) {
    const std::vector<mtf::ImageView<const float>> channels{warm.view(), emissivity.view(), range.view(), warm.view()};
    radiance_of_channels(channels, std::vector{1.0, 2.0, 3.0, 4.0}, plane);
  });
  report("raw counts", spread(12000.0, 16000.0), [](mtf::ImageView<float> plane) {
    const CountCamera camera{.r1 = 14985.93, .b_k = 1398.1, .f = 1.0, .o = -6233.0, .r2 = 0.0112832};
    temperature_of_counts(plane, camera, {.emissivity = 0.95});
  });

  const std::vector<double> ends{100.0, 500.0, 1000.0, 2000.0};
  std::vector<std::vector<double>> transmission, radiance;
  for (const double r : ends) {
    std::vector<double>&tau = transmission.emplace_back(), &added = radiance.emplace_back();
    for (int i = 0; i < 200; ++i) {
      tau.push_back(std::exp(-1e-4 * r * (1.0 + i % 17)));
      added.push_back(1e-3 * r);
    }
  }
  const double start = seconds();
  const RangeTable ranges(scene, {"air", ends, wavelength, transmission, radiance}, 300.0);
  std::printf("%-32s %8.2f ms\n", "table of ranges", 1e3 * (seconds() - start));
  report("range per pixel", warm, [&](mtf::ImageView<float> plane) { ranges.apply(plane, range.view()); });
  return 0;
}
