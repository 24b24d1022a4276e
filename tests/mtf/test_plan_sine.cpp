// SPDX-License-Identifier: Apache-2.0
// Sine targets: the modulation and phase in the output are those of the analytic OTF, from 0 to beyond the detector's
// Nyquist frequency, where they appear at their alias.
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

using C = std::complex<double>;
constexpr double kMean = 3.0;

struct Target {
  const char* name;
  System<double> system;
};

std::vector<Target> targets() {
  const auto optics = Component<double>::make("diffraction");
  return {{"even", with(bare(), {optics, footprint(12.0), jitter(2.0)})},
          {"rc x", with(bare(), {optics, rc(30.0, 0)})},
          {"rc y, motion", with(bare(), {optics, rc(25.0, 1), motion(9.0, 30.0)})}};
}

// Scene samples so that whole pitches fit the periodic canvas where the ratio allows it.
std::int64_t samples(double ratio) {
  return ratio == 3.7 ? 74 : ratio == M_PI ? 60 : static_cast<std::int64_t>(16 * ratio) | (ratio == 1.0 ? 15 : 0);
}

// Cosine and sine target of k whole cycles, as the two planes of one complex exponential; the response to it is
// H(f) exp(2 pi i f X) at every detector centre X, in band or aliased. Least squares on that one basis function.
void expect_response(const Plan& plan, const System<double>& system, std::int64_t kx, std::int64_t ky) {
  const SampleGrid& in = plan.in();
  const SampleGrid& out = plan.out();
  const double fx = static_cast<double>(kx) / (static_cast<double>(in.width) * in.step_x_um);
  const double fy = static_cast<double>(ky) / (static_cast<double>(in.height) * in.step_y_um);
  const auto phase = [&](const SampleGrid& g, std::int64_t x, std::int64_t y) {
    return 2.0 * M_PI *
           (fx * (static_cast<double>(x) + 0.5) * g.step_x_um + fy * (static_cast<double>(y) + 0.5) * g.step_y_um);
  };
  const Image cosine = image_of(in.width, in.height, [&](auto x, auto y) { return kMean + std::cos(phase(in, x, y)); });
  const Image sine = image_of(in.width, in.height, [&](auto x, auto y) { return kMean + std::sin(phase(in, x, y)); });
  const Image a = run(plan, cosine), b = run(plan, sine);
  C sum = 0.0;
  for (std::int64_t y = 0; y < out.height; ++y)
    for (std::int64_t x = 0; x < out.width; ++x)
      sum += C(a.at(x, y) - kMean, b.at(x, y) - kMean) * std::polar(1.0, -phase(out, x, y));
  const C seen = sum / static_cast<double>(a.size());
  const Complex<double> h = system.otf(Stage::presample, {fx * 1e3, fy * 1e3});
  EXPECT_NEAR(seen.real(), h.re, 1e-4) << "cycles " << kx << ", " << ky << "\n" << plan.explain();
  EXPECT_NEAR(seen.imag(), h.im, 1e-4) << "cycles " << kx << ", " << ky;
  double worst = 0.0;
  for (std::int64_t y = 0; y < out.height; ++y)
    for (std::int64_t x = 0; x < out.width; ++x)
      worst = std::max(worst, std::abs(C(a.at(x, y) - kMean, b.at(x, y) - kMean) -
                                       C(h.re, h.im) * std::polar(1.0, phase(out, x, y))));
  EXPECT_LT(worst, 1e-4) << "something besides the target, cycles " << kx << ", " << ky;
}

class SineTarget : public testing::TestWithParam<double> {};

TEST_P(SineTarget, has_the_analytic_modulation_and_phase_on_a_periodic_canvas) {
  const double ratio = GetParam();
  for (const Target& target : targets()) {
    SCOPED_TRACE(target.name);
    // Another ratio along y, so that axes cannot be mixed up.
    const double ratio_y = ratio == 1.0 ? 2.0 : ratio == M_PI ? 3.7 : ratio == 3.7 ? M_PI : 1.0;
    const SampleGrid in = scene_grid(target.system, samples(ratio), samples(ratio_y), ratio, ratio_y);
    PlanOptions options;
    options.border = Border::periodic;
    const Plan plan = compile(target.system, in, detector_grid(target.system, in), options);
    // Up to the scene's Nyquist frequency: beyond the detector's own for every ratio above 1.
    for (std::int64_t k = 1; 2 * k<in.width; k += in.width> 40 ? 2 : 1) expect_response(plan, target.system, k, 0);
    for (std::int64_t k = 1; 2 * k<in.height; k += in.height> 40 ? 3 : 1) expect_response(plan, target.system, 0, k);
    for (std::int64_t k = 1; 2 * k < in.width && 2 * k < in.height; k += 2) {
      expect_response(plan, target.system, k, k);
      expect_response(plan, target.system, k, -k);
    }
  }
}

