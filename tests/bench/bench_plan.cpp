// SPDX-License-Identifier: Apache-2.0

// Plan::run beside bare FFTW float transforms of the same lengths and flags (the floor), of the image's own size, and
// OpenCV doing the same filter by cv::dft, all on one thread and interleaved. Also: making the OTF of six components
// beside one transform. Output: a table; columns are minimum and median in ms.

#include <fftw3.h>

#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>

#include "mtf/plan.h"
#include "mtf/version.h"
#include "tests/bench/interleave.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/reference.h"

namespace {

using namespace mtf;  // NOLINT: a benchmark program

// Forward and inverse real transform, out of place, as a user of FFTW would write it.
class BarePair {
 public:
  BarePair(std::int64_t width, std::int64_t height, unsigned flags)
      : real_(static_cast<std::size_t>(width * height)), half_(static_cast<std::size_t>(2 * height * (width / 2 + 1))) {
    const auto w = static_cast<int>(width), h = static_cast<int>(height);
    auto* spectrum = reinterpret_cast<fftwf_complex*>(half_.data());
    forward_ = fftwf_plan_dft_r2c_2d(h, w, real_.data(), spectrum, flags);
    backward_ = fftwf_plan_dft_c2r_2d(h, w, spectrum, real_.data(), flags);
    std::fill_n(real_.data(), real_.size(), 0.0F);  // zeros stay zeros: the inverse is unnormalised
  }
  ~BarePair() {
    fftwf_destroy_plan(forward_);
    fftwf_destroy_plan(backward_);
  }
  BarePair(const BarePair&) = delete;
  BarePair& operator=(const BarePair&) = delete;
  void forward() const { fftwf_execute(forward_); }
  void both() const {
    fftwf_execute(forward_);
    fftwf_execute(backward_);
  }

 private:
  AlignedBuffer<float> real_, half_;
  fftwf_plan forward_ = nullptr, backward_ = nullptr;
};

struct Size {
  std::int64_t width, height;
};

void compare(const Size& size, double ratio, const System<double>& system, fft::Rigor rigor, const char* what) {
  const SampleGrid in{size.width, size.height, 15.0 / ratio, 15.0 / ratio};
  const SampleGrid out = detector_grid(system, in);
  const Image scene = test::random_image(size.width, size.height, 1, 100.0, 10.0);
  PlanOptions options;
  options.rigor = rigor;
  options.scene = summarise(scene.view(), options.border, 0.0);
  const Plan plan = compile(system, in, out, options);
  Image image(out.width, out.height);
  const auto padded = plan.report().size;
  const unsigned flags = rigor == fft::Rigor::measure ? FFTW_MEASURE : FFTW_ESTIMATE;
  const BarePair floor(padded[0], padded[1], flags), own(size.width, size.height, flags);

  const cv::Mat mat(static_cast<int>(size.height), static_cast<int>(size.width), CV_32F,
                    const_cast<float*>(scene.data()));
  const cv::Mat otf(mat.rows, mat.cols, CV_32F, cv::Scalar(1.0));
  cv::Mat spectrum, filtered;
  const auto t = bench::interleave(
      {[&] { plan.run(scene.view(), image.view(), 0.0, 1); }, [&] { floor.both(); }, [&] { own.both(); },
       [&] {
         cv::dft(mat, spectrum);
         cv::mulSpectrums(spectrum, otf, spectrum, 0);
         cv::dft(spectrum, filtered, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
       }},
      21);
  std::printf(
      "%-22s %4lldx%-4lld /%g  plan %7.2f %7.2f | floor %lldx%lld %7.2f %7.2f | own size %7.2f %7.2f | cv::dft %7.2f "
      "%7.2f"
      " | plan/floor %.2f  plan/own %.2f\n",
      what, static_cast<long long>(size.width), static_cast<long long>(size.height), ratio, t[0].min_ms, t[0].median_ms,
      static_cast<long long>(padded[0]), static_cast<long long>(padded[1]), t[1].min_ms, t[1].median_ms, t[2].min_ms,
      t[2].median_ms, t[3].min_ms, t[3].median_ms, t[0].min_ms / t[1].min_ms, t[0].min_ms / t[2].min_ms);
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

void otf_making(fft::Rigor rigor) {
  const System<double> system = six_components();
  const SampleGrid grid{1024, 1024, 7.5, 7.5};
  PlanOptions options;
  options.rigor = rigor;
  options.threads = 1;
  const Plan plan = compile(system, grid, detector_grid(system, grid), options);
  const BarePair bare(1024, 1024, rigor == fft::Rigor::measure ? FFTW_MEASURE : FFTW_ESTIMATE);
  const auto t = bench::interleave({[&] { const Plan again = plan.with(system); }, [&] { bare.forward(); }}, 21);
  std::printf(
      "OTF of 6 components, 1024x1024 (Plan::with, all included)  %7.2f %7.2f | one transform %7.2f %7.2f | ratio "
      "%.2f\n",
      t[0].min_ms, t[0].median_ms, t[1].min_ms, t[1].median_ms, t[0].min_ms / t[1].min_ms);
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  std::printf("mtfkit %s (%s), %s; one thread; minimum and median of interleaved runs, ms\n",
              std::string(mtf::version).c_str(), std::string(mtf::git_commit).c_str(), fft::version().c_str());
  System<double> complex = test::mwir();
  complex.add(Stage::presample, test::rc(60.0, 0));
  for (const fft::Rigor rigor : {fft::Rigor::estimate, fft::Rigor::measure}) {
    std::printf("%s\n", rigor == fft::Rigor::measure ? "FFTW_MEASURE" : "FFTW_ESTIMATE");
    for (const Size size : {Size{640, 512}, Size{1024, 1024}, Size{2048, 2048}}) {
      compare(size, 1.0, test::mwir(), rigor, "even OTF, reflect");
      compare(size, 4.0, test::mwir(), rigor, "even OTF, reflect");
      compare(size, 4.0, complex, rigor, "RC phase, reflect");
    }
    otf_making(rigor);
  }
}
