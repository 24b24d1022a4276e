// SPDX-License-Identifier: Apache-2.0
// Derivatives that the component bodies carry, against differences of the double version.
#include <gtest/gtest.h>

#include <set>

#include "calib/fit/system_jet.h"
#include "mtf/components/conformance/conformance.h"
#include "mtf/components/gaussian.h"
#include "tests/mtf/conformance.h"

namespace calib {
namespace {

using mtf::Complex;
using mtf::System;
using mtf::test::Case;
using mtf::test::conformance_cases;
using mtf::test::only_component;
namespace conformance = mtf::conformance;
using conformance::Outcome;

using JetPair = conformance::Pair<Jet4, mtf::Component<double>, mtf::Component<Jet4>>;

/// The case over double and over Jet4.
JetPair pair_of(const Case& c) {
  return {mtf::test::subject_of(c, c.system), mtf::test::subject_of(c, mtf::cast<Jet4>(c.system))};
}

/// Every case has the property, or one in `step`.
void expect_of_all(void (*check)(const JetPair&, Outcome&), std::size_t step = 1) {
  Outcome outcome;
  for (std::size_t i = 0; i < conformance_cases().size(); i += step) check(pair_of(conformance_cases()[i]), outcome);
  EXPECT_EQ(conformance::describe_failures({outcome}), "");
  EXPECT_GT(outcome.compared, 0u);
}

TEST(Jet, gradient_equals_central_difference) {
  Outcome outcome;
  std::size_t converged = 0, tried = 0;
  for (const Case& c : conformance_cases()) {
    if (!c.typical) continue;
    const conformance::Quotients quotients = conformance::gradient_equals_difference(pair_of(c), outcome);
    converged += quotients.converged;
    tried += quotients.tried;
  }
  EXPECT_EQ(conformance::describe_failures({outcome}), "");
  EXPECT_GT(converged, 1000u);
  EXPECT_GT(10 * converged, 9 * tried);
}

TEST(Jet, gradient_at_bounds_equals_one_sided_difference) {
  Outcome outcome;
  std::set<std::string> compared;
  for (const Case& c : conformance_cases()) {
    if (!c.name.ends_with("#0")) continue;
    for (const std::string& bound : conformance::gradient_at_bounds(pair_of(c), outcome))
      compared.insert(std::string(only_component(c.system).kind()) + "." + bound);
  }
  EXPECT_EQ(conformance::describe_failures({outcome}), "");
  for (const char* bound : {"diffraction.obscuration.lo",
                            "diffraction.f_number.lo",
                            "diffraction.wavelength.hi",
                            "footprint.width.lo",
                            "footprint.fill_factor.hi",
                            "gaussian.sigma.lo",
                            "jitter.rms.lo",
                            "linear_motion.travel.lo",
                            "linear_motion.rate.lo",
                            "linear_motion.direction.hi",
                            "rms_wavefront.rms.lo",
                            "fir.taps[].lo",
                            "rc_lowpass.cutoff.hi",
                            "butterworth.cutoff.hi",
                            "charge_transfer.inefficiency.lo",
                            "crosstalk.side.lo",
                            "crosstalk.corner.hi",
                            "tdi.slip.lo",
                            "diffusion.depletion_depth.lo",
                            "diffusion.diffusion_length.hi",
                            "bolometer.time_constant.lo",
                            "vibration.amplitude.lo",
                            "turbulence.fried_parameter.hi",
                            "turbulence.alpha.lo",
                            "circular_footprint.diameter.lo",
                            "rc_highpass.cutoff.hi",
                            "rc_highpass.scan_velocity.hi",
                            "rc_lowpass.pixel_clock.hi",
                            "unsharp.amount.lo",
                            "unsharp.sigma.hi",
                            "interpolation.a.lo",
                            "display_crt.sigma.lo",
                            "display_flat_panel.lcd_pitch.lo",
                            "eye.magnification.hi",
                            "eye.luminance.lo",
                            "eye.luminance.hi",
                            "eye.field.lo",
                            "turbulence.wind.lo",
                            "accelerated_motion.velocity.lo",
                            "aerosol.scattering.lo",
                            "binning.spacing.lo",
                            "polygon_footprint.unit_length.lo",
                            "random_wavefront.rms.lo",
                            "vibration.phase.hi"})
    EXPECT_TRUE(compared.contains(bound)) << bound;
}

TEST(Jet, zero_frequency) { expect_of_all(conformance::gradient_at_zero_frequency); }

TEST(Jet, at_and_beyond_the_cutoff) { expect_of_all(conformance::gradient_at_and_beyond_the_cutoff); }

TEST(Jet, finite_over_the_whole_range) { expect_of_all(conformance::gradient_is_never_nan, 5); }
TEST(JetLong, finite_over_the_whole_range) { expect_of_all(conformance::gradient_is_never_nan); }

TEST(Jet, finite_at_zero_and_the_smallest_frequencies) {
  expect_of_all(conformance::gradient_is_finite_at_and_near_zero);
}

/// A Gaussian of a width in um, not in the list of components, whose derivative by the width is lost where `lost`.
template <class S, bool lost>
struct Blur : mtf::Gaussian<S> {
  mtf::Complex<S> otf(const mtf::Freq<S>& f, const mtf::Context<S>& ctx) const {
    const mtf::Complex<S> h = mtf::Gaussian<S>::otf(f, ctx);
    return {lost ? S(mtf::value_of(h.re)) : h.re, h.im};
  }
};
template <class S>
using Right = Blur<S, false>;
template <class S>
using WithoutSlope = Blur<S, true>;

TEST(Jet, check_of_an_own_component_compares_derivatives) {
  const auto right = conformance::check<Right, Jet4>();
  EXPECT_EQ(conformance::describe_failures(right), "");
  EXPECT_EQ(right.size(), conformance::check<Right>().size() + 6u);
  EXPECT_EQ((conformance::check<Right, ceres::Jet<double, 1>>().size()), right.size());
  std::set<std::string> failed;
  for (const Outcome& outcome : conformance::check<WithoutSlope, Jet4>())
    if (!outcome.ok()) failed.insert(outcome.property);
  EXPECT_EQ(failed, (std::set<std::string>{"gradient equals difference", "gradient at bounds"}));
}

TEST(Jet, system_gradient_is_the_product_rule) {
  System<double> system;
  system.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  system.optics.f_number = 2.0;
  system.optics.obscuration = 0.3;
  system.band = mtf::Band{3.4, 4.8};
  system.band_nodes = 16;
  system.add(mtf::Stage::presample, mtf::Component<double>::make("diffraction"));
  auto jitter = mtf::Component<double>::make("jitter");
  *std::get<mtf::AxisPair<double>*>(jitter.fields().front().value) = {{20.0, mtf::find_unit("urad")}, {}, false};
  system.add(mtf::Stage::presample, jitter);
  const auto value = [&](double f_number, double focal) {
    System<double> s = system;
    s.optics.f_number = f_number;
    s.frame.focal_length_mm = focal;
    return s.otf({18.0, -11.0}).re;
  };
  System<Jet4> jets = mtf::cast<Jet4>(system);
  jets.optics.f_number->v[0] = 1.0;
  jets.frame.focal_length_mm.v[1] = 1.0;
  const Complex<Jet4> h = jets.otf({Jet4(18.0), Jet4(-11.0)});
  EXPECT_NEAR(h.re.a, value(2.0, 100.0), 1e-15);
  EXPECT_NEAR(h.re.v[0], (value(2.0 + 1e-5, 100.0) - value(2.0 - 1e-5, 100.0)) / 2e-5, 1e-9);
  EXPECT_NEAR(h.re.v[1], (value(2.0, 100.001) - value(2.0, 99.999)) / 2e-3, 1e-9);
  EXPECT_LT(h.re.v[0], -0.01);
  EXPECT_LT(h.re.v[1], -1e-4);
  const System<double> back = mtf::cast<double>(jets);
  EXPECT_EQ(back.otf({18.0, -11.0}).re, value(2.0, 100.0));
}

}  // namespace
}  // namespace calib
