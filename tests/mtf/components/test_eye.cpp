// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/eye_fits.h"
#include "mtf/math/special.h"
#include "tests/expect_error.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

constexpr double kFootLambert = 3.4262590996;
constexpr std::array kModels{ContrastModel::barten_2003, ContrastModel::barten_short,
                             ContrastModel::barten_short_squared};

// Tables that the fits stand for: pupil of one eye, scale and exponent of the optics.
TEST(EyeFunctions, fits_agree_with_their_tables) {
  const std::array pupil{7.0, 6.2, 5.6, 4.9, 4.2, 3.6, 3.0, 2.5};
  for (std::size_t i = 0; i < pupil.size(); ++i) {
    const double luminance = kFootLambert * std::pow(10.0, static_cast<double>(i) - 4.0);
    EXPECT_NEAR(pupil_diameter_mm(luminance, 1).value, pupil[i], 0.07);
    EXPECT_NEAR(pupil_diameter_mm(luminance, 2).value, pupil[i] - 0.5, 0.07);
  }
  const std::array d{1.5, 2.0, 2.4, 3.0, 3.8, 4.9, 5.8, 6.6}, f0{36., 39., 35., 32., 25., 15., 11., 8.},
      i0{.9, .8, .8, .77, .75, .72, .69, .66};
  for (std::size_t i = 0; i < d.size(); ++i) {
    EXPECT_NEAR(eye_optics(d[i]).f0.value, f0[i], 2.3) << d[i];
    EXPECT_NEAR(eye_optics(d[i]).i0.value, i0[i], 0.032) << d[i];
  }
}

TEST(EyeFunctions, mtf_at_20_footlambert_with_both_eyes) {
  const double pupil = pupil_diameter_mm(20.0 * kFootLambert, 2).value;
  EXPECT_NEAR(pupil, 2.927, 5e-4);
  const std::array f{.1, .25, .5, 1.0}, digits{.7837019243, .5853882496, .3608273161, .1235045559},
      published{.78370, .58538, .36082, .12350};
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_NEAR(eye_mtf(f[i], pupil).value, published[i], 1.001e-5) << f[i];  // cut, not rounded
    EXPECT_NEAR(eye_mtf(f[i], pupil).value, digits[i], 1e-9) << f[i];
  }
}

TEST(EyeFunctions, contrast_sensitivities_in_print) {
  const std::array u{1.0, 4.0, 16.0}, long_form{403.03, 536.22, 122.31}, squared{231.62, 453.97, 110.03};
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR(contrast_sensitivity(ContrastModel::barten_2003, u[i], 34.26, 10.0).value, long_form[i], 5e-3);
    EXPECT_NEAR(contrast_sensitivity(ContrastModel::barten_short_squared, u[i], 34.26, 10.0).value, squared[i], 5e-3);
  }
}

// The formulas as they stand, 60 digits (mpmath), far from and near their cancellations.
TEST(EyeFunctions, contrast_sensitivities_to_twelve_digits) {
  const std::array u{1e-12, 0.3, 5.0, 25.0, 40.0};
  struct Row {
    double luminance, field;
    std::array<std::array<double, 5>, 3> s;  // by model
  };
  const std::array rows{
      Row{0.1,
          5.0,
          {{{2.8284271247461901e-10, 63.536869239782246, 49.120636839460287, 2.19470962697302, 0.091625057786366885},
            {1.0788219596183476e-10, 27.053165140739763, 30.913999403181698, 0.044533617369215612,
             0.00013505978321699446},
            {1.0788219596186014e-10, 28.851713515747393, 43.915214105454374, 0.054484028400073123,
             0.00015585376245707486}}}},
      Row{1000.0,
          40.0,
          {{{7.0437687993774021e-10, 205.78149075228528, 729.16878833565027, 86.392190630755847, 11.220963099089502},
            {4.2760478871017195e-10, 119.92074022375269, 598.27014760187419, 71.670966013938918, 11.781575210693667},
            {4.2760478871020484e-10, 122.30327148647625, 638.63320103828249, 73.720790261191524,
             12.010627815103114}}}}};
  for (const Row& row : rows)
    for (std::size_t m = 0; m < kModels.size(); ++m)
      for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_NEAR(contrast_sensitivity(kModels[m], u[i], row.luminance, row.field).value / row.s[m][i], 1.0, 1e-12)
            << m << " " << u[i];
}

