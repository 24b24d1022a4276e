// SPDX-License-Identifier: Apache-2.0

// Separable plans of a given width beside bare FFTW of the image's own size (FFTW_MEASURE, in or out of place) and
// OpenCV's sepFilter2D with the very taps' number, on one thread, interleaved; and the same plan on scenes half of
// which are flat: the left half, the top half, every other block of 128 x 128. Columns are minimum and median in ms; of
// the flat scenes, times relative to the whole one. The copy of a plane is the floor of what is flat.

#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "mtf/engines/fft/fftw.h"
#include "mtf/plan/plan.h"
#include "mtf/version.h"
#include "tests/bench/interleave.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/reference.h"

namespace {

using namespace mtf;  // NOLINT: a benchmark program

// The plan of a Gaussian blur whose kernel has `taps` taps at tolerance 1e-4: its sigma is sought.
Plan plan_of_width(const SampleGrid& grid, const Image& scene, int taps) {
  PlanOptions options;
  options.threads = 1;
  options.scene = summarise(scene.view(), options.border, 0.0);
  options.method = Method::separable;
  for (double sigma_um = 60.0;; sigma_um -= 0.5) {
    System<double> system = test::mwir();
    for (auto& list : system.stages) list.clear();
    system.add(Stage::presample, test::gaussian(sigma_um));
    Plan plan = compile(system, grid, detector_grid(system, grid), options);
    const int width = std::atoi(plan.report().axes[0].c_str());
    if (width <= taps) return plan;
  }
}

// The scene with its mean where `flat(column, row)` says so.
template <class F>
Image flattened(const Image& scene, const F& flat) {
  Image image = scene.clone();
  for (std::int64_t y = 0; y < image.height(); ++y)
    for (std::int64_t x = 0; x < image.width(); ++x)
      if (flat(x, y)) image.at(x, y) = 100.0F;
  return image;
}

void compare(std::int64_t width, std::int64_t height, int taps) {
  const SampleGrid grid{width, height, 15.0, 15.0};
  const Image scene = test::random_image(width, height, 1, 100.0, 10.0);
  const Image left = flattened(scene, [&](auto x, auto) { return x < width / 2; });
  const Image top = flattened(scene, [&](auto, auto y) { return y < height / 2; });
  const Image blocks = flattened(scene, [](auto x, auto y) { return (x / 128 + y / 128) % 2 == 0; });
  Image image(width, height);
  const Plan plan = plan_of_width(grid, scene, taps);
  const fft::RealPair2d out_of_place(width, height, fft::RealPair2d::Place::out, fft::Rigor::measure);
  const fft::RealPair2d in_place(width, height, fft::RealPair2d::Place::in, fft::Rigor::measure);
  Image rivals = scene.clone();  // its own: all scenes of the plan are equally far from the processor
  const cv::Mat mat(static_cast<int>(height), static_cast<int>(width), CV_32F, rivals.data());
  const cv::Mat kernel(1, taps, CV_32F, cv::Scalar(1.0 / taps));
  cv::Mat filtered;
  const auto run = [&](const Image& of) { return [&] { plan.run(of.view(), image.view(), 0.0, 1); }; };
  const auto t = bench::interleave(
      {run(scene), run(left), run(top), run(blocks), [&] { std::copy_n(rivals.data(), rivals.size(), image.data()); },
       [&] { out_of_place.execute(); }, [&] { in_place.execute(); },
       [&] { cv::sepFilter2D(mat, filtered, CV_32F, kernel, kernel, cv::Point(-1, -1), 0.0, cv::BORDER_REFLECT); }},
      21);
  const apps::Timing& floor = t[5].min_ms < t[6].min_ms ? t[5] : t[6];
  std::printf(
      "%4lldx%-4lld %-16s plan %6.2f %6.2f | left half flat %.2f %.2f, top %.2f %.2f, blocks %.2f %.2f, copy %.2f %.2f "
      "| FFTW %6.2f %6.2f | sepFilter2D %6.2f %6.2f | plan/FFTW %.2f %.2f  plan/sepFilter2D %.2f %.2f\n",
      static_cast<long long>(width), static_cast<long long>(height), plan.report().axes[0].c_str(), t[0].min_ms,
      t[0].median_ms, t[1].min_ms / t[0].min_ms, t[1].median_ms / t[0].median_ms, t[2].min_ms / t[0].min_ms,
      t[2].median_ms / t[0].median_ms, t[3].min_ms / t[0].min_ms, t[3].median_ms / t[0].median_ms,
      t[4].min_ms / t[0].min_ms, t[4].median_ms / t[0].median_ms, floor.min_ms, floor.median_ms, t[7].min_ms,
      t[7].median_ms, t[0].min_ms / floor.min_ms, t[0].median_ms / floor.median_ms, t[0].min_ms / t[7].min_ms,
      t[0].median_ms / t[7].median_ms);
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  std::printf("mtfkit %s (%s), %s; tolerance 1e-4, reflect border, one thread; minimum and median, ms\n",
              std::string(mtf::version).c_str(), std::string(mtf::git_commit).c_str(), fft::version().c_str());
  for (const auto& [width, height] : {std::pair{640, 512}, std::pair{1024, 1024}, std::pair{1280, 1024}})
    for (const int taps : {15, 31}) compare(width, height, taps);
}
