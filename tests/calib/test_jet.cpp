// SPDX-License-Identifier: Apache-2.0
// Derivatives that the component bodies carry, against differences of the double version.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <set>

#include "calib/fit/system_jet.h"
#include "tests/mtf/conformance.h"

namespace calib {
namespace {

using mtf::Complex;
using mtf::System;
using mtf::test::Case;
using mtf::test::conformance_cases;
using mtf::test::only_component;
using mtf::test::scalars_of;

/// What a derivative is taken by: a scalar of the component, or of its surroundings.
struct Parameter {
  std::string name;
  double lo = 0.0, hi = 0.0;
};

/// The scalars of the component, then focal length, both pitches, wavelength, and the two frequencies.
template <class S>
std::vector<S*> addresses(System<S>& system, mtf::Freq<S>& f) {
  std::vector<S*> all;
  for (const auto& scalar : scalars_of(only_component(system))) all.push_back(scalar.value);
  for (S* s : {&system.frame.focal_length_mm, &system.frame.pitch_x_um, &system.frame.pitch_y_um,
               &*system.optics.wavelength_um, &*system.optics.f_number, &*system.optics.obscuration, &f.x, &f.y})
    all.push_back(s);
  return all;
}

std::vector<Parameter> parameters(const Case& c) {
  System<double> system = c.system;
  std::vector<Parameter> all;
  for (const auto& scalar : scalars_of(only_component(system)))
    all.push_back({scalar.name, scalar.info->lo, scalar.info->hi});
  for (const char* name : {"focal_length", "pitch_x", "pitch_y", "optics.wavelength", "optics.f_number"})
    all.push_back({name, 1e-3, 1e5});
  all.push_back({"optics.obscuration", 0.0, 1.0});
  for (const char* name : {"fx", "fy"}) all.push_back({name, -1e300, 1e300});
  return all;
}

Complex<double> value_at(const Case& c, const mtf::Freq<double>& f, std::size_t index, double value) {
  System<double> system = c.system;
  mtf::Freq<double> g = f;
  *addresses(system, g)[index] = value;
  return only_component(system).otf(g, system.context());
}

struct Gradient {
  Complex<double> value;
  Complex<double> slope;
};

Gradient gradient(const System<Jet4>& from, const mtf::Freq<double>& f, std::size_t index) {
  System<Jet4> system = from;
  mtf::Freq<Jet4> g{Jet4(f.x), Jet4(f.y)};
  addresses(system, g)[index]->v[2] = 1.0;
  const Complex<Jet4> h = only_component(system).otf(g, system.context());
  EXPECT_EQ(h.re.v[0], 0.0);  // derivatives keep their slots
  return {{h.re.a, h.im.a}, {h.re.v[2], h.im.v[2]}};
}

double norm(const Complex<double>& z) { return std::hypot(z.re, z.im); }
Complex<double> combine(double a, const Complex<double>& x, double b, const Complex<double>& y) {
  return {a * x.re + b * y.re, a * x.im + b * y.im};
}

/// Difference quotient, second order; one-sided (`side` +1, -1) or central (0).
Complex<double> difference(const Case& c, const mtf::Freq<double>& f, std::size_t index, double at, double h,
                           int side) {
  const auto v = [&](double x) { return value_at(c, f, index, x); };
  if (side == 0) return combine(0.5 / h, v(at + h), -0.5 / h, v(at - h));
  const double s = side * h;
  const Complex<double> near = combine(-1.5 / s, v(at), 2.0 / s, v(at + s));
  return combine(1.0, near, -0.5 / s, v(at + 2.0 * s));
}

/// Small values next to a bound have no scale of their own; the example's is used, where it is a small plain number.
double smallest_scale(const Case& c, std::size_t index) {
  System<double> system = c.system;
  const auto scalars = scalars_of(only_component(system));
  if (index >= scalars.size() || scalars[index].info->dimension != mtf::Dimension::none) return 1e-2;
  const double example = std::strtod(std::string(scalars[index].info->example).c_str(), nullptr);
  return example > 0.0 ? std::min(example, 1e-2) : 1e-2;
}

/// The component as it is, but for one scalar: still something that check() accepts?
bool accepted(const Case& c, std::size_t index, double value) {
  System<double> system = c.system;
  *scalars_of(only_component(system))[index].value = value;
  for (const mtf::Problem& p : only_component(system).check(system.context()))
    if (p.error) return false;
  return true;
}

/// Compares where the difference quotient itself has converged (not across kinks); true when it had.
bool compare(const Case& c, const mtf::Freq<double>& f, std::size_t index, double at, int side) {
  Case moved = c;
  mtf::Freq<double> g = f;
  *addresses(moved.system, g)[index] = at;
  const Gradient jet = gradient(mtf::cast<Jet4>(moved.system), g, index);
  EXPECT_TRUE(std::isfinite(jet.slope.re) && std::isfinite(jet.slope.im)) << c.name;
  // 1e-14 but for pupil quadrature: 1e-13, 2e-15 / (1 - e^2) for obscurations up to 0.999, and mirrored frequencies are
  // folded only without derivatives.
  EXPECT_LE(norm(combine(1.0, jet.value, -1.0, value_at(c, f, index, at))), 1e-12) << c.name;
  const double scale = std::max(std::abs(at), smallest_scale(c, index)), h = (side == 0 ? 2.173e-5 : 1.071e-5) * scale;
  const Complex<double> wide = difference(c, f, index, at, h, side),
                        narrow = difference(c, f, index, at, 0.618 * h, side);
  const double tolerance = 1e-6 * (norm(wide) + 0.01 / scale);
  if (!(norm(combine(1.0, wide, -1.0, narrow)) < 0.3 * tolerance)) return false;
  EXPECT_LE(norm(combine(1.0, jet.slope, -1.0, narrow)), tolerance)
      << c.name << " f = " << g.x << ", " << g.y << " at " << at << " side " << side << ": " << jet.slope.re << " "
      << jet.slope.im << " against " << narrow.re << " " << narrow.im;
  return true;
}

constexpr std::array<mtf::Freq<double>, 8> kFrequencies{
    {{3e-7, 0.0}, {0.2, -0.1}, {5.0, 3.0}, {-21.7, 4.4}, {33.0, 33.0}, {0.0, 47.0}, {61.0, 1e-3}, {150.0, 80.0}}};

TEST(Jet, gradient_equals_central_difference) {
  std::size_t compared = 0, tried = 0;
  for (const Case& c : conformance_cases()) {
    if (!c.typical) continue;
    const auto list = parameters(c);
    for (std::size_t i = 0; i < list.size(); ++i) {
      std::size_t converged = 0;
      for (const mtf::Freq<double>& f : kFrequencies) {
        System<double> system = c.system;
        mtf::Freq<double> g = f;
        const double at = *addresses(system, g)[i];
        ++tried;
        converged += compare(c, f, i, at, 0) ? 1 : 0;
      }
      EXPECT_GE(converged, kFrequencies.size() - 2) << c.name << " by " << list[i].name;
      compared += converged;
    }
  }
  EXPECT_GT(compared, 1000u);
  EXPECT_GT(10 * compared, 9 * tried);
}

TEST(Jet, gradient_at_bounds_equals_one_sided_difference) {
  std::set<std::string> compared;
  for (const Case& c : conformance_cases()) {
    if (!c.name.ends_with("#0")) continue;
    System<double> system = c.system;
    const auto scalars = scalars_of(only_component(system));
    for (std::size_t i = 0; i < scalars.size(); ++i) {
      const mtf::FieldInfo& info = *scalars[i].info;
      // A bound of 1e9 um or 1e15 um/s is seen at a frequency where the component is not yet gone.
      for (const mtf::Freq<double>& f : {mtf::Freq<double>{1e-7, 5e-8}, {1e-4, 2e-5}, {0.3, 0.1}, {12.0, 7.0}}) {
        const bool low = !info.lo_open && accepted(c, i, info.lo) && compare(c, f, i, info.lo, 1),
                   high = !info.hi_open && accepted(c, i, info.hi) && compare(c, f, i, info.hi, -1);
        if (low) compared.insert(std::string(only_component(c.system).kind()) + "." + scalars[i].name + ".lo");
        if (high) compared.insert(std::string(only_component(c.system).kind()) + "." + scalars[i].name + ".hi");
      }
    }
  }
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

// At f = 0 every OTF is 1 whatever its parameters (a filter: the sum of its taps).
TEST(Jet, zero_frequency) {
  for (const Case& c : conformance_cases()) {
    const auto list = parameters(c);
    const System<Jet4> jets = mtf::cast<Jet4>(c.system);
    for (std::size_t i = 0; i + 2 < list.size(); ++i) {
      const Gradient g = gradient(jets, {0.0, 0.0}, i);
      EXPECT_NEAR(g.slope.re, list[i].name == "taps[]" ? 1.0 : 0.0, 1e-14) << c.name << " by " << list[i].name;
      EXPECT_EQ(g.slope.im, 0.0) << c.name << " by " << list[i].name;
    }
    if (!c.typical) continue;
    // No slope at the centre (a tip counts as none); one-sided ones turn the phase at once.
    const bool real = only_component(c.system).traits(c.system.context()).real;
    for (const std::size_t axis : {list.size() - 2, list.size() - 1}) {
      const Gradient g = gradient(jets, {0.0, 0.0}, axis);
      EXPECT_NEAR(g.slope.re, 0.0, 1e-12) << c.name;
      if (real) {
        EXPECT_NEAR(g.slope.im, 0.0, 1e-12) << c.name;
      }
    }
  }
}

TEST(Jet, at_and_beyond_the_cutoff) {
  for (const Case& c : conformance_cases()) {
    const auto list = parameters(c);
    const System<Jet4> jets = mtf::cast<Jet4>(c.system);
    const double cutoff = only_component(c.system).cutoff_cy_mm(c.system.context());
    if (!std::isfinite(cutoff)) continue;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Gradient beyond = gradient(jets, {cutoff * 1.001, 0.0}, i);
      EXPECT_EQ(beyond.slope.re, 0.0) << c.name << " by " << list[i].name;
      if (!c.typical) continue;
      // The MTF ends like (1 - nu)^1.5, so its slope ends in 0.
      System<double> copy = c.system;
      mtf::Freq<double> f{cutoff, 0.0};
      const double scale = std::max(1.0, std::abs(*addresses(copy, f)[i]));
      EXPECT_LE(std::abs(gradient(jets, {cutoff, 0.0}, i).slope.re) * scale, 1e-4) << c.name << " by " << list[i].name;
    }
  }
}

TEST(Jet, finite_over_the_whole_box) {
  for (const Case& c : conformance_cases()) {
    const auto list = parameters(c);
    const System<Jet4> jets = mtf::cast<Jet4>(c.system);
    for (std::size_t i = 0; i < list.size(); ++i)
      for (const double x : {0.0, 5e-324, 1e-300, 1e-9, 0.1, 20.0, 1e4, 1e30, 1e300})
        for (const double y : {0.0, -x, 33.0}) {
          const Gradient g = gradient(jets, {x, y}, i);
          EXPECT_FALSE(std::isnan(g.slope.re) || std::isnan(g.slope.im))
              << c.name << " by " << list[i].name << " at " << x;
        }
  }
}

// Where u^(n - 1) or 1/u of a formula would be infinite, or their product with 0 no number.
TEST(Jet, finite_at_zero_and_the_smallest_frequencies) {
  for (const Case& c : conformance_cases()) {
    const auto list = parameters(c);
    const System<Jet4> jets = mtf::cast<Jet4>(c.system);
    for (std::size_t i = 0; i < list.size(); ++i)
      for (const mtf::Freq<double>& f :
           {mtf::Freq<double>{0.0, 0.0}, {5e-324, 0.0}, {0.0, -5e-324}, {5e-324, 5e-324}, {-1e-310, 0.0}}) {
        const Gradient g = gradient(jets, f, i);
        EXPECT_TRUE(std::isfinite(g.slope.re) && std::isfinite(g.slope.im))
            << c.name << " by " << list[i].name << " at " << f.x << ", " << f.y << ": " << g.slope.re;
      }
  }
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
