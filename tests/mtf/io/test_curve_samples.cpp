// SPDX-License-Identifier: Apache-2.0
// Curves as data to fit, from every CSV that the toolkit writes.

#include <gtest/gtest.h>

#include <cmath>

#include "mtf/error.h"
#include "mtf/io/csv/curve_samples.h"
#include "tests/expect_error.h"

namespace {

using mtf::io::parse_curve_samples;

std::string refusal(const std::string& text) {
  return message_of<mtf::UsageError>([&] { parse_curve_samples(text, "c.csv"); });
}

}  // namespace

TEST(CurveSamples, WithAndWithoutDeviations) {
  const auto plain = parse_curve_samples("# bench\nfrequency_cy_mm,mtf\n0,1\n10,0.9\n", "c.csv");
  ASSERT_EQ(plain.size(), 1U);
  EXPECT_EQ(plain[0].unit->name, "cy/mm");
  EXPECT_EQ(plain[0].mtf, (std::vector{1.0, 0.9}));
  EXPECT_TRUE(plain[0].sd.empty());
  const auto weighted =
      parse_curve_samples("f_cy_px;mtf;sd;remark\n0;1;0;a\n0.1;0.9;0.01;b\n0.2;0.7;0.02;c\n", "c.csv");
  EXPECT_EQ(weighted.at(0).frequency, (std::vector{0.1, 0.2}));  // what has no error is no measurement
  EXPECT_EQ(weighted[0].sd, (std::vector{0.01, 0.02}));
}

TEST(CurveSamples, OfTheCurveCommand) {
  const auto real = parse_curve_samples("frequency,jitter,presample,system\n0,1,1,1\n10,0.9,0.9,-0.8\n", "c.csv",
                                        mtf::find_unit("cy/mm"));
  EXPECT_EQ(real.at(0).mtf, (std::vector{1.0, -0.8}));
  const auto complex =
      parse_curve_samples("frequency,system_re,system_im\n0,1,0\n0.1,0.3,-0.4\n", "c.csv", mtf::find_unit("cy/px"));
  EXPECT_EQ(complex.at(0).unit->name, "cy/px");
  EXPECT_NEAR(complex[0].mtf.at(1), 0.5, 1e-15);
}

TEST(CurveSamples, OfMeasuredEdgesInTheirUnit) {
  const std::string head = "edge,curve,x,value,sd,x_unit\n";
  for (const auto& [word, unit] : {std::pair{"cy/mm", "cy/mm"}, {"lp/mm", "cy/mm"}, {"cy/mrad", "cy/mrad"}}) {
    const auto curves = parse_curve_samples(head + "1,mtf,40,0.9,0.01," + word + "\n1,esf,0,0.5,0.1,px\n", "m.csv");
    EXPECT_EQ(curves.at(0).unit->name, unit);
    EXPECT_EQ(curves[0].frequency, std::vector{40.0});
  }
  for (const char* word : {"lw/ph", "um", ""})
    EXPECT_TRUE(says(refusal(head + "1,mtf,40,0.9,0.01," + word + "\n"), "c.csv:2: frequencies in")) << word;
}

TEST(CurveSamples, OfMeasuredEdges) {
  const auto curves = parse_curve_samples(
      "edge,curve,x,value,sd\n1,mtf,0,1,0\n1,mtf,0.1,0.9,0.01\n1,mtf,0.2,,\n1,esf,0,0.5,0.1\n2,mtf,0,1,0\n2,mtf,0.1,0."
      "8,"
      "0.02\n",
      "m.csv");
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_EQ(curves[1].name, "edge 2");
  EXPECT_EQ(curves[0].frequency, std::vector{0.1});
  EXPECT_EQ(curves[1].mtf, std::vector{0.8});
  EXPECT_EQ(curves[1].sd, std::vector{0.02});
}

TEST(CurveSamples, WhatIsWrongIsSaid) {
  expect_says(refusal("edge,curve,x,value,sd\n1,mtf,0,1,0\n"), {"no sample"});
  expect_says(refusal("edge,curve,x,value,sd\n1,mtf,nan,1,0.1\n"), {"c.csv:2: \"nan\""});
  expect_says(refusal("frequency_cy_mm,mtf,sd\n1,0.9,-1\n"), {"negative"});
  expect_says(refusal("frequency_cy_mm,mtf,sd\n1,0.9\n"), {"c.csv:2: 2 values"});
  expect_says(refusal("frequency_cy_mm,mtf\n1,nan\n"), {"no finite number"});
  expect_says(refusal("frequency,system\n0,1\n"), {"--curve-unit"});
  expect_says(refusal(""), {"no header"});
}
