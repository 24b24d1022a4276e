// SPDX-License-Identifier: Apache-2.0
// The grid of a sampler against the product of components evaluated one by one.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "mtf/grid.h"
#include "mtf/otf/factored_otf.h"
#include "tests/expect_error.h"
#include "tests/mtf/builders.h"

namespace mtf::test {
namespace {

constexpr double kEnd = 66.0;

double worst_distance(const System<double>& system, const FactoredOtf& sampler, double end = kEnd,
                      std::int64_t samples = 96) {
  const FrequencyAxis axis{Basis::fourier, samples, 500.0 / end};
  const std::vector<double> fx = axis.half_frequencies(), fy = axis.all_frequencies();
  const FactoredOtf::Grid grid(sampler, fx, fy);
  std::vector<Complex<float>> row(fx.size());
  std::vector<float> real(fx.size());
  double worst = 0.0;
  for (std::size_t j = 0; j < fy.size(); ++j) {
    grid.complex_row(j, row);
    if (sampler.is_real()) grid.real_row(j, real);
    for (std::size_t i = 0; i < fx.size(); ++i) {
      Complex<double> exact{1.0, 0.0};
      for (const Stage stage : kStages) exact = exact * system.otf(stage, {fx[i], fy[j]});
      worst = std::max(worst, std::hypot(row[i].re - exact.re, row[i].im - exact.im));
      if (sampler.is_real()) worst = std::max(worst, std::abs(real[i] - exact.re));
    }
  }
  return worst;
}

Component<double> vibration(double amplitude_um, double direction_deg) {
  auto c = Component<double>::make("vibration");
  set(c, "amplitude", amplitude_um, "um");
  set(c, "direction", direction_deg);
  return c;
}

Component<double> crosstalk(double side, double corner) {
  auto c = Component<double>::make("crosstalk");
  set(c, "side", side);
  set(c, "corner", corner);
  return c;
}

TEST(Sampler, motion_at_an_angle_is_one_table_along_its_direction) {
  for (const double travel_um : {0.5, 8.0, 150.0})
    for (const double direction_deg : {-120.0, 0.1, 30.0, 45.0, 70.0}) {
      System<double> system = mwir();
      system.add(Stage::presample, motion(travel_um, direction_deg));
      system.add(Stage::presample, vibration(0.4 * travel_um, -direction_deg));
      const FactoredOtf sampler(system, kStages, {}, {.fx_max = kEnd, .fy_max = kEnd, .table_share = 1e-6});
      EXPECT_TRUE(says(sampler.merged(), "linear_motion -> one table along its direction"));
      EXPECT_LE(worst_distance(system, sampler), sampler.error() + 3e-7) << travel_um << " um " << direction_deg;
      EXPECT_LE(sampler.error(), 5e-5);
    }
}

TEST(Sampler, motion_too_long_for_a_table_is_evaluated_at_every_frequency) {
  System<double> system = mwir();
  system.add(Stage::presample, motion(1e6, 30.0));
  const FactoredOtf sampler(system, kStages, {}, {.fx_max = kEnd, .fy_max = kEnd, .table_share = 1e-6});
  EXPECT_FALSE(says(sampler.merged(), "direction"));
  EXPECT_LE(worst_distance(system, sampler), sampler.error() + 3e-7);
}

TEST(Sampler, filters_and_crosstalk_are_evaluated_a_row_at_a_time) {
  System<double> system = mwir();
  system.add(Stage::readout, crosstalk(0.03, 0.01));
  system.add(Stage::postsample, fir({{0.0, -0.2, 0.1}, {-0.1, 1.4, -0.2}, {0.05, -0.1, 0.05}}));
  system.add(Stage::postsample, fir({{0.0, -0.2, 0.0}, {-0.1, 1.6, -0.1}, {0.0, -0.2, 0.0}}));
  system.add(Stage::readout, rc(50.0, 1));
  const FactoredOtf sampler(system, kStages, {}, {.fx_max = kEnd, .fy_max = kEnd, .table_share = 1e-6});
  EXPECT_LE(worst_distance(system, sampler), sampler.error() + 1e-6);
}

TEST(Sampler, the_number_of_wavelengths_can_be_given) {
  System<double> system = mwir();
  system.band = Band{3.4, 4.8};
  system.band_nodes = 64;
  const FactoredOtf given(system, kStages, {},
                          {.fx_max = kEnd, .fy_max = kEnd, .table_share = 1e-6, .wavelengths = 17});
  EXPECT_EQ(given.wavelengths(), 17);
  EXPECT_LE(worst_distance(system, given), given.error() + 3e-7);
}

Component<double> coma(double waves, double obscuration) {
  auto c = Component<double>::make("wavefront");
  set(c, "w131", waves);
  set(c, "w040", 0.5 * waves);
  set(c, "w222", 0.4 * waves);
  set(c, "orientation", 20.0);
  set(c, "obscuration", obscuration);
  return c;
}

System<double> aberrated(double waves, double obscuration) {
  System<double> system = mwir();
  system.list(Stage::presample).front().component = coma(waves, obscuration);
  return system;
}

std::vector<Complex<float>> values(const FactoredOtf& sampler) {
  const FrequencyAxis axis{Basis::fourier, 48, 500.0 / kEnd};
  const std::vector<double> fx = axis.half_frequencies(), fy = axis.all_frequencies();
  const FactoredOtf::Grid grid(sampler, fx, fy);
  std::vector<Complex<float>> all(fx.size() * fy.size());
  for (std::size_t j = 0; j < fy.size(); ++j) grid.complex_row(j, std::span(all).subspan(j * fx.size(), fx.size()));
  return all;
}

// What an earlier sampler has tabulated serves where it is the same: no value changes by that, whatever is different.
TEST(Sampler, tables_of_an_earlier_one_are_those_that_would_be_made) {
  const auto band = [](System<double> system) {
    system.band = Band{3.4, 4.8};
    return system;
  };
  const auto with = [](System<double> system, Component<double> component) {
    system.add(Stage::presample, std::move(component));
    return system;
  };
  System<double> slower = band(mwir());
  slower.optics.f_number = 1.5 * slower.optics.f_number.value();
  const std::vector<System<double>> systems{band(mwir()),
                                            with(band(mwir()), gaussian(3.0)),
                                            with(band(mwir()), motion(8.0, 30.0)),
                                            slower,
                                            mwir(),
                                            aberrated(0.3, 0.0),
                                            with(aberrated(0.3, 0.0), gaussian(3.0)),
                                            aberrated(0.4, 0.0),
                                            band(aberrated(0.3, 0.0)),
                                            with(band(aberrated(0.3, 0.0)), gaussian(3.0))};
  std::atomic<std::int64_t> made = 0;
  const SamplerOptions options{
      .fx_max = kEnd, .fy_max = kEnd, .table_share = 1e-6, .progress = [&](std::int64_t count) { made += count; }};
  std::vector<std::unique_ptr<const FactoredOtf>> alone;
  for (const System<double>& system : systems)
    alone.push_back(std::make_unique<const FactoredOtf>(system, kStages, SceneAperture{}, options));
  for (std::size_t before = 0; before < systems.size(); ++before)
    for (std::size_t i = 0; i < systems.size(); ++i) {
      const FactoredOtf sampler(systems[i], kStages, {}, options, alone[before].get());
      EXPECT_EQ(sampler.error(), alone[i]->error());
      EXPECT_EQ(sampler.wavelengths(), alone[i]->wavelengths());
      EXPECT_EQ(sampler.merged(), alone[i]->merged());
      const auto a = values(sampler), b = values(*alone[i]);
      EXPECT_TRUE(
          std::equal(a.begin(), a.end(), b.begin(),
                     [](const Complex<float>& x, const Complex<float>& y) { return x.re == y.re && x.im == y.im; }))
          << before << " before " << i;
    }
  // Another blur: the slow values of the pupil are there.
  EXPECT_GT(made.exchange(0), 0);
  const FactoredOtf blurred(systems[9], kStages, {}, options, alone[8].get());
  EXPECT_EQ(made, 0);
}

TEST(Sampler, aberrated_pupils_are_one_table_over_radius_and_direction) {
  for (const double obscuration : {0.0, 0.3})
    for (const double waves : {0.05, 1.0})
      for (const double end : {30.0, 66.0, 150.0}) {  // the cutoff is 125 cycles/mm
        const System<double> system = aberrated(waves, obscuration);
        const FactoredOtf sampler(system, kStages, {}, {.fx_max = end, .fy_max = end, .table_share = 1e-6});
        EXPECT_TRUE(says(sampler.merged(), "one table over radius and direction"));
        EXPECT_FALSE(sampler.is_real());
        EXPECT_LE(worst_distance(system, sampler, end, 32), sampler.error() + 3e-7)
            << waves << " " << obscuration << " " << end;
        EXPECT_LE(sampler.error(), 2e-5);
        EXPECT_EQ(sampler.axis_bound(Axis::x, 126.0), 0.0);
      }
  const FactoredOtf few(aberrated(0.4, 0.0), kStages, {},
                        {.fx_max = kEnd, .fy_max = kEnd, .table_share = 1e-6, .samples = 500});
  EXPECT_FALSE(says(few.merged(), "direction"));
}

TEST(Sampler, a_band_of_aberrated_pupils_is_averaged_before_it_is_tabulated) {
  System<double> system = aberrated(0.3, 0.25);
  system.band = Band{3.4, 4.8};
  system.band_nodes = 32;
  const FactoredOtf sampler(system, kStages, {}, {.fx_max = kEnd, .fy_max = kEnd, .table_share = 1e-5});
  EXPECT_TRUE(says(sampler.merged(), "one table over radius and direction"));
  EXPECT_LE(worst_distance(system, sampler, kEnd, 20), sampler.error() + 3e-7);
  EXPECT_LE(sampler.error(), 2e-4);
}

}  // namespace
}  // namespace mtf::test
