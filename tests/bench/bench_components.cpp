// SPDX-License-Identifier: Apache-2.0

// What OTFs cost. First every kind on the half-plane of a 1024 x 1024 transform (513 x 1024 frequencies up to 67
// cy/mm), a row at a time through Component<S>::multiply, in double and float: ns a sample, for the case that gives the
// most fields of its table, at their example values. Then a chromatic system of 20 components with 17 wavelengths on
// the same grid through FactoredOtf, sampler made anew each time, beside one bare real FFTW transform of that size. One
// thread; all cases of a table are interleaved. Last, an aberrated pupil by quadrature, with derivatives.

#include <fftw3.h>

#include <array>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include "mtf/components/pupil/wavefront_pupil.h"
#include "mtf/grid.h"
#include "mtf/otf/factored_otf.h"
#include "mtf/plan/plan.h"
#include "mtf/version.h"
#include "tests/bench/interleave.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/conformance.h"

namespace {

using namespace mtf;  // NOLINT: a benchmark program

constexpr std::int64_t kSize = 1024;
constexpr double kStepUm = 7.5;
const FrequencyAxis kAxis{Basis::fourier, kSize, kStepUm};

template <class S>
class Rows {
 public:
  Rows() : fy_(kAxis.all_frequencies()) {
    fy_.resize(kSize);
    for (const double f : kAxis.half_frequencies()) row_.push_back({static_cast<S>(f), S(0)});
    h_.resize(row_.size());
  }
  double samples() const { return static_cast<double>(row_.size() * fy_.size()); }
  void evaluate(const Component<S>& component, const Context<S>& ctx) {
    for (const double fy : fy_) {
      for (std::size_t i = 0; i < row_.size(); ++i) row_[i].y = static_cast<S>(fy), h_[i] = {S(1), S(0)};
      component.multiply(row_, ctx, h_);
    }
  }