// Derivatives by mpmath at 60 digits.
TEST(EyeFunctions, derivatives_to_twelve_digits) {
  struct Row {
    ContrastModel model;
    double u, luminance, field, by_frequency, by_luminance, by_field;
  };
  using enum ContrastModel;
  for (const Row& row :
       {Row{barten_2003, 0.3, 0.1, 5.0, 117.9236625162257, 114.3816979820472, 10.73610557442929},
        Row{barten_2003, 5.0, 34.26, 10.0, -59.58716099780589, 3.323826956850691, 3.724896406326429},
        Row{barten_2003, 25.0, 1000.0, 40.0, -10.41043737149563, 0.006704453146032644, 0.0004846354407220341},
        Row{barten_short, 0.3, 0.1, 5.0, 73.74239429367484, 57.2584404843252, 3.710148362158596},
        Row{barten_short, 5.0, 34.26, 10.0, -27.25167128029699, 1.829604727371124, 10.71965255362931},
        Row{barten_short, 25.0, 1000.0, 40.0, -8.04838991766007, 0.003758302493874119, 0.05579919499355106},
        Row{barten_short_squared, 0.3, 0.1, 5.0, 84.27474090532808, 61.06509580738283, 3.83623891622126},
        Row{barten_short_squared, 5.0, 34.26, 10.0, -34.96524341421222, 2.269883939840111, 6.187350714703139},
        Row{barten_short_squared, 25.0, 1000.0, 40.0, -8.342498296433367, 0.003865791760573201,
            0.006325350632554249}}) {
    const auto s = contrast_sensitivity(row.model, row.u, row.luminance, row.field);
    EXPECT_NEAR(s.by_frequency / row.by_frequency, 1.0, 1e-12);
    EXPECT_NEAR(s.by_luminance / row.by_luminance, 1.0, 1e-12);
    EXPECT_NEAR(s.by_field / row.by_field, 1.0, 1e-12);
  }
  struct EyeRow {
    double f, value, by_frequency, by_pupil;
  };
  for (const EyeRow& row : {EyeRow{1e-9, 0.99999983716738215, -124.79228429879, -1.8083546850017e-7},
                            EyeRow{0.1, 0.78059332494701168, -1.60464273617021, -0.0431211696257035},
                            EyeRow{2.0, 0.0079825485647489574, -0.0250581239979964, -0.00193983295777266}}) {
    const EyeMtf h = eye_mtf(row.f, 3.0);
    EXPECT_NEAR(h.value / row.value, 1.0, 1e-14);
    EXPECT_NEAR(h.by_frequency / row.by_frequency, 1.0, 1e-12);
    EXPECT_NEAR(h.by_pupil / row.by_pupil, 1.0, 1e-12);
  }
}

TEST(EyeFunctions, the_peak_is_the_largest_value) {
  for (const ContrastModel model : kModels)
    for (const double luminance : {kLuminanceLo, 0.1, 34.26, kLuminanceHi})
      for (const double field : {0.1, 10.0, 180.0}) {
        const double u = peak_frequency_cy_deg(model, luminance, field);
        const double peak = contrast_sensitivity(model, u, luminance, field).value;
        for (double v = 1e-4; v < 100.0; v *= 1.01)
          EXPECT_LE(contrast_sensitivity(model, v, luminance, field).value, peak * (1.0 + 1e-15))
              << static_cast<int>(model) << " " << luminance << " " << field << " " << v;
      }
}

Component<double> eye(int model, double magnification, double luminance) {
  auto c = Component<double>::make("eye");
  choose(c, "model", model);
  set(c, "magnification", magnification);
  set(c, "luminance", luminance);
  return c;
}

// 100 mm focal length: 1 cycle/mm is 0.1 cycles/mrad in object space, 0.01 at the eye behind a magnification of 10.
TEST(Eye, is_the_mtf_at_the_eye) {
  const auto c = eye(0, 10.0, 20.0 * kFootLambert);
  EXPECT_NEAR(otf_at(c, 10.0, 0.0).re, .7837019243, 1e-9);
  EXPECT_NEAR(otf_at(c, 15.0, 20.0).re, .5853882496, 1e-9);
  EXPECT_NEAR(otf_at(c, 0.0, -50.0).re, .3608273161, 1e-9);
  EXPECT_EQ(otf_at(c, 0.0, 0.0).re, 1.0);
  EXPECT_EQ(c.description(), "eye: MTF of optics, retina and tremor");
}

TEST(Eye, sensitivity_is_relative_to_its_peak) {
  for (int m = 0; m < 3; ++m) {
    const ContrastModel model = kModels[static_cast<std::size_t>(m)];
    auto c = eye(m + 1, 5.0, 34.26);
    expect_says(c.description(), {"Barten"});
    const double mm_of_one = 5.0 * 180.0 / kPi / 100.0;  // cycles/mm for 1 cycle/degree at the eye
    const double peak = peak_frequency_cy_deg(model, 34.26, 10.0);
    EXPECT_NEAR(otf_at(c, 0.0, peak * mm_of_one).re, 1.0, 1e-15);
    EXPECT_EQ(otf_at(c, 0.0, 0.0).re, 0.0);
    EXPECT_EQ(c.traits(detector().context()).dc, 0.0);
    for (const double u : {0.5, 4.0, 16.0})
      EXPECT_NEAR(
          otf_at(c, 0.6 * u * mm_of_one, 0.8 * u * mm_of_one).re,
          contrast_sensitivity(model, u, 34.26, 10.0).value / contrast_sensitivity(model, peak, 34.26, 10.0).value,
          1e-14);
    set(c, "field", 10.0);
    EXPECT_NEAR(otf_at(c, 0.0, peak * mm_of_one).re, 1.0, 1e-15);
  }
}

TEST(Eye, many_frequencies_at_once_are_the_same) {
  for (int m = 0; m < 4; ++m) {
    const auto c = eye(m, 5.0, 34.26);
    const Context<double> ctx = detector().context();
    const std::array<Freq<double>, 3> f{{{0.0, 0.0}, {3.0, -8.0}, {40.0, 0.0}}};
    std::array<Complex<double>, 3> h{{{2.0, 0.0}, {2.0, 0.0}, {2.0, 0.0}}};
    c.multiply(f, ctx, h);
    for (std::size_t i = 0; i < f.size(); ++i) EXPECT_EQ(h[i].re, 2.0 * c.otf(f[i], ctx).re);
  }
}

TEST(Eye, the_mtf_has_no_field) {
  auto c = eye(0, 5.0, 34.26);
  EXPECT_FALSE(refused(c, "field"));
  set(c, "field", 20.0);
  EXPECT_TRUE(refused(c, "field"));
  choose(c, "model", 2);
  EXPECT_FALSE(refused(c, "field"));
}

}  // namespace
}  // namespace mtf::test
