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

TEST(CurveSamples, DeviationsOfInstruments) {
  for (const char* text : {"frequency_cy_px,sfr,sd\n0.1,0.9,0.02\n", "Bench 3\nfrequency_cy_px,mtf,SD\n0.1,0.9,0.02\n",
                           "Cy/mm,Cy/Pxl,MTF(Y),MTF(Y) sd\n10,0.1,0.9,0.02\n"})
    EXPECT_EQ(parse_curve_samples(text, "c.csv").at(0).sd, std::vector{0.02}) << text;
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

// Rows as the source of MTF Mapper 0.7 prints them: 5 columns, or 13 that comments name, then 64 samples.
TEST(CurveSamples, OfMtfMapper) {
  std::string samples;
  for (int i = 0; i < 64; ++i) samples += std::to_string(1.0 - i / 64.0) + " ";
  const auto row = [&](const std::string& columns) { return columns + samples + "\n"; };
  std::string second = "# MTF Mapper SFR, output format version 2 \n";
  for (int i = 1; i <= 13; ++i) second += "# column " + std::to_string(i) + ": a word\n";
  second += row("0 412.5 33.25 4.9 10.1 90.0 80.0 100.0 50.0 60.0 5.0 7.9 101.2 ");
  for (const std::string& text : {row("0 412.5 33.25 4.9 10.1 ") + row("0 412.5 99 4.9 10.1 "), second}) {
    const auto curves = parse_curve_samples(text, "edge_sfr_values.txt");
    ASSERT_EQ(curves.size(), text == second ? 1U : 2U);
    EXPECT_EQ(curves[0].name, "edge at 412.5,33.25");
    EXPECT_EQ(curves[0].unit->name, "cy/px");
    ASSERT_EQ(curves[0].frequency.size(), 63U);
    for (std::size_t i = 0; i < 63; ++i) {
      EXPECT_DOUBLE_EQ(curves[0].frequency[i], static_cast<double>(i + 1) / 64.0);
      EXPECT_NEAR(curves[0].mtf[i], 1.0 - static_cast<double>(i + 1) / 64.0, 5e-7);  // printed to six places
    }
  }
  expect_says(refusal(second + "0 1 2 3\n"), {"c.csv:16:", "13 columns"});
}

// A sheet as results5.m of sfrmat5 lays it out (from its column B on), saved as CSV; numbers have three decimals.
TEST(CurveSamples, OfSfrmat) {
  const std::string head =
      ",Output from Matlab function sfrmat5.m,,,,\n,Analysis:  Spatial Frequency Response,,,,\n,,,,,\n"
      ",Selected region,\"(1, 1), to (60, 80)\",,,\n,  ,Red,Green,Blue,Lum\n,\"SFR50, "
      "cy/pixel\",0.2,0.21,0.22,0.23\n,,,,,\n";
  const std::string rows = ",0,1,1,1,1\n,0.008,0.97,0.98,0.99,0.991\n,0.016,0.94,0.95,0.96,0.962\n";
  const auto curves = parse_curve_samples(head + ",\"Frequency, cy/pixel\",SFR-r,SFR-g,SFR-b,Lum\n" + rows, "s.csv");
  ASSERT_EQ(curves.size(), 1U);
  EXPECT_EQ(curves[0].name, "column Lum");
  EXPECT_EQ(curves[0].unit->name, "cy/px");
  EXPECT_EQ(curves[0].frequency, (std::vector{0.008, 0.016}));  // at 0 it is 1 by definition
  EXPECT_EQ(curves[0].mtf, (std::vector{0.991, 0.962}));
  const auto grey = parse_curve_samples(head + ",\"Frequency, cy/mm\",SFR\n,0,1\n,1.5,0.97\n", "s.csv");
  EXPECT_EQ(grey.at(0).name, "column SFR");
  EXPECT_EQ(grey[0].unit->name, "cy/mm");
  expect_says(refusal(head + ",Frequency,SFR\n,0,1\n"), {"c.csv:8:", "no unit"});
  expect_says(refusal(head + ",Frequency cy/mm,SFR-r,SFR-g\n,0,1,1\n"), {"c.csv:8:", "SFR-r, SFR-g"});
  expect_says(refusal(head + ",Frequency cy/mm,SFR\n,0,1\n,1,0.9x\n"), {"c.csv:10:", "0.9x"});
}

// The columns that Imatest's manual lists for its file _MTF.csv, of which further tables follow.
TEST(CurveSamples, OfImatest) {
  const std::string head = "Imatest,5.2,Master,SFR\nFile,chart.tif\n\n";
  const std::string rest = "\n\nx,Red edge,Green edge\n-3,0.1,0.1\n";
  const auto curves = parse_curve_samples(
      head + "Cy/mm,LW/PH,MTF(R),MTF(G),MTF(B),MTF(Y)\n0,0,1,1,1,1\n5,120,0.8,0.9,0.7,0.85" + rest, "i.csv");
  EXPECT_EQ(curves.at(0).name, "column MTF(Y)");
  EXPECT_EQ(curves[0].unit->name, "cy/mm");
  EXPECT_EQ(curves[0].mtf, std::vector{0.85});
  const auto selected =
      parse_curve_samples(head + "Cy/mm,Cy/Pxl,MTF,MTF(Red),MTF(Luminance)\n5,0.025,0.8,0.9,0.7\n" + rest, "i.csv");
  EXPECT_EQ(selected.at(0).name, "column MTF");
  EXPECT_EQ(selected[0].unit->name, "cy/px");
  EXPECT_EQ(selected[0].frequency, std::vector{0.025});
  for (const char* row : {"0.05x,0.7", "\"0,05\",0.7", "0,05,0.7", ",0.7", "0.05", "nan,0.7"})
    EXPECT_TRUE(says(refusal(head + "Cy/Pxl,MTF(Y)\n0.025,0.85\n" + row + "\n0.1,0.5\n"), "c.csv:6:")) << row;
  expect_says(refusal(head + "LW/PH,MTF\n120,0.85\n"), {"c.csv:4:", "frequency_cy_px"});
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
