// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/plan/plan.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> aerosol(bool blur) {  // optical depth 0.5
  auto c = Component<double>::make("aerosol");
  set(c, "scattering", 0.1);
  set(c, "path_length", 5.0);
  choose(c, "mode", blur ? 1 : 0);
  return c;
}

TEST(Aerosol, contrast_is_the_unscattered_fraction_everywhere_but_at_zero) {
  EXPECT_EQ(otf_at(aerosol(false), 0.0, 0.0).re, 1.0);
  for (const double f : {5e-324, 1e-9, 1.0, 300.0, 1e300})
    EXPECT_NEAR(otf_at(aerosol(false), 0.0, f).re, 0.6065306597126334, 1e-16) << f;
}

// uc = 100 um / 4 um = 25 cy/rad = 0.25 cy/mm at 100 mm.
TEST(Aerosol, blur_falls_to_the_same_contrast) {
  auto c = aerosol(true);
  set(c, "particle_radius", 100.0);
  EXPECT_NEAR(otf_at(c, 0.1, 0.0).re, std::exp(-0.5 * 0.16), 1e-15);
  EXPECT_NEAR(otf_at(c, 0.15, 0.2).re, std::exp(-0.5), 1e-15);
  EXPECT_NEAR(otf_at(c, 0.25 * (1.0 - 1e-12), 0.0).re, otf_at(aerosol(false), 1.0, 0.0).re, 1e-12);
  EXPECT_EQ(otf_at(c, 40.0, 0.0).re, otf_at(aerosol(false), 1.0, 0.0).re);
  auto same = aerosol(true);
  set(same, "cutoff", 0.025, "cy/mrad");
  EXPECT_NEAR(otf_at(same, 0.1, 0.1).re, otf_at(c, 0.1, 0.1).re, 1e-15);
}

// The mean of the scene stays, its contrast shrinks: exactly, whatever the plan does with factors of |f|.
TEST(Aerosol, in_an_image) {
  System<double> s = detector(10.0, 10.0);
  s.add(Stage::presample, aerosol(false));
  Image in(16, 12), out(16, 12);
  double mean = 0.0;
  for (std::int64_t i = 0; i < in.size(); ++i) {
    in.data()[i] = static_cast<float>((i * 37 + 11) % 64);
    mean += static_cast<double>(in.data()[i]) / static_cast<double>(in.size());
  }
  PlanOptions options;
  options.tolerance = 1e-5;
  options.scene = summarise(in.view(), options.border, 0.0);
  compile(s, {16, 12, 10.0, 10.0}, {16, 12, 10.0, 10.0}, options).run(in.view(), out.view(), 0.0, 1);
  for (std::int64_t i = 0; i < in.size(); ++i)
    EXPECT_NEAR(out.data()[i], mean + std::exp(-0.5) * (static_cast<double>(in.data()[i]) - mean), 2e-4) << i;
}

TEST(Aerosol, refusals) {
  EXPECT_TRUE(refused(aerosol(true), "cutoff"));
  auto c = aerosol(false);
  set(c, "particle_radius", 5.0);
  EXPECT_TRUE(refused(c, "particle_radius"));
  choose(c, "mode", 1);
  EXPECT_FALSE(refused(c, "particle_radius"));
  set(c, "cutoff", 1.0, "cy/mrad");
  EXPECT_TRUE(refused(c, "cutoff"));
}

// Without numbers of its own it takes those of the system's path; one without a path is refused.
TEST(Aerosol, TakesThePathOfTheSystem) {
  for (const bool own_scattering : {false, true}) {
    Component<double> component = Component<double>::make("aerosol");
    if (own_scattering) set(component, "scattering", 0.1);
    System<double> system;
    system.frame = {.focal_length_mm = 100.0, .pitch_x_um = 15.0, .pitch_y_um = 15.0};
    system.optics.wavelength_um = 4.0;
    system.add(Stage::presample, std::move(component));
    const Entry<double>& entry = system.list(Stage::presample).front();
    EXPECT_FALSE(entry.component.check(system.context()).empty());
    system.air = {.path_length_m = 5000.0, .scattering = 0.5};
    for (const Problem& problem : entry.component.check(system.context()))
      ADD_FAILURE() << problem.field << ": " << problem.text;
    EXPECT_NEAR(system.otf(entry, {3.0, 0.0}).re, std::exp(-0.5), 1e-15);
    EXPECT_NEAR(cast<float>(system).otf(Stage::presample, {3.0F, 0.0F}).re, std::exp(-0.5F), 1e-7F);
  }
}

}  // namespace
}  // namespace mtf::test
