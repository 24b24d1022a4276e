// SPDX-License-Identifier: Apache-2.0
// Band averages, and the filters on the detector grid.
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

using C = std::complex<double>;

// System::otf with the nodes of the band made once.
Otf band_otf(const System<double>& system) {
  const WavelengthNodes nodes = wavelength_nodes(*system.band, system.band_nodes);
  return [&system, nodes](double fx, double fy) {
    C rest = 1.0, mean = 0.0;
    const auto value = [&](const Entry<double>& entry, double wavelength_um) {
      const Complex<double> h = entry.component.otf({fx, fy}, system.context(wavelength_um));
      return C(h.re, h.im);
    };
    std::vector<const Entry<double>*> chromatic;
    for (const Entry<double>& entry : system.list(Stage::presample))
      if (entry.component.traits(system.context()).chromatic)
        chromatic.push_back(&entry);
      else
        rest *= value(entry, nodes.wavelength_um.front());
    for (std::size_t i = 0; i < nodes.weight.size(); ++i) {
      C node = nodes.weight[i];
      for (const Entry<double>* entry : chromatic) node *= value(*entry, nodes.wavelength_um[i]);
      mean += node;
    }
    return rest * mean;
  };
}

void expect_promise(const System<double>& system, const SampleGrid& in, Border border, double tolerance) {
  const SampleGrid out = detector_grid(system, in);
  const Image scene = random_image(in.width, in.height, 31, 2.0);
  const PlanOptions options = options_for(scene, border, tolerance);
  const Plan plan = compile(system, in, out, options);
  EXPECT_GT(plan.report().wavelengths, 1);
  const Otf otf = band_otf(system);
  for (const Freq<double>& f : {Freq<double>{0.0, 0.0}, {11.0, -7.0}, {40.0, 3.0}}) {
    const Complex<double> h = system.otf(Stage::presample, f);
    ASSERT_LT(std::abs(otf(f.x, f.y) - C(h.re, h.im)), 1e-13);
  }
  const auto expected = reference_image(scene, in, out, otf, border);
  EXPECT_LE(rms_distance(run(plan, scene), expected) / options.scene->std, plan.report().predicted.total())
      << plan.explain();
}

System<double> band_system(double lo_um, double hi_um) {
  System<double> s = bare();
  s.optics.wavelength_um.reset();
  s.band = Band{lo_um, hi_um};
  s.band_nodes = 128;
  auto wavefront = Component<double>::make("rms_wavefront");
  set(wavefront, "rms", 0.08);
  set(wavefront, "wavelength_reference", 4.0);
  return with(s, {Component<double>::make("diffraction"), wavefront, footprint(12.0)});
}

TEST(PlanBand, product_of_chromatic_components_is_averaged_as_one) {
  for (const auto& [lo, hi] : {std::pair{3.4, 4.8}, {3.0, 12.0}})
    for (const double f_number : {2.0, 6.0})
      for (const double tolerance : {1e-3, 1e-5}) {
        System<double> s = band_system(lo, hi);
        s.optics.f_number = f_number;
        expect_promise(s, scene_grid(s, 32, 30, 2.0, 3.7), Border::reflect, tolerance);
        s.optics.obscuration = 0.4;
        expect_promise(s, scene_grid(s, 32, 30, 4.0, 2.0), Border::periodic, tolerance);
      }
}

TEST(PlanBand, mixes_with_components_that_are_not_radial) {
  for (const double tolerance : {1e-3, 1e-5}) {
    const System<double> s = with(band_system(3.4, 4.8), {motion(9.0, 30.0), rc(40.0, 0)});
    expect_promise(s, scene_grid(s, 30, 26, 2.0, 1.0), Border::reflect, tolerance);
    expect_promise(s, scene_grid(s, 30, 26, 3.0, M_PI), Border::replicate, tolerance);
  }
}

TEST(PlanBand, a_fixed_wavelength_is_not_averaged) {
  System<double> s = bare();
  s.optics.wavelength_um.reset();
  s.band = Band{3.4, 4.8};
  auto fixed = Component<double>::make("diffraction");
  set(fixed, "wavelength", 4.0);
  s.add(Stage::presample, fixed);
  const SampleGrid in = scene_grid(s, 24, 20, 2.0, 2.0);
  const Plan plan = compile(s, in, detector_grid(s, in), {});
  EXPECT_EQ(plan.report().wavelengths, 1);
  System<double> single = with(bare(), {Component<double>::make("diffraction")});
  const Image scene = random_image(24, 20, 1);
  EXPECT_TRUE(same_bits(run(plan, scene), run(compile(single, in, detector_grid(single, in), {}), scene)));
}

