// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/jitter.h"
#include "mtf/components/wavefront.h"
#include "mtf/io/config/config.h"
#include "mtf/io/config/replace_value.h"
#include "tests/expect_error.h"

// Numbers of a sensor file that change over the field of view.

namespace mtf::io {
namespace {

const std::string kHead =
    "schema = 2\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\nformat = [640, 512]\n[optics]\nf_number = "
    "2.0\nwavelength = \"4 um\"\n";
const std::string kLens =
    "[[presample]]\nkind = \"wavefront\"\norientation = \"field\"\nw040 = 0.25\nw131 = { r = 0.7 }\nw222 = { r2 = 1.0 "
    "}\n"
    "w020 = { 1 = -0.3, r2 = 0.5, x = 0.06 }\nzernike = [0, 0, 0, { 1 = 0.1, y2 = 0.2 }]\n"
    "[[presample]]\nkind = \"jitter\"\nrms_x = { x = \"1 um\", 1 = \"0.002 mm\" }\nrms_y = \"1 um\"\nroll = \"300 "
    "urad\"\n";

SensorConfig parsed(const std::string& body) {
  const ConfigResult result = parse_config(kHead + body, "s.toml");
  EXPECT_TRUE(result.ok()) << format_diagnostic(result.diagnostics.front(), "s.toml");
  return result.config;
}

void expect_error(const std::string& body, std::initializer_list<std::string_view> parts) {
  const ConfigResult result = parse_config(kHead + body, "s.toml");
  ASSERT_FALSE(result.ok());
  expect_says(format_diagnostic(result.diagnostics.front(), "s.toml"), parts);
}

TEST(ConfigField, TermsMakeTheSystemOfAFieldPoint) {
  const SensorConfig config = parsed(kLens);
  EXPECT_FALSE(config.system.is_isoplanatic());
  const FieldPoint<double> q{0.8, 0.6};
  const System<double> here = config.system.at(q);
  const auto* lens = here.list(Stage::presample)[0].component.get_if<Wavefront<double>>();
  EXPECT_DOUBLE_EQ(*lens->w040, 0.25);
  EXPECT_DOUBLE_EQ(*lens->w131, 0.7);
  EXPECT_DOUBLE_EQ(*lens->w222, 1.0);
  EXPECT_NEAR(*lens->w020, -0.3 + 0.5 + 0.06 * 0.8, 1e-15);
  EXPECT_NEAR(lens->zernike[3], 0.1 + 0.2 * 0.36, 1e-15);
  EXPECT_NEAR(lens->orientation_deg.value, 36.869897645844021, 1e-12);
  const auto* jitter = here.list(Stage::presample)[1].component.get_if<Jitter<double>>();
  EXPECT_NEAR(jitter->rms.x_um(here.frame), 2.0 + 0.8, 1e-12);
  EXPECT_DOUBLE_EQ(jitter->rms.y_um(here.frame), 1.0);
}

TEST(ConfigField, WritingReadsBackAsTheSame) {
  const SensorConfig config = parsed(kLens);
  const ConfigResult again = parse_config(write_config(config), "s.toml");
  ASSERT_TRUE(again.ok()) << format_diagnostic(again.diagnostics.front(), "s.toml");
  EXPECT_EQ(again.config.system.field, config.system.field);
  const Freq<double> f{30.0, 20.0};
  const Complex<double> a = config.system.at({-0.5, 0.2}).otf(f), b = again.config.system.at({-0.5, 0.2}).otf(f);
  EXPECT_EQ(a.re, b.re);
  EXPECT_EQ(a.im, b.im);
}

TEST(ConfigField, ANewValueIsThatOfTheAxisAndTermsStay) {
  const SensorConfig config = replaced(parsed(kLens), "wavefront.w020", "0.1");
  const auto* lens = config.system.list(Stage::presample)[0].component.get_if<Wavefront<double>>();
  EXPECT_DOUBLE_EQ(*lens->w020, 0.1);
  EXPECT_EQ(config.system.field, parsed(kLens).system.field);
}

TEST(ConfigField, TheNoteNamesWhatChanges) {
  const ConfigResult result = parse_config(kHead + kLens, "s.toml");
  std::string notes;
  for (const Diagnostic& one : result.diagnostics)
    if (one.remark) notes += one.text + "\n";
  expect_says(notes, {"presample[0].w131", "presample[1].jitter", "--field"});
}

TEST(ConfigField, TermsOfZeroAreTheSameEverywhere) {
  const SensorConfig config = parsed("[[presample]]\nkind = \"wavefront\"\nw131 = { 1 = 0.3 }\nw222 = { x = 0.0 }\n");
  EXPECT_TRUE(config.system.is_isoplanatic());
  const auto* lens = config.system.list(Stage::presample)[0].component.get_if<Wavefront<double>>();
  EXPECT_DOUBLE_EQ(*lens->w131, 0.3);
  EXPECT_DOUBLE_EQ(*lens->w222, 0.0);
}

TEST(ConfigField, TermsCanBeFitted) {
  const std::string lens =
      "[[presample]]\nkind = \"wavefront\"\norientation = \"field\"\nw020 = { 1 = { value = -0.3, fit = true }, r2 = "
      "0.5, x = { value = 0.0, fit = true, min = -1.0, max = 2.0, prior = { mean = 0.1, sd = 0.2 } } }\n"
      "w040 = { y = { value = 0.0, interval = [-0.1, 0.2] } }\n"
      "[[presample]]\nkind = \"jitter\"\nrms = { 1 = \"2 um\", r2 = { value = \"1 um\", stderr = \"0.1 um\" } }\n";
  SensorConfig config = parsed(lens);
  ASSERT_EQ(config.fits.size(), 4u);
  EXPECT_EQ(config.fits[0].path, "presample[0].w020.1");
  EXPECT_EQ(config.fits[1].path, "presample[0].w020.x");
  EXPECT_EQ(config.fits[1].max, 2.0);
  EXPECT_EQ(config.fits[1].prior, (std::array{0.1, 0.2}));
  EXPECT_EQ(config.fits[2].interval, (std::array{-0.1, 0.2}));
  EXPECT_EQ(config.fits[3].unit, "um");
  EXPECT_EQ(config.system.field.numbers.size(), 3u);  // terms of 0 stay where they are in tables

  const ConfigResult again = parse_config(write_config(config), "s.toml");
  ASSERT_TRUE(again.ok()) << format_diagnostic(again.diagnostics.front(), "s.toml");
  EXPECT_EQ(again.config.system.field, config.system.field);
  ASSERT_EQ(again.config.fits.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const FitSpec &a = config.fits[i], &b = again.config.fits[i];
    EXPECT_EQ(std::tie(a.path, a.fit, a.unit, a.value, a.min, a.max, a.stderr_value, a.prior, a.interval),
              std::tie(b.path, b.fit, b.unit, b.value, b.min, b.max, b.stderr_value, b.prior, b.interval));
  }
  config.fits[1].stderr_value = 0.01;
  const std::vector<std::optional<double>> values{-0.25, 0.06, std::nullopt, 0.9};
  const SensorConfig fitted = parse_config(splice_fits(config, values), "s.toml").config;
  EXPECT_EQ(fitted.fits[1].stderr_value, 0.01);
  const auto* there = fitted.system.at({1.0, 0.0}).list(Stage::presample)[0].component.get_if<Wavefront<double>>();
  EXPECT_NEAR(*there->w020, -0.25 + 0.5 + 0.06, 1e-15);
}

TEST(ConfigField, ALensThatKeepsItsDirectionIsNamed) {
  const auto notes = [](const std::string& body) {
    std::string text;
    for (const Diagnostic& one : parse_config(kHead + body, "s.toml").diagnostics) text += one.text + "\n";
    return text;
  };
  const std::string lens = "[[presample]]\nkind = \"wavefront\"\nw131 = { r = 0.7 }\n";
  expect_says(notes(lens), {"orientation = \"field\"", "kink"});
  EXPECT_EQ(notes(lens + "orientation = \"field\"\n").find("kink"), std::string::npos);
}

TEST(ConfigField, WhatCannotBeIsRefused) {
  expect_error("[[presample]]\nkind = \"wavefront\"\nw131 = { rr = 0.7 }\n", {"rr", "r2", "xy"});
  expect_error("[[presample]]\nkind = \"wavefront\"\nw131 = { r = 0.7, r3 = 1 }\n", {"r3", "r4"});
  expect_error("[[presample]]\nkind = \"jitter\"\nrms = { 1 = \"2 um\", r = \"3 urad\" }\n", {"um", "one unit"});
  expect_error("[[presample]]\nkind = \"jitter\"\nrms = { 1 = \"2 um\", r = 3 }\n", {"unit"});
  expect_error("[[presample]]\nkind = \"jitter\"\nrms = { 1 = \"2 um\", r2 = { value = \"1 mm\", fit = true } }\n",
               {"rms.r2", "one unit"});
  expect_error("[[presample]]\nkind = \"wavefront\"\nw020 = { x = { fit = true } }\n", {"w020.x", "value"});
  expect_error("[[readout]]\nkind = \"crosstalk\"\nside = { 1 = 0.02, r2 = 0.01 }\n",
               {"readout[0].side", "[[presample]]"});
  expect_error("[[presample]]\nkind = \"footprint\"\nwidth = { 1 = \"2 um\", x = \"-4 um\" }\n",
               {"presample[0].width", "field point"});
  expect_error("[[presample]]\nkind = \"wavefront\"\norientation = \"fields\"\n", {"orientation"});
  const ConfigResult frame = parse_config(
      "schema = 2\n[frame]\nfocal_length = { 1 = \"100 mm\", r = \"1 mm\" }\npitch = \"15 um\"\n", "s.toml");
  expect_says(format_diagnostic(frame.diagnostics.front(), "s.toml"), {"frame.focal_length", "one number"});
}

TEST(ConfigField, TablesOfTheChainAreRefused) {
  const FieldInfo row{
      .name = "x", .dimension = Dimension::pixel, .unit = "px", .lo = -10.0, .hi = 10.0, .example = "\"3 px\""};
  const std::vector<TableInfo> schema{{"optical_axis", "the axis", {row}}};
  const ConfigResult terms = parse_config(kHead + "[optical_axis]\nx = { 1 = \"3 px\" }\n" + kLens, "s.toml", schema);
  ASSERT_FALSE(terms.ok());
  expect_says(format_diagnostic(terms.diagnostics.front(), "s.toml"), {"optical_axis.x", "one number"});
  const ConfigResult axis = parse_config(kHead + "[optical_axis]\nx = \"3 px\"\n" + kLens, "s.toml", schema);
  ASSERT_TRUE(axis.ok());
  EXPECT_EQ(axis.config.system.field.axis_x_px, 3.0);
  const ConfigResult fitted =
      parse_config(kHead + "[optical_axis]\nx = { value = \"3 px\", fit = true }\n" + kLens, "s.toml", schema);
  ASSERT_TRUE(fitted.ok());
  EXPECT_EQ(fitted.config.fits.at(0).path, "optical_axis.x");
  EXPECT_EQ(fitted.config.system.field.axis_x_px, 3.0);
}

}  // namespace
}  // namespace mtf::io
