// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> display(const char* kind, const char* field, double size, const char* unit) {
  auto c = Component<double>::make(kind);
  set(c, field, size, unit);
  return c;
}

// The jitter of the golden table, 4 um rms, is the same function.
TEST(DisplayCrt, ten_digits) {
  const std::array values{.9921354055, .9689107912, .8813231367, .7609352256};
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(otf_at(display("display_crt", "sigma", 4.0, "um"), kGoldenFrequencies[i], 0.0).re, values[i],
                kTenDigits);
    EXPECT_NEAR(otf_at(display("display_crt", "sigma", 40.0, "urad"), 0.0, kGoldenFrequencies[i]).re, values[i],
                kTenDigits);
  }
}

// A spot whose half maximum is as wide as one pixel passes exp(-pi^2/(16 ln 2)) at half the sampling frequency.
TEST(DisplayCrt, spot_of_one_pixel_at_half_maximum) {
  const double sigma_px = 0.5 / std::sqrt(2.0 * std::log(2.0));
  EXPECT_NEAR(otf_at(display("display_crt", "sigma", sigma_px, "px"), 0.5e3 / 17.0, 0.0).re,
              std::exp(-kPi * kPi / (16.0 * std::log(2.0))), 1e-15);
}

// The footprint of the golden table, 15 um, is the same function.
TEST(DisplayFlatPanel, ten_digits) {
  const std::array values{.9907728960, .9633977620, .8583936913, .7092174591};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(otf_at(display("display_flat_panel", "width", 15.0, "um"), kGoldenFrequencies[i], 0.0).re, values[i],
                kTenDigits);
  EXPECT_EQ(otf_at(display("display_flat_panel", "width", 1.0, "px"), 1e3 / 16.0, 0.0, detector(16.0, 16.0)).re, 0.0);
}

// The three stripes integrated over their widths, and the height of the element.
TEST(DisplayFlatPanel, colour_lcd_is_three_stripes) {
  const double pitch_mm = 0.02;
  const auto c = display("display_flat_panel", "lcd_pitch", 20.0, "um");
  const auto mean_over = [](double middle, double width, double f) {
    double sum = 0.0;
    for (int k = 0; k < 2000; ++k)
      sum += std::cos(2.0 * kPi * f * (middle + width * ((k + 0.5) / 2000.0 - 0.5))) / 2000.0;
    return sum;
  };
  for (const double fx : {0.0, 4.0, 25.0, 50.0, 90.0, -120.0})
    for (const double fy : {0.0, 10.0, 55.0, 70.0}) {
      double stripes = 0.0;
      for (const int k : {-1, 0, 1})
        stripes += (k == 0 ? 0.68 : 0.16) * mean_over(0.32 * k * pitch_mm, 0.29 * pitch_mm, fx);
      EXPECT_NEAR(otf_at(c, fx, fy).re, stripes * mean_over(0.0, 0.85 * pitch_mm, fy), 2e-6) << fx << " " << fy;
    }
  EXPECT_EQ(otf_at(c, 0.0, 0.0).re, 1.0);
}

// At P f = 1: sinc(0.29) [0.68 + 0.32 cos(0.64 pi)] across, sinc(0.85) down.
TEST(DisplayFlatPanel, colour_lcd_at_its_own_pitch) {
  const auto c = display("display_flat_panel", "lcd_pitch", 1.0, "px");
  EXPECT_NEAR(otf_at(c, 1e3 / 17.0, 0.0).re, std::sin(0.29 * kPi) / (0.29 * kPi) * (0.68 + 0.32 * std::cos(0.64 * kPi)),
              1e-15);
  EXPECT_NEAR(otf_at(c, 0.0, 1e3 / 17.0).re, std::sin(0.85 * kPi) / (0.85 * kPi), 1e-15);
}

TEST(DisplayFlatPanel, one_size) {
  auto c = Component<double>::make("display_flat_panel");
  EXPECT_TRUE(refused(c, "width"));
  set(c, "width", 1.0, "px");
  EXPECT_FALSE(refused(c, "width"));
  set(c, "lcd_pitch", 1.0, "px");
  EXPECT_TRUE(refused(c, "width"));
}

}  // namespace
}  // namespace mtf::test