const Taps<double> kUneven{{0.05, 0.1, 0.0}, {-0.2, 0.9, 0.35}, {0.0, -0.05, 0.15}};

TEST(PlanPost, fir_is_the_spatial_convolution_with_the_border_rule) {
  for (const Taps<double>& taps : {kUneven, Taps<double>{{0.0, -0.25, 0.0}, {-0.25, 2.0, -0.25}, {0.0, -0.25, 0.0}},
                                   Taps<double>{{0.5, 0.0, 0.0, 0.0, 0.25}}, Taps<double>{{3.0}, {100.0}, {-7.0}}}) {
    System<double> system = bare();
    system.add(Stage::postsample, fir(taps));
    constexpr std::array stages{Stage::postsample};
    for (const auto& [width, height] : {std::pair<std::int64_t, std::int64_t>{20, 17}, {41, 36}, {1, 9}, {5, 1}})
      for (const Border border : kBorders) {
        const Image scene = random_image(width, height, 14, 4.0);
        const double border_value = 3.0;
        PlanOptions options = options_for(scene, border, 0.01, border_value);
        const Plan plan = compile_post(system, {width, height, 15.0, 12.0}, stages, options);
        const Image image = run(plan, scene, border_value);
        std::vector<double> expected;
        const auto jc = static_cast<std::int64_t>(taps.size() / 2), kc = static_cast<std::int64_t>(taps[0].size() / 2);
        for (std::int64_t y = 0; y < height; ++y)
          for (std::int64_t x = 0; x < width; ++x) {
            double sum = 0.0;
            for (std::int64_t j = 0; j < static_cast<std::int64_t>(taps.size()); ++j)
              for (std::int64_t k = 0; k < static_cast<std::int64_t>(taps[0].size()); ++k) {
                // The taps are the response to a point: tap k of it comes from the pixel k - kc to the left.
                const std::int64_t sx = border_source(border, x - (k - kc), width);
                const std::int64_t sy = border_source(border, y - (j - jc), height);
                sum += taps[static_cast<std::size_t>(j)][static_cast<std::size_t>(k)] *
                       (sx < 0 || sy < 0 ? border_value : static_cast<double>(scene.at(sx, sy)));
              }
            expected.push_back(sum);
          }
        const double rms = rms_distance(image, expected) / options.scene->std;
        EXPECT_LE(rms, plan.report().predicted.total()) << plan.explain();
        // Exact taps leave rounding only: of values up to the gain times the largest.
        EXPECT_LE(rms, 5e-7 * (taps.size() == 3 && taps[0].size() == 1 ? 110.0 : 3.0) *
                           (options.scene->largest / options.scene->std))
            << plan.explain();
      }
  }
}

TEST(PlanPost, readout_and_postsample_lists_equal_the_fourier_sums) {
  System<double> system = bare();
  system.add(Stage::readout, rc(60.0, 0));
  system.add(Stage::readout, test::gaussian(3.0));
  system.add(Stage::postsample, fir(kUneven));
  system.add(Stage::postsample, test::gaussian(5.0));
  system.add(Stage::presample, jitter(20.0));  // has to stay out of it
  constexpr std::array readout{Stage::readout};
  constexpr std::array post{Stage::postsample};
  constexpr std::array both{Stage::readout, Stage::postsample};
  for (const std::span<const Stage> stages : {std::span<const Stage>(readout), std::span<const Stage>(post),
                                              std::span<const Stage>(both), std::span<const Stage>()})
    for (const Border border : kBorders)
      for (const double tolerance : {1e-2, 1e-4}) {
        const SampleGrid grid{38, 33, 15.0, 12.0};
        const Image scene = random_image(38, 33, 6, 2.0);
        const PlanOptions options = options_for(scene, border, tolerance, 1.0);
        const Plan plan = compile_post(system, grid, stages, options);
        const auto otf = [&](double fx, double fy) {
          C product = 1.0;
          for (const Stage stage : stages) product *= otf_of(system, stage)(fx, fy);
          return product;
        };
        const auto expected = reference_image(scene, grid, grid, otf, border, 1.0);
        EXPECT_LE(rms_distance(run(plan, scene, 1.0), expected) / options.scene->std,
                  plan.report().predicted.total() + 1e-12)
            << plan.explain();
        EXPECT_LE(plan.report().predicted.total(), tolerance);
        EXPECT_EQ(plan.report().method == "identity", stages.empty());
      }
}

}  // namespace
}  // namespace mtf::test
