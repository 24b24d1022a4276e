// SPDX-License-Identifier: Apache-2.0
// Bias, scatter, reported standard deviation and median time (of the processor) of measure_edge over realisations of
// noise and sub-pixel phase.
//   bench_edges [draws = 200] [seed = 1] [part of a case's name]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string_view>
#include <vector>

#include "calib/measure/measure.h"
#include "tests/calib/made_edges.h"

namespace {

struct Case {
  const char* name;
  made::Step step;
  made::Scene scene;
};

std::vector<Case> cases(std::string_view wanted) {
  constexpr double kContrast = 0.6;
  const auto scene = [](double angle_deg, double cnr, std::int64_t height, double sagitta_px = 0.0) {
    return made::Scene{.height = height,
                       .angle_deg = angle_deg,
                       .x = {},
                       .y = {},
                       .sagitta_px = sagitta_px,
                       .half_length_px = 0.5 * static_cast<double>(height),
                       .noise_sd = kContrast / cnr};
  };
  const auto camera = [](double f_number, double angle_deg, double w020 = 0.0, double olpf = 0.0) {
    made::Camera one = made::camera_of(f_number);
    one.w020 = w020;
    one.olpf = olpf;
    return made::camera_step(one, angle_deg);
  };
  const made::Step gaussian = made::Step::gaussian(0.3);
  std::vector<Case> all;
  const auto add = [&](const char* name, const auto& step, const made::Scene& one) {
    if (std::string_view(name).find(wanted) != std::string_view::npos) all.push_back({name, step(), one});
  };
  add(
      "Gauss 0.30 CNR 60", [&] { return gaussian; }, scene(5.0, 60.0, 100));
  add(
      "Gauss 0.30 CNR 12", [&] { return gaussian; }, scene(5.0, 12.0, 100));
  add(
      "Gauss 0.30 CNR 60 32 px", [&] { return gaussian; }, scene(5.0, 60.0, 32));
  add(
      "Gauss 0.30 CNR 60 bent 1.5 px", [&] { return gaussian; }, scene(5.0, 60.0, 100, 1.5));
  add(
      "Gauss 0.30 CNR 60 26.57 deg", [&] { return gaussian; }, scene(26.565, 60.0, 100));
  add(
      "Gauss 0.30 CNR 60 45 deg", [&] { return gaussian; }, scene(45.0, 60.0, 100));
  add(
      "Gauss 0.30 CNR 60 0 deg", [&] { return gaussian; }, scene(0.0, 60.0, 100));
  add(
      "Gauss 0.30 CNR 4", [&] { return gaussian; }, scene(5.0, 4.0, 100));
  add(
      "Gauss 0.08 CNR 60", [&] { return made::Step::gaussian(0.08); }, scene(-10.0, 60.0, 100));
  add(
      "Gauss 0.50 CNR 60", [&] { return made::Step::gaussian(0.5); }, scene(15.0, 60.0, 100));
  add(
      "Airy f/8 CNR 60", [&] { return camera(8.0, 5.0); }, scene(5.0, 60.0, 100));
  add(
      "Airy f/8 CNR 12", [&] { return camera(8.0, 5.0); }, scene(5.0, 12.0, 100));
  add(
      "Airy f/8 CNR 60 32 px", [&] { return camera(8.0, 5.0); }, scene(5.0, 60.0, 32));
  add(
      "Airy f/2.8 CNR 60", [&] { return camera(2.8, 20.0); }, scene(20.0, 60.0, 100));
  add(
      "Airy f/16 CNR 60", [&] { return camera(16.0, 8.0); }, scene(8.0, 60.0, 100));
  add(
      "Airy f/5.6 OLPF CNR 60", [&] { return camera(5.6, 4.0, 0.0, 0.25); }, scene(4.0, 60.0, 100));
  add(
      "Airy f/8 W020 0.3 CNR 60", [&] { return camera(8.0, 5.0, 0.3); }, scene(5.0, 60.0, 100));
  add(
      "Airy f/8 W020 0.7 CNR 60", [&] { return camera(8.0, 5.0, 0.7); }, scene(5.0, 60.0, 100));
  add(
      "Airy f/8 W020 0.7 CNR 1000", [&] { return camera(8.0, 5.0, 0.7); }, scene(5.0, 1000.0, 100));
  return all;
}

struct Moments {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  void add(double x) { sum += x, squares += x * x, ++count; }
  double mean() const { return count ? sum / count : NAN; }
  double sd() const { return std::sqrt((squares - sum * mean()) / (count - 1)); }
};

void run(Case& one, int draws, std::uint64_t seed) {
  const double truth = one.step.crossing(0.5);
  std::mt19937_64 bits(seed);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  Moments error, reported, rms, nyquist, nyquist_sd;
  std::vector<double> ms;
  int failures = 0;
  for (int draw = 0; draw < draws; ++draw) {
    one.scene.x = 0.5 * static_cast<double>(one.scene.width) + phase(bits);
    one.scene.y = 0.5 * static_cast<double>(one.scene.height) + phase(bits);
    one.scene.seed = bits();
    const mtf::Image image = made::make(one.step, one.scene);
    const std::clock_t before = std::clock();  // of this process: others on the machine do not count
    const calib::EdgeMeasurement found = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()});
    ms.push_back(1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    if (found.trouble != calib::Trouble::none || !found.mtf50 || std::abs(found.mtf50->value / truth - 1.0) > 0.6) {
      if (failures++ == 0) std::printf("  %s: %s\n", one.name, found.reason.c_str());
      continue;
    }
    error.add(100.0 * (found.mtf50->value / truth - 1.0));
    reported.add(100.0 * found.mtf50->sd / truth);
    double squares = 0.0;
    for (std::size_t i = 0; i <= 100; ++i)
      squares += std::pow(found.mtf[i] - std::abs(one.step.mtf(found.frequency_cy_px[i])), 2);
    rms.add(1e3 * std::sqrt(squares / 101.0));
    nyquist.add(1e3 * (found.mtf[100] - std::abs(one.step.mtf(0.5))));
    nyquist_sd.add(1e3 * found.mtf_sd[100]);
  }
  const auto middle = ms.begin() + draws / 2;
  std::nth_element(ms.begin(), middle, ms.end());
  std::printf("%-30s %+7.2f %6.2f %6.2f  %5.2f | %+7.1f %6.1f %6.1f | %4d  %5.2f\n", one.name, error.mean(), error.sd(),
              reported.mean(), rms.mean(), nyquist.mean(), nyquist.sd(), nyquist_sd.mean(), failures, *middle);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int draws = argc > 1 ? std::atoi(argv[1]) : 200;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (draws < 2) return 2;
  std::printf("%-30s %7s %6s %6s  %5s | %7s %6s %6s | %4s  %5s\n", "case, 128 columns", "bias %", "sd %", "said %",
              "RMS", "Nyquist", "sd", "said", "fail", "ms");
  std::printf("%-30s %29s | %22s |\n", "", "MTF50; mean RMS dMTF, 1e-3", "1e-3");
  for (Case& one : cases(argc > 3 ? argv[3] : "")) run(one, draws, seed);
  return 0;
}