// cos(pi k (i + 1/2) / n) continues through its mirror at both edges, so reflect leaves it an endless cosine.
TEST_P(SineTarget, passes_the_mirror_as_an_endless_cosine) {
  const double ratio = GetParam();
  for (const Target& target : targets()) {
    SCOPED_TRACE(target.name);
    const SampleGrid in = scene_grid(target.system, samples(ratio), samples(ratio), ratio, ratio);
    const SampleGrid out = detector_grid(target.system, in);
    const Plan plan = compile(target.system, in, out, {});
    for (const bool along_x : {true, false})
      for (std::int64_t k = 1; k < in.width; k += 3) {
        const double step = along_x ? in.step_x_um : in.step_y_um, pitch = along_x ? out.step_x_um : out.step_y_um;
        const double f = static_cast<double>(k) / (2.0 * static_cast<double>(in.width) * step);
        const auto target_at = [&](double position) { return 2.0 * M_PI * f * position; };
        const Image scene = image_of(in.width, in.height, [&](auto x, auto y) {
          return kMean + std::cos(target_at((static_cast<double>(along_x ? x : y) + 0.5) * step));
        });
        const Image image = run(plan, scene);
        const Complex<double> h =
            target.system.otf(Stage::presample, along_x ? Freq<double>{f * 1e3, 0} : Freq<double>{0, f * 1e3});
        double worst = 0.0;
        for (std::int64_t y = 0; y < out.height; ++y)
          for (std::int64_t x = 0; x < out.width; ++x) {
            const double p = target_at((static_cast<double>(along_x ? x : y) + 0.5) * pitch);
            worst = std::max(worst, std::abs(image.at(x, y) - kMean - h.re * std::cos(p) + h.im * std::sin(p)));
          }
        EXPECT_LT(worst, 1e-4) << (along_x ? "x" : "y") << " k " << k << "\n" << plan.explain();
      }
  }
}

// Any frequency, any border: in the middle of a long target the edges do not show.
TEST_P(SineTarget, is_right_far_from_the_edges_for_every_border) {
  const double ratio = GetParam();
  auto blur = Component<double>::make("gaussian");
  set_xy(blur, "sigma", 12.0, 0.0, "um");  // nothing along y, where the border is near
  const System<double> system = with(bare(), {blur, rc(60.0, 0)});
  for (const Border border : kBorders)
    for (const double cycles_per_pitch : {0.05, 0.2371, 0.5, 0.613, 1.0, 1.137}) {
      if (cycles_per_pitch > 0.45 * ratio) continue;
      const double pitch = system.frame.pitch_x_um, f = cycles_per_pitch / pitch;
      const SampleGrid in = scene_grid(system, static_cast<std::int64_t>(120 * ratio), 4, ratio, 1.0);
      const SampleGrid out = detector_grid(system, in);
      PlanOptions options;
      options.border = border;
      options.tolerance = 1e-5;
      const Plan plan = compile(system, in, out, options);
      const auto scene = [&](double phase) {
        return image_of(in.width, in.height, [&](auto x, auto) {
          return kMean + std::cos(2.0 * M_PI * f * (static_cast<double>(x) + 0.5) * in.step_x_um + phase);
        });
      };
      const Image a = run(plan, scene(0.0), kMean), b = run(plan, scene(-0.5 * M_PI), kMean);
      C sum = 0.0;
      double count = 0.0;
      for (std::int64_t x = out.width / 3; x < 2 * out.width / 3; ++x, ++count)
        sum += C(a.at(x, 1) - kMean, b.at(x, 1) - kMean) *
               std::polar(1.0, -2.0 * M_PI * f * (static_cast<double>(x) + 0.5) * pitch);
      const Complex<double> h = system.otf(Stage::presample, {f * 1e3, 0.0});
      EXPECT_NEAR(sum.real() / count, h.re, 1e-4) << cycles_per_pitch << "\n" << plan.explain();
      EXPECT_NEAR(sum.imag() / count, h.im, 1e-4) << cycles_per_pitch;
    }
}

INSTANTIATE_TEST_SUITE_P(ratios, SineTarget, testing::Values(1.0, 2.0, 4.0, 3.7, M_PI));

}  // namespace
}  // namespace mtf::test
