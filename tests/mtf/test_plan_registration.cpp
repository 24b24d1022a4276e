// SPDX-License-Identifier: Apache-2.0
// Registration: nothing moves. Every harmonic of a point source has its analytic phase, and centroids stay.
#include <random>

#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

using C = std::complex<double>;

double turns(std::int64_t k, double position, std::int64_t n) {
  return 2.0 * M_PI * static_cast<double>(k) * position / static_cast<double>(n);
}

// One axis of the analytic response: coefficient of output harmonic q of a unit point at sample p, for every scene
// frequency that aliases onto it.
struct Alias {
  std::int64_t k;
  C factor;
};
std::vector<Alias> aliases(std::int64_t q, std::int64_t outputs, std::int64_t samples, std::int64_t p) {
  std::vector<Alias> list;
  for (std::int64_t k = -(samples / 2); k <= samples / 2; ++k) {
    if ((k - q) % outputs != 0) continue;
    const double weight = 2 * std::abs(k) == samples ? 0.5 : 1.0;
    const double ratio = static_cast<double>(samples) / static_cast<double>(outputs);
    // exp(2 pi i k X / period) at detector centre 0, times the point's own phase.
    list.push_back({k, weight * std::polar(1.0, turns(k, 0.5 * ratio - 0.5 - static_cast<double>(p), samples))});
  }
  return list;
}

void expect_phases(const System<double>& system, std::int64_t outputs_x, std::int64_t outputs_y, std::int64_t ratio,
                   std::int64_t px, std::int64_t py) {
  const SampleGrid in =
      scene_grid(system, outputs_x * ratio, outputs_y * ratio, static_cast<double>(ratio), static_cast<double>(ratio));
  const SampleGrid out = detector_grid(system, in);
  ASSERT_EQ(out.width, outputs_x);
  ASSERT_EQ(out.height, outputs_y);
  const double height = static_cast<double>(in.width * in.height);  // so that DC is 1 per sample
  const Image scene = image_of(in.width, in.height, [&](auto x, auto y) { return x == px && y == py ? height : 0.0; });
  PlanOptions options = options_for(scene, Border::periodic, 1e-5);
  const Plan plan = compile(system, in, out, options);
  const Image image = run(plan, scene);
  const double pixels = static_cast<double>(outputs_x * outputs_y);
  int compared = 0;
  for (std::int64_t qy = -(outputs_y / 2); 2 * qy <= outputs_y; ++qy)
    for (std::int64_t qx = 0; 2 * qx <= outputs_x; ++qx) {
      if (qx == 0 && qy <= 0) continue;
      C expected = 0.0, seen = 0.0;
      for (const Alias& a : aliases(qx, outputs_x, in.width, px))
        for (const Alias& b : aliases(qy, outputs_y, in.height, py)) {
          const Complex<double> h = system.otf(
              Stage::presample, {1e3 * static_cast<double>(a.k) / (static_cast<double>(in.width) * in.step_x_um),
                                 1e3 * static_cast<double>(b.k) / (static_cast<double>(in.height) * in.step_y_um)});
          expected += C(h.re, h.im) * a.factor * b.factor;
        }
      if (std::abs(expected) < 1e-3) continue;
      for (std::int64_t y = 0; y < outputs_y; ++y)
        for (std::int64_t x = 0; x < outputs_x; ++x)
          seen += static_cast<double>(image.at(x, y)) *
                  std::polar(1.0 / pixels, -turns(qx, static_cast<double>(x), outputs_x) -
                                               turns(qy, static_cast<double>(y), outputs_y));
      const double cycles_per_px = std::hypot(static_cast<double>(qx) / static_cast<double>(outputs_x),
                                              static_cast<double>(qy) / static_cast<double>(outputs_y));
      const double shift_px = std::arg(seen * std::conj(expected)) / (2.0 * M_PI * cycles_per_px);
      ASSERT_LT(std::abs(shift_px), 1e-5) << "harmonic " << qx << ", " << qy << " |H| " << std::abs(expected) << "\n"
                                          << plan.explain();
      ++compared;
    }
  EXPECT_GT(compared, outputs_x / 2);
}

TEST(PlanRegistration, every_output_harmonic_of_a_point_keeps_its_phase) {
  std::mt19937 generator(11);
  for (const auto& system : {with(bare(), {Component<double>::make("diffraction"), footprint(12.0), jitter(2.0)}),
                             with(bare(), {Component<double>::make("diffraction"), rc(40.0, 0), motion(8.0, 40.0)})})
    for (const std::int64_t ratio : {1, 2, 3, 4})
      for (const auto& [width, height] : {std::pair<std::int64_t, std::int64_t>{16, 15}, {15, 12}, {21, 7}})
        for (int i = 0; i < 3; ++i) {
          const auto px = static_cast<std::int64_t>(generator() % static_cast<unsigned>(width * ratio));
          const auto py = static_cast<std::int64_t>(generator() % static_cast<unsigned>(height * ratio));
          SCOPED_TRACE(testing::Message()
                       << "ratio " << ratio << " size " << width << "x" << height << " point " << px << ", " << py);
          expect_phases(system, width, height, ratio, px, py);
          if (testing::Test::HasFatalFailure()) return;
        }
}

// sigma 1.1 pitch: the OTF is below 1e-9 from the sampling frequency on. At ratio 1 the scene itself ends at half of
// that; only with twice the sigma does its point spread, which rings otherwise, lie inside the image.
TEST(PlanRegistration, centroid_of_a_wide_spot_stays_for_every_ratio_and_border) {
  std::mt19937 generator(5);
  for (const double ratio : {1.0, 2.0, 3.0, 4.0, 3.7, M_PI}) {
    const double sigma = ratio == 1.0 ? 2.2 : 1.1;  // pitches
    auto blur = Component<double>::make("gaussian");
    set_xy(blur, "sigma", sigma * 15.0, sigma * 12.0, "um");
    const System<double> system = with(bare(), {blur});
    for (const Border border : kBorders)
      for (const int odd : {0, 1})
        for (int i = 0; i < 3; ++i) {
          const auto width = static_cast<std::int64_t>(20 * sigma * ratio) + odd, height = width + 3;
          const SampleGrid in = scene_grid(system, width, height, ratio, ratio);
          const SampleGrid out = detector_grid(system, in);
          const auto middle = [&](std::int64_t n) {
            const auto spread = static_cast<unsigned>(4 * ratio);
            return n / 2 - spread / 2 + static_cast<std::int64_t>(generator() % spread);
          };
          const std::int64_t px = middle(width), py = middle(height);
          const Image scene = image_of(width, height, [&](auto x, auto y) { return x == px && y == py ? 100.0 : 0.0; });
          const Plan plan = compile(system, in, out, options_for(scene, border, 1e-5));
          const Image image = run(plan, scene);
          double sum = 0.0, sx = 0.0, sy = 0.0;
          for (std::int64_t y = 0; y < out.height; ++y)
            for (std::int64_t x = 0; x < out.width; ++x) {
              const double v = image.at(x, y);
              sum += v, sx += v * (static_cast<double>(x) + 0.5), sy += v * (static_cast<double>(y) + 0.5);
            }
          EXPECT_NEAR(sx / sum, (static_cast<double>(px) + 0.5) / ratio, 1e-4) << plan.explain();
          EXPECT_NEAR(sy / sum, (static_cast<double>(py) + 0.5) / ratio, 1e-4) << plan.explain();
        }
  }
}

}  // namespace
}  // namespace mtf::test
