// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "mtf/components/pupil/pupil.h"
#include "mtf/error.h"
#include "mtf/otf/system_impl.h"
#include "tests/expect_error.h"
#include "tests/mtf/builders.h"

namespace mtf::test {
namespace {

System<double> whole_chain() {
  System<double> s = mwir();
  s.add(Stage::readout, rc(40.0, 0));
  s.add(Stage::postsample, fir({{0, -0.25, 0}, {-0.25, 2.0, -0.25}, {0, -0.25, 0}}));
  return s;
}

TEST(System, otf_is_the_product_of_what_is_listed) {
  const System<double> s = whole_chain();
  for (const Freq<double>& f : {Freq<double>{0.0, 0.0}, {11.0, -7.0}, {33.0, 20.0}, {-60.0, 90.0}}) {
    Complex<double> product{1.0, 0.0};
    for (const Stage stage : kStages) {
      Complex<double> part{1.0, 0.0};
      for (const auto& entry : s.list(stage)) part = part * s.otf(entry, f);
      EXPECT_NEAR(s.otf(stage, f).re, part.re, 1e-15);
      EXPECT_NEAR(s.otf(stage, f).im, part.im, 1e-15);
      product = product * part;
    }
    EXPECT_NEAR(s.otf(f).re, product.re, 1e-15);
    EXPECT_NEAR(s.otf(f).im, product.im, 1e-15);
  }
}

TEST(System, nothing_is_implied) {
  System<double> s;
  s.frame = {100.0, 15.0, 15.0, 0.01, 640, 512};
  s.optics.f_number = 2.0;
  s.band = Band{3.4, 4.8};
  EXPECT_EQ(s.otf({500.0, 80.0}).re, 1.0);
  EXPECT_TRUE(s.check().empty());
}

TEST(System, multiply_equals_pointwise) {
  const System<double> s = whole_chain();
  const std::vector<Freq<double>> f{{0.0, 0.0}, {5.0, 1.0}, {40.0, -3.0}};
  for (const Stage stage : kStages)
    for (const auto& entry : s.list(stage)) {
      std::vector<Complex<double>> h(f.size(), Complex<double>{2.0, 1.0});
      entry.component.multiply(f, s.context(), h);
      for (std::size_t i = 0; i < f.size(); ++i) {
        const Complex<double> one = Complex<double>{2.0, 1.0} * s.otf(entry, f[i]);
        EXPECT_EQ(h[i].re, one.re);
        EXPECT_EQ(h[i].im, one.im);
      }
    }
}

// The product of the chromatic factors is averaged, by an independent rule: many midpoints.
TEST(System, band_average_of_the_product) {
  System<double> s = mwir();
  s.optics.wavelength_um.reset();
  s.band = Band{3.4, 4.8};
  auto rms = Component<double>::make("rms_wavefront");
  set(rms, "rms", 0.1);
  set(rms, "wavelength_reference", 4.0);
  s.add(Stage::presample, rms);
  const double f = 60.0;
  double mean = 0.0, diffraction = 0.0, wavefront = 0.0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double wavelength = 3.4 + 1.4 * (i + 0.5) / n, nu = f * wavelength * 2e-3, w = 0.1 * 4.0 / wavelength / 0.18;
    const double d = circular_pupil_mtf(nu).value, a = 1.0 - 4.0 * w * w * nu * (1.0 - nu);
    mean += d * a / n, diffraction += d / n, wavefront += a / n;
  }
  const double rest = s.otf(s.list(Stage::presample)[1], {f, 0.0}).re * s.otf(s.list(Stage::presample)[2], {f, 0.0}).re;
  EXPECT_NEAR(s.otf({f, 0.0}).re, mean * rest, 1e-11);
  EXPECT_GT(std::abs(mean - diffraction * wavefront), 1e-3);  // the two ways differ by much more than the rule's error
  EXPECT_NEAR(s.otf(s.list(Stage::presample)[0], {f, 0.0}).re, diffraction, 1e-11);
  EXPECT_NEAR(s.otf({0.0, 0.0}).re, 1.0, 1e-14);
}

TEST(System, band_nodes_integrate_polynomials) {
  for (const int n : {1, 2, 5, 16, 64, 512}) {
    const WavelengthNodes nodes = wavelength_nodes({3.0, 5.0}, n);
    const int degree = std::min(2 * n - 1, 21);
    double sum = 0.0, moment = 0.0;
    for (std::size_t i = 0; i < nodes.weight.size(); ++i) {
      EXPECT_GT(nodes.weight[i], 0.0);
      EXPECT_TRUE(nodes.wavelength_um[i] > 3.0 && nodes.wavelength_um[i] < 5.0);
      sum += nodes.weight[i];
      moment += nodes.weight[i] * std::pow(nodes.wavelength_um[i] - 3.0, degree);
    }
    EXPECT_NEAR(sum, 1.0, 1e-13) << n;
    EXPECT_NEAR(moment / (std::pow(2.0, degree) / (degree + 1)), 1.0, 1e-12) << n;
  }
}

TEST(System, labels_are_unique_over_all_lists) {
  System<double> s;
  s.add(Stage::presample, gaussian(1.0));
  s.add(Stage::readout, gaussian(1.0));
  s.add(Stage::postsample, gaussian(1.0));
  EXPECT_EQ(s.list(Stage::presample)[0].label, "gaussian");
  EXPECT_EQ(s.list(Stage::readout)[0].label, "gaussian_2");
  EXPECT_EQ(s.list(Stage::postsample)[0].label, "gaussian_3");
}

/// The error found at `where`, or an empty text.
std::string error_at(const System<double>& s, const std::string& where) {
  for (const auto& finding : s.check())
    if (finding.problem.error && finding.where == where) return finding.problem.text;
  return "";
}

TEST(SystemCheck, lists) {
  System<double> s = mwir();
  EXPECT_TRUE(s.check().empty());
  s.add(Stage::presample, Component<double>::make("diffraction"));
  expect_says(error_at(s, "presample[3].kind"), {"second complete pupil"});
  s = mwir();
  s.add(Stage::postsample, footprint(15.0));
  expect_says(error_at(s, "postsample[0].kind"), {"cannot stand in [[postsample]]"});
  s = mwir();
  s.add(Stage::presample, fir({{1}}));
  expect_says(error_at(s, "presample[3].kind"), {"cannot stand in [[presample]]"});
  EXPECT_THROW(require_valid(s), UsageError);
}

TEST(SystemCheck, frame_optics_and_band) {
  const double nan = std::nan("");
  for (const double bad : {0.0, -1.0, nan, 1e300}) {
    System<double> s = mwir();
    s.frame.focal_length_mm = bad;
    EXPECT_TRUE(says(error_at(s, "frame.focal_length"), "outside")) << bad;
    s = mwir();
    s.frame.pitch_y_um = bad;
    EXPECT_TRUE(says(error_at(s, "frame.pitch_y"), "outside")) << bad;
    s = mwir();
    s.optics.f_number = bad;
    EXPECT_TRUE(says(error_at(s, "optics.f_number"), "outside")) << bad;
    s = mwir();
    s.optics.wavelength_um = bad;
    EXPECT_TRUE(says(error_at(s, "optics.wavelength"), "outside")) << bad;
  }
  System<double> s = mwir();
  s.optics.obscuration = 1.0;
  expect_says(error_at(s, "optics.obscuration"), {"[0, 1)"});
  s = mwir();
  s.frame.integration_time_s = -1.0;
  expect_says(error_at(s, "frame.integration_time"), {"outside"});
  s = mwir();
  s.optics.aperture_mm = 50.0;
  expect_says(error_at(s, "optics.aperture"), {"either"});
  s = mwir();
  s.band = Band{3.0, 5.0};
  expect_says(error_at(s, "optics.wavelength"), {"twice"});
  s.optics.wavelength_um.reset();
  EXPECT_TRUE(s.check().empty());
  s.band = Band{5.0, 3.0};
  expect_says(error_at(s, "band.wavelength"), {"increasing"});
}

TEST(SystemCheck, what_a_component_needs_from_its_surroundings) {
  System<double> s = mwir();
  s.optics.f_number.reset();
  expect_says(error_at(s, "presample[0].f_number"), {"missing"});
  s.optics.aperture_mm = 50.0;  // 100 mm / 50 mm
  EXPECT_TRUE(s.check().empty());
  EXPECT_NEAR(s.otf({20.0, 0.0}).re, mwir().otf({20.0, 0.0}).re, 1e-15);
  s.optics.wavelength_um.reset();
  expect_says(error_at(s, "presample[0].wavelength"), {"missing"});
  s = mwir();
  set(s.list(Stage::presample)[0].component, "f_number", 4.0);  // its own value wins
  EXPECT_NEAR(s.list(Stage::presample)[0].component.cutoff_cy_mm(s.context()), 62.5, 1e-12);

  s = mwir();
  auto velocity = Component<double>::make("linear_motion");
  set(velocity, "velocity", 1000.0);
  s.add(Stage::presample, velocity);
  EXPECT_TRUE(s.check().empty());
  s.frame.integration_time_s = 0.0;
  expect_says(error_at(s, "presample[3].velocity"), {"integration_time"});
}

TEST(SystemCheck, values_that_exclude_each_other) {
  System<double> s = mwir();
  set(s.list(Stage::presample)[1].component, "fill_factor", 0.9);
  expect_says(error_at(s, "presample[1].width"), {"either width or fill_factor"});
  s = mwir();
  set(s.list(Stage::presample)[1].component, "width", 20.0, "um");
  ASSERT_EQ(s.check().size(), 2u);  // wider than the pitch along x and y: a warning each
  EXPECT_FALSE(s.check()[0].problem.error);
  EXPECT_NO_THROW(require_valid(s));
  s = mwir();
  s.add(Stage::presample, Component<double>::make("linear_motion"));
  expect_says(error_at(s, "presample[3].travel"), {"exactly one"});
  s = mwir();
  for (const Taps<double>& taps : {Taps<double>{}, {{}}, {{1, 2}}, {{1}, {2}}, {{1, 2, 3}, {1}, {1, 2, 3}}}) {
    s.list(Stage::postsample).clear();
    s.add(Stage::postsample, fir(taps));
    EXPECT_NE(error_at(s, "postsample[0].taps"), "") << taps.size();
  }
  s = mwir();
  auto rms = Component<double>::make("rms_wavefront");
  set(rms, "rms", 0.2);
  s.add(Stage::presample, rms);
  ASSERT_EQ(s.check().size(), 1u);
  EXPECT_FALSE(s.check()[0].problem.error);
  expect_says(s.check()[0].problem.text, {"validity"});
}

TEST(SystemCheck, missing_values_are_named) {
  for (const char* kind : {"gaussian", "jitter", "rc_lowpass", "butterworth", "curve", "fir", "footprint"}) {
    System<double> s = mwir();
    s.list(Stage::presample).clear();
    const Stage stage = std::string_view(kind) == "fir" ? Stage::postsample : Stage::presample;
    s.add(stage, Component<double>::make(kind));
    EXPECT_THROW(require_valid(s), UsageError) << kind;
  }
}

TEST(Component, unknown_kind_offers_the_nearest) {
  expect_refused({"did you mean \"diffraction\"?"}, [&] { Component<double>::make("difraction"); });
}

TEST(Component, copies_are_values) {
  Component<double> a = gaussian(3.0);
  const Component<double> b = a;
  Component<double> c = a;
  const Context<double> ctx = mwir().context();
  set(a, "sigma", 9.0, "um");
  EXPECT_EQ(b.otf({20.0, 0.0}, ctx).re, gaussian(3.0).otf({20.0, 0.0}, ctx).re);
  EXPECT_EQ(c.otf({20.0, 0.0}, ctx).re, b.otf({20.0, 0.0}, ctx).re);
  EXPECT_EQ(a.otf({20.0, 0.0}, ctx).re, gaussian(9.0).otf({20.0, 0.0}, ctx).re);
  System<double> s = mwir();
  const System<double> before = s;
  set(s.list(Stage::presample)[2].component, "rms", 8.0, "um");
  EXPECT_NE(s.otf({20.0, 0.0}).re, before.otf({20.0, 0.0}).re);
  EXPECT_EQ(before.otf({20.0, 0.0}).re, mwir().otf({20.0, 0.0}).re);
}

TEST(SystemCast, to_float_and_back) {
  System<double> s = whole_chain();
  s.optics.obscuration = 0.25;
  s.frame.columns = 640;
  auto curve = Component<double>::make("curve");
  *std::get<CurveSum<double>*>(field(curve, "file").value) =
      std::make_shared<const Curve>(make_curve("lens.csv", *find_unit("cy/mrad"), {0.0, 4.0, 9.0}, {1.0, 0.6, 0.0}));
  choose(curve, "axis", 2);
  s.add(Stage::presample, curve);
  auto motion_px = motion(10.0, 30.0);
  set(motion_px, "travel", 0.75, "px");
  s.add(Stage::presample, motion_px);
  ASSERT_TRUE(s.check().empty());
  const System<float> single = cast<float>(s);
  const System<double> back = cast<double>(single);
  EXPECT_EQ(back.name, s.name);
  EXPECT_EQ(back.frame.columns, 640);
  EXPECT_EQ(back.optics.obscuration, 0.25);
  EXPECT_EQ(single.list(Stage::presample)[3].label, "curve");
  for (const Freq<double>& f : {Freq<double>{0.0, 0.0}, {7.0, 12.0}, {-30.0, 25.0}}) {
    const Complex<double> exact = s.otf(f);
    const Complex<float> h = single.otf({static_cast<float>(f.x), static_cast<float>(f.y)});
    EXPECT_NEAR(static_cast<double>(h.re), exact.re, 2e-6);
    EXPECT_NEAR(static_cast<double>(h.im), exact.im, 2e-6);
    // All these parameters are exact in float, so nothing is lost on the way back.
    EXPECT_EQ(back.otf(f).re, exact.re);
    EXPECT_EQ(back.otf(f).im, exact.im);
  }
}

}  // namespace
}  // namespace mtf::test
