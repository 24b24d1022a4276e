// SPDX-License-Identifier: Apache-2.0
// Paths of the sensor file to the numbers of a System.
#include <gtest/gtest.h>

#include "calib/fit/system_jet.h"
#include "tests/calib/fit_cases.h"

namespace calib {
namespace {

using mtf::Component;
using mtf::Stage;
using mtf::System;

TEST(ParameterAt, FindsNumbersOfFrameOpticsAndComponents) {
  System<double> s = fit_cases::camera(8.0);
  ASSERT_NE(parameter_at(s, "frame.focal_length"), nullptr);
  EXPECT_EQ(*parameter_at(s, "frame.focal_length"), 50.0);
  EXPECT_EQ(parameter_at(s, "frame.pitch_y"), &s.frame.pitch_y_um);
  EXPECT_EQ(*parameter_at(s, "optics.f_number"), 8.0);
  *parameter_at(s, "presample[1].width") = 0.5;
  EXPECT_EQ(*parameter_at(s, "presample[1].width"), 0.5);
}

TEST(ParameterAt, AxisPairsByTheNameTheyAreWrittenWith) {
  System<double> s = fit_cases::bare();
  auto blur = Component<double>::make("gaussian");
  mtf::test::set_xy(blur, "sigma", 1.0, 2.0, "um");
  s.add(Stage::readout, blur);
  EXPECT_EQ(*parameter_at(s, "readout[0].sigma_x"), 1.0);
  EXPECT_EQ(*parameter_at(s, "readout[0].sigma_y"), 2.0);
  EXPECT_EQ(parameter_at(s, "readout[0].sigma"), nullptr);
  EXPECT_EQ(parameter_at(s, "presample[0].sigma_x"), nullptr);
}

TEST(ParameterAt, ASharedFieldGetsAValueOfItsOwn) {
  System<double> s = fit_cases::camera(8.0);
  double* const own = parameter_at(s, "presample[0].f_number");
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(*own, 8.0);
  *own = 4.0;
  EXPECT_EQ(*parameter_at(s, "optics.f_number"), 8.0);
  EXPECT_EQ(*parameter_at(s, "presample[0].f_number"), 4.0);
}

TEST(ParameterAt, ListsByIndex) {
  System<double> s = fit_cases::camera(8.0);
  s.stages = {};
  auto wavefront = Component<double>::make("wavefront");
  *std::get<mtf::Coefficients<double>*>(mtf::test::field(wavefront, "zernike").value) = {0.0, 0.1, 0.2};
  s.add(Stage::presample, wavefront);
  s.add(Stage::postsample, mtf::test::fir({{0.25, 0.5, 0.25}}));
  EXPECT_EQ(*parameter_at(s, "presample[0].zernike[2]"), 0.2);
  EXPECT_EQ(*parameter_at(s, "postsample[0].taps[0][1]"), 0.5);
  for (const char* path : {"presample[0].zernike[3]", "presample[0].zernike", "presample[0].zernike[-1]",
                           "presample[0].zernike[]", "postsample[0].taps[0]", "presample[0].w020"})
    EXPECT_EQ(parameter_at(s, path), nullptr) << path;
}

TEST(ParameterAt, TermsOverTheField) {
  System<double> s = fit_cases::camera(8.0);
  auto jitter = mtf::test::jitter(2.0);
  s.add(Stage::presample, jitter);
  s.field.numbers.push_back({2, 0, 0, {0.0, 0.5, 0.0, 0.25}});
  EXPECT_EQ(*parameter_at(s, "presample[2].rms.1"), 2.0);
  EXPECT_EQ(*parameter_at(s, "presample[2].rms.r2"), 0.5);
  EXPECT_EQ(*parameter_at(s, "presample[2].rms.x"), 0.25);
  EXPECT_EQ(*parameter_at(s, "presample[2].rms.y2"), 0.0);  // of a number that changes, so that it can be fitted
  EXPECT_EQ(parameter_at(s, "optical_axis.y"), &s.field.axis_y_px);
  for (const char* path : {"presample[2].rms.r3", "presample[2].rms.", "presample[1].width.x", "optical_axis.z"})
    EXPECT_EQ(parameter_at(s, path), nullptr) << path;
}

TEST(ParameterAt, NothingForWhatIsNotThere) {
  System<double> s = fit_cases::camera(8.0);
  for (const char* path : {"", ".", "frame", "frame.", "frame.columns", "optics.aperture", "presample[2].width",
                           "presample.width", "presample[1]", "presample[1].fill_factor", "presample[1].width_z",
                           "presample[18446744073709551616].width", "presample[1].width[0]", "scene.sample"})
    EXPECT_EQ(parameter_at(s, path), nullptr) << path;
}

TEST(ParameterAt, TheSameForJets) {
  System<double> s = fit_cases::camera(8.0);
  auto jets = mtf::cast<Jet4>(s);
  ASSERT_NE(parameter_at(jets, "presample[1].width"), nullptr);
  EXPECT_EQ(parameter_at(jets, "presample[1].width")->a, 1.0);
  EXPECT_EQ(parameter_at(jets, "presample[7].width"), nullptr);
}

}  // namespace
}  // namespace calib
