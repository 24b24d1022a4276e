// SPDX-License-Identifier: Apache-2.0

// FFT plans beside bare FFTW (float, MEASURE, in place or out of place, whichever is faster) of the image's own size,
// and OpenCV doing the same filter by cv::dft, all on one thread and interleaved; and plans of the scene with its left
// or its upper half flat, relative to that of the whole one. Also: making the OTF of six components beside one
// transform. Output: a table; columns are minimum and median in ms.

#include <cstdio>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "mtf/plan/plan.h"
#include "mtf/version.h"
#include "tests/bench/bare_pair.h"
#include "tests/bench/interleave.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/reference.h"

namespace {

using namespace mtf;  // NOLINT: a benchmark program

struct Size {
  std::int64_t width, height;
};

void compare(const char* what, const Size& size, double ratio, const System<double>& system) {
  const SampleGrid in{size.width, size.height, 15.0 / ratio, 15.0 / ratio};
  const SampleGrid out = detector_grid(system, in);
  const Image scene = test::random_image(size.width, size.height, 1, 100.0, 10.0);
  PlanOptions options;
  options.method = Method::fft_float;
  options.scene = summarise(scene.view(), options.border, 0.0);
  const Plan whole = compile(system, in, out, options);
  // Only the columns below the cutoff, where there is one.
  options.method = Method::fft_cut;
  std::optional<Plan> cut;
  if (whole.report().candidates.size() > 1)
    for (const Candidate& candidate : whole.report().candidates)
      if (candidate.method == Method::fft_cut && candidate.possible) cut = compile(system, in, out, options);
  const Plan plan = cut.value_or(whole);
  Image image(out.width, out.height), left = scene.clone(), top = scene.clone();
  for (std::int64_t y = 0; y < size.height; ++y) std::fill_n(left.view().row(y), size.width / 2, 100.0F);
  std::fill_n(top.data(), size.height / 2 * size.width, 100.0F);
  const auto plan_of = [&](const Image& half) {
    options.method = cut ? Method::fft_cut : Method::fft_float;
    options.scene = summarise(half.view(), options.border, 0.0);
    return compile(system, in, out, options);
  };
  const Plan left_plan = plan_of(left), top_plan = plan_of(top);
  const bench::BarePair apart(size.width, size.height, false), in_place(size.width, size.height, true);
  Image rivals = scene.clone();  // its own: all scenes of plans are equally far from the processor
  const cv::Mat mat(static_cast<int>(size.height), static_cast<int>(size.width), CV_32F, rivals.data());
  const cv::Mat otf(mat.rows, mat.cols, CV_32F, cv::Scalar(1.0));
  cv::Mat spectrum, filtered;
  const auto t =
      bench::interleave({[&] { plan.run(scene.view(), image.view(), 0.0, 1); }, [&] { apart.both(); },
                         [&] { in_place.both(); }, [&] { left_plan.run(left.view(), image.view(), 0.0, 1); },
                         [&] { top_plan.run(top.view(), image.view(), 0.0, 1); },
                         [&] {
                           cv::dft(mat, spectrum);
                           cv::mulSpectrums(spectrum, otf, spectrum, 0);
                           cv::dft(spectrum, filtered, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
                         }},
                        21);
  const apps::Timing& floor = t[1].min_ms < t[2].min_ms ? t[1] : t[2];
  const auto& kept = plan.report().kept;
  std::printf(
      "%-28s %4lldx%-4lld kept %4lldx%-4lld plan %7.2f %7.2f | left half flat %.2f %.2f, top %.2f %.2f | FFTW %7.2f "
      "%7.2f | cv::dft %7.2f %7.2f | plan/FFTW "
      "%.2f %.2f\n",
      what, static_cast<long long>(size.width), static_cast<long long>(size.height), static_cast<long long>(kept[0]),
      static_cast<long long>(kept[1]), t[0].min_ms, t[0].median_ms, t[3].min_ms / t[0].min_ms,
      t[3].median_ms / t[0].median_ms, t[4].min_ms / t[0].min_ms, t[4].median_ms / t[0].median_ms, floor.min_ms,
      floor.median_ms, t[5].min_ms, t[5].median_ms, t[0].min_ms / floor.min_ms, t[0].median_ms / floor.median_ms);
}

System<double> six_components() {
  System<double> s = test::mwir();
  s.add(Stage::presample, test::motion(5.0, 0.0));
  s.add(Stage::presample, test::gaussian(3.0));
  auto wavefront = Component<double>::make("rms_wavefront");
  test::set(wavefront, "rms", 0.05);
  s.add(Stage::presample, wavefront);
  return s;
}

void otf_making() {
  const System<double> system = six_components();
  const SampleGrid grid{1024, 1024, 7.5, 7.5};
  PlanOptions options;
  options.threads = 1;
  options.method = Method::fft_float;
  const Plan plan = compile(system, grid, detector_grid(system, grid), options);
  const bench::BarePair bare(1024, 1024, false);
  const auto t = bench::interleave({[&] { const Plan again = plan.with(system); }, [&] { bare.forward(); }}, 21);
  std::printf(
      "OTF of 6 components, 1024x1024 (Plan::with, all included)  %7.2f %7.2f | one transform %7.2f %7.2f | ratio "
      "%.2f\n",
      t[0].min_ms, t[0].median_ms, t[1].min_ms, t[1].median_ms, t[0].min_ms / t[1].min_ms);
}

// Diffraction and a footprint, cut off at a part of the scene's Nyquist frequency.
System<double> cut_at(double part, double ratio) {
  System<double> s = test::mwir();
  s.optics.f_number = 1e3 / (part * 500.0 * ratio / 15.0 * 4.0);
  return s;
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  std::printf("mtfkit %s (%s), %s; reflect border, one thread; minimum and median of interleaved runs, ms\n",
              std::string(mtf::version).c_str(), std::string(mtf::git_commit).c_str(), fft::version().c_str());
  System<double> complex = test::mwir();
  complex.add(Stage::presample, test::rc(60.0, 0));
  for (const Size size : {Size{640, 512}, Size{1024, 1024}, Size{1280, 1024}, Size{2048, 2048}}) {
    compare("1 a pitch", size, 1.0, cut_at(1.5, 1.0));
    for (const double ratio : {2.0, 4.0}) {
      const std::string what = ratio == 2.0 ? "2 a pitch" : "4 a pitch";
      compare((what + ", up to Nyquist").c_str(), size, ratio, cut_at(1.5, ratio));
      compare((what + ", up to half of it").c_str(), size, ratio, cut_at(0.5, ratio));
    }
    compare("1 a pitch, OTF with phase", size, 1.0, complex);
    compare("4 a pitch, OTF with phase", size, 4.0, complex);
  }
  otf_making();
}