 private:
  std::vector<double> fy_;
  std::vector<Freq<S>> row_;
  std::vector<Complex<S>> h_;
};

/// The example values, most fields given, of every kind.
std::map<std::string, const test::Case*> fullest_examples() {
  std::map<std::string, const test::Case*> of_kind;
  for (const test::Case& c : test::conformance_cases()) {
    if (!c.name.ends_with(" #0")) continue;
    const test::Case*& best = of_kind[std::string(test::only_component(c.system).kind())];
    if (best == nullptr || c.given.size() > best->given.size()) best = &c;
  }
  return of_kind;
}

void each_kind() {
  const auto examples = fullest_examples();
  Rows<double> wide;
  Rows<float> narrow;
  std::vector<System<float>> floats;
  std::vector<std::function<void()>> cases;
  for (const auto& [kind, example] : examples) floats.push_back(cast<float>(example->system));
  std::size_t n = 0;
  for (const auto& [kind, example] : examples) {
    cases.push_back(
        [&system = example->system, &wide] { wide.evaluate(test::only_component(system), system.context()); });
    cases.push_back(
        [&system = floats[n++], &narrow] { narrow.evaluate(test::only_component(system), system.context()); });
  }
  const auto times = bench::interleave(cases, 3);
  std::printf("%-22s %10s %10s   fields given (minimum, ns a sample)\n", "kind", "double", "float");
  n = 0;
  for (const auto& [kind, example] : examples) {
    std::printf("%-22s %10.1f %10.1f   %s\n", kind.c_str(), times[n].min_ms * 1e6 / wide.samples(),
                times[n + 1].min_ms * 1e6 / wide.samples(), example->name.substr(kind.size()).c_str());
    n += 2;
  }
}

Component<double> made(const char* kind, std::initializer_list<std::pair<const char*, double>> plain,
                       std::initializer_list<std::tuple<const char*, double, const char*>> extents = {}) {
  auto c = Component<double>::make(kind);
  for (const auto& [name, value] : plain) test::set(c, name, value);
  for (const auto& [name, value, unit] : extents) test::set(c, name, value, unit);
  return c;
}

/// A scanned MWIR camera, F/2 and 3.4 to 4.8 um; four parts neither separable nor radial: motion and vibration at an
/// angle, inter-pixel capacitance, a sharpening filter.
System<double> twenty_components() {
  System<double> s;
  s.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  s.optics.f_number = 2.0;
  s.band = Band{3.4, 4.8};
  const auto presample = [&s](Component<double> c) { s.add(Stage::presample, std::move(c)); };
  presample(made("diffraction", {{"obscuration", 0.3}}));
  presample(made("rms_wavefront", {{"rms", 0.05}, {"wavelength_reference", 0.6328}}));
  presample(made("turbulence", {{"fried_parameter", 120.0}, {"wavelength_reference", 4.0}}));
  presample(test::gaussian(1.5));
  presample(test::footprint(13.5));
  presample(made("circular_footprint", {}, {{"diameter", 4.0, "um"}}));
  presample(test::jitter(12.0, "urad"));
  presample(test::motion(6.0, 30.0));
  presample(made("vibration", {{"direction", 70.0}}, {{"amplitude", 3.0, "um"}}));
  presample(made("diffusion", {{"absorption_length", 5.0}, {"depletion_depth", 2.0}, {"diffusion_length", 15.0}}));
  presample(made("tdi", {{"stages", 16}, {"clock_phases", 3}}, {{"slip", 0.2, "um"}}));
  presample(made("bolometer", {{"time_constant", 1e-3}, {"velocity", 500.0}}));
  presample(made("butterworth", {{"poles", 2}}, {{"cutoff", 80.0, "cy/mm"}}));
  s.add(Stage::readout, made("crosstalk", {{"side", 0.02}, {"corner", 0.003}}));
  s.add(Stage::readout, made("charge_transfer", {{"inefficiency", 1e-5}, {"transfers", 1000}}));
  s.add(Stage::readout, test::rc(60.0, 0));
  s.add(Stage::postsample, test::fir({{0, -0.125, 0}, {-0.125, 1.5, -0.125}, {0, -0.125, 0}}));
  s.add(Stage::postsample, made("boost", {{"gain", 1.5}}, {{"peak", 0.5, "cy/px"}}));
  s.add(Stage::postsample, made("sample_and_hold", {}, {{"width", 1.0, "px"}}));
  s.add(Stage::postsample, test::gaussian(2.0));
  return s;
}

void whole_system() {
  const System<double> system = twenty_components();
  require_valid(system);
  std::size_t count = 0;
  for (const auto& list : system.stages) count += list.size();
  std::vector<double> fx = kAxis.half_frequencies(), fy = kAxis.all_frequencies();
  fy.resize(kSize);
  const double limit = kAxis.nyquist_cy_mm();
  std::vector<Complex<float>> row(fx.size());
  int wavelengths = 0;
  const auto make = [&] {
    return FactoredOtf(system, kStages, {}, {.fx_max = limit, .fy_max = limit, .table_share = 1e-6, .wavelengths = 17});
  };
  const auto sample = [&] {
    const FactoredOtf sampler = make();
    const FactoredOtf::Grid grid(sampler, fx, fy);
    for (std::size_t j = 0; j < fy.size(); ++j) grid.complex_row(j, row);
    wavelengths = sampler.wavelengths();
  };
  AlignedBuffer<float> real(kSize * kSize), half(kSize * (kSize + 2));
  const fftwf_plan plan =
      fftwf_plan_dft_r2c_2d(kSize, kSize, real.data(), reinterpret_cast<fftwf_complex*>(half.data()), FFTW_ESTIMATE);
  std::fill_n(real.data(), real.size(), 0.0F);
  const auto t =
      bench::interleave({sample, [&] { const FactoredOtf sampler = make(); }, [&] { fftwf_execute(plan); }}, 15);
  fftwf_destroy_plan(plan);
  std::printf(
      "\n%zu components, %d wavelengths, 513x1024: %.2f %.2f ms (sampler alone %.2f %.2f) | r2c 1024x1024 %.2f %.2f ms "
      "| ratio %.1f\n",
      count, wavelengths, t[0].min_ms, t[0].median_ms, t[1].min_ms, t[1].median_ms, t[2].min_ms, t[2].median_ms,
      t[0].min_ms / t[2].min_ms);
}

// Six coefficients of up to half a wave, every frequency along one direction, absolute error 1e-8.
void wavefront_gradients() {
  std::vector<PupilPolynomial> terms;
  PupilPolynomial w;
  constexpr std::array<double, 6> kWaves{0.5, -0.3, 0.4, 0.25, -0.35, 0.2};
  for (std::size_t i = 0; i < kWaves.size(); ++i) {
    terms.push_back(zernike_polynomial(ZernikeNumbering::fringe, 4 + static_cast<int>(i)));
    w.add(terms.back(), kWaves[i]);
  }
  constexpr int kFrequencies = 64;
  std::vector<std::function<void()>> cases;
  for (const double obscuration : {0.0, 0.3})
    for (const double accuracy : {1e-8, 1e-13})
      cases.emplace_back([&w, &terms, obscuration, accuracy] {
        for (int i = 0; i < kFrequencies; ++i) {
          const double nu = (i + 0.5) / kFrequencies;
          static_cast<void>(wavefront_pupil_gradient(w, {0.8 * nu, 0.6 * nu}, obscuration, {terms, false}, accuracy));
        }
      });
  const auto t = bench::interleave(cases, 15);
  std::printf(
      "\n%d frequencies of an aberrated pupil with derivatives by 6 coefficients, ms: clear %.2f %.2f at 1e-8, "
      "%.2f %.2f at 1e-13; obscured by 0.3 %.2f %.2f, %.2f %.2f\n",
      kFrequencies, t[0].min_ms, t[0].median_ms, t[1].min_ms, t[1].median_ms, t[2].min_ms, t[2].median_ms, t[3].min_ms,
      t[3].median_ms);
}

}  // namespace

int main() {
  std::printf("mtfkit %s (%s); one thread; minima (and medians) of interleaved runs\n",
              std::string(mtf::version).c_str(), std::string(mtf::git_commit).c_str());
  each_kind();
  whole_system();
  wavefront_gradients();
}
