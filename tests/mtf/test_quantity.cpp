// SPDX-License-Identifier: Apache-2.0
#include "mtf/quantity.h"

#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/from_quantities.h"
#include "mtf/literals.h"

namespace mtf::test {
namespace {

using namespace mtf::literals;

TEST(Quantity, is_the_same_in_every_unit) {
  EXPECT_EQ(15_mm, 15000_um);
  EXPECT_EQ(15000_um, 15_mm);
  EXPECT_EQ(7_nm, 0.007_um);
  EXPECT_EQ(0.0015_mm, 1.5_um);
  EXPECT_EQ(0.3_km, 300_m);
  EXPECT_EQ(20_urad, 0.02_mrad);
  EXPECT_EQ(4_ms, 0.004_s);
  EXPECT_EQ(400_kHz, 0.4_MHz);
  EXPECT_EQ(15_um, micrometres(15));
  EXPECT_NE(15_mm, 15_um);
  EXPECT_NE(1_deg, 17_mrad);
}

// Cycles per mm, per mrad and per pixel become each other by a frame alone.
TEST(Quantity, spatial_frequencies_compare_in_one_unit) {
  EXPECT_EQ(0.5_cy_px, cycles_per_px(0.5));
  EXPECT_NE(0.5_cy_px, 0.5_cy_mm);
  EXPECT_NE(0.5_cy_px, 0.25_cy_px);
}

TEST(Quantity, arithmetic) {
  EXPECT_EQ(15_mm / 1_um, 15000.0);
  EXPECT_EQ(15_um / 1_mm, 0.015);
  EXPECT_EQ(90_deg / 1_deg, 90.0);
  EXPECT_EQ(1_mm + 500_um, 1.5_mm);
  EXPECT_EQ(1_mm - 500_um, 500_um);
  EXPECT_EQ(-(2_px), -2.0 * 1_px);
  EXPECT_EQ(3_um * 2, 12_um / 2);
  EXPECT_EQ(10_mm / 2_s, micrometres_per_second(5000));
  EXPECT_EQ(1_mrad / 4_ms, microradians_per_second(250000));
  EXPECT_EQ(10_mm / 2_s / 1_s, micrometres_per_second2(5000));
  EXPECT_EQ(1_urad / 1_s / 2_s, microradians_per_second2(0.5));
}

TEST(Quantity, unit_of_another_dimension_is_refused) {
  EXPECT_THROW(Length(15, "urad"), UsageError);
  EXPECT_THROW(Angle(15, "furlong"), UsageError);
  EXPECT_NO_THROW(Length(1, "in"));
}

TEST(Quantity, extents_and_frequencies_keep_their_unit) {
  Frame<double> frame = make_frame({.focal_length = 100_mm, .pitch = 15_um, .pitch_y = 20_um});
  const AxisPair<double> angle = 20_urad, apart = {2_um, 0.5_px};
  EXPECT_EQ(angle.x_um(frame), 2.0);
  EXPECT_EQ(angle.y_um(frame), 2.0);
  EXPECT_EQ(angle.x.unit->name, "urad");
  EXPECT_FALSE(angle.split);
  EXPECT_EQ(apart.x_um(frame), 2.0);
  EXPECT_EQ(apart.y_um(frame), 10.0);
  EXPECT_TRUE(apart.split);
  const SpatialFrequency<double> per_px = 0.3_cy_px, per_mrad = 4_cy_mrad, in_time = 2_kHz;
  EXPECT_EQ(per_px.cy_mm(frame, Axis::x), 20.0);
  EXPECT_EQ(per_px.cy_mm(frame, Axis::y), 15.0);
  EXPECT_EQ(per_mrad.cy_mm(frame, Axis::x), 40.0);
  EXPECT_TRUE(in_time.temporal());
  frame.focal_length_mm = 200.0;  // an angle stays an angle
  EXPECT_EQ(angle.x_um(frame), 4.0);
  EXPECT_EQ(per_mrad.cy_mm(frame, Axis::x), 20.0);
}

TEST(Quantity, frame_optics_band_and_frequency_of_quantities) {
  const Frame<double> frame =
      make_frame({.focal_length = 0.1_m, .pitch = 15_um, .integration_time = 4_ms, .columns = 640, .rows = 512});
  EXPECT_EQ(frame.focal_length_mm, 100.0);
  EXPECT_EQ(frame.pitch_x_um, 15.0);
  EXPECT_EQ(frame.pitch_y_um, 15.0);
  EXPECT_EQ(frame.integration_time_s, 0.004);
  EXPECT_EQ(frame.columns, 640);
  EXPECT_EQ(frame.rows, 512);
  const Optics<double> optics = make_optics({.aperture = 50_mm, .obscuration = 0.3, .wavelength = 4000_nm});
  EXPECT_FALSE(optics.f_number);
  EXPECT_EQ(optics.aperture_mm, 50.0);
  EXPECT_EQ(optics.obscuration, 0.3);
  EXPECT_EQ(optics.wavelength_um, 4.0);
  EXPECT_EQ(make_optics({.f_number = 2.0}).f_number, 2.0);
  const Band band = make_band(3400_nm, 4.8_um);
  EXPECT_EQ(band.lo_um, 3.4);
  EXPECT_EQ(band.hi_um, 4.8);
  const Freq<double> f = make_frequency(frame, 0.3_cy_px, 4_cy_mrad);
  EXPECT_EQ(f.x, 20.0);
  EXPECT_EQ(f.y, 40.0);
}

}  // namespace
}  // namespace mtf::test
