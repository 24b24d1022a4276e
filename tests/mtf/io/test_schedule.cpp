// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/schedule.h"

#include <gtest/gtest.h>

#include "tests/expect_error.h"

namespace mtf::io {
namespace {

constexpr const char* kSensor = R"(schema = 1
name = "test"
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "10 ms"
[scene]
ifov = "37.5 urad"
[optics]
f_number = 2.0
wavelength = "4 um"
[[presample]]
kind = "wavefront"
zernike = [0, 0, 0, 0.1]
[[presample]]
kind = "jitter"
rms = { value = "8 urad", fit = true }
[[presample]]
kind = "footprint"
fill_factor = 1.0
[[postsample]]
kind = "fir"
label = "sharpen"
taps = [[1.0]]
)";

SensorConfig sensor() {
  const ConfigResult result = parse_config(kSensor, "sensor.toml");
  for (const Diagnostic& d : result.diagnostics) EXPECT_FALSE(d.error) << format_diagnostic(d, "sensor.toml");
  return result.config;
}

ScheduledSensor scheduled(const std::string& lines) {
  const SensorConfig config = sensor();
  return {config, parse_schedule("frame,parameter,value\n" + lines, "s.csv", config)};
}

void expect_text_refused(const std::string& text, std::initializer_list<std::string_view> words) {
  SCOPED_TRACE(text);
  expect_refused(words, [&] { static_cast<void>(parse_schedule(text, "s.csv", sensor())); });
}

void expect_line_refused(const std::string& line, std::initializer_list<std::string_view> words) {
  expect_text_refused("frame,parameter,value\n" + line + "\n", words);
}

double jitter_um(const SensorConfig& config) {
  for (const FieldRef<double>& field : config.system.list(Stage::presample)[1].component.fields())
    if (field.info->name == "rms") return std::get<AxisPair<double>*>(field.value)->x_um(config.system.frame);
  return -1.0;
}

TEST(Schedule, ValuesHoldFromTheirFrameOn) {
  ScheduledSensor s = scheduled("5,jitter.rms,20 urad\n2,jitter.rms,10 urad\n5,frame.integration_time,5 ms\n");
  EXPECT_FALSE(s.advance(0));
  EXPECT_DOUBLE_EQ(jitter_um(s.sensor()), 0.8);
  EXPECT_TRUE(s.advance(2));
  EXPECT_DOUBLE_EQ(jitter_um(s.sensor()), 1.0);
  EXPECT_FALSE(s.advance(4));
  EXPECT_EQ(s.in_force(), "jitter.rms = 10 urad");
  EXPECT_TRUE(s.advance(100));
  EXPECT_DOUBLE_EQ(jitter_um(s.sensor()), 2.0);
  EXPECT_DOUBLE_EQ(s.sensor().system.frame.integration_time_s, 0.005);
  EXPECT_EQ(s.sensor().sha256, sensor().sha256);
}

// What a schedule sets is what the sensor file would have said.
TEST(Schedule, EqualsTheFileWithTheValueInIt) {
  ScheduledSensor s = scheduled(
      "1,wavefront.zernike[3],0.25\n1,presample[1].rms_x,12 um\n1,optics.f_number,4\n1,frame.focal_length,0.2 m\n"
      "1,sharpen.taps,\"[[0, 0.5, 0.5]]\"\n1,frame.pitch_x,20 um\n");
  ASSERT_TRUE(s.advance(1));
  std::string text = kSensor;
  const auto replace = [&](const std::string& what, const std::string& with) {
    text.replace(text.find(what), what.size(), with);
  };
  replace("zernike = [0, 0, 0, 0.1]", "zernike = [0, 0, 0, 0.25]");
  replace("rms = { value = \"8 urad\", fit = true }", "rms_x = \"12 um\"\nrms_y = \"8 urad\"");
  replace("f_number = 2.0", "f_number = 4.0");
  replace("\"100 mm\"", "\"200 mm\"");
  replace("[[1.0]]", "[[0, 0.5, 0.5]]");
  replace("pitch = \"15 um\"", "pitch_x = \"20 um\"\npitch_y = \"15 um\"");
  const ConfigResult expected = parse_config(text, "sensor.toml");
  ASSERT_TRUE(expected.ok());
  const Freq<double> f{11.0, 7.0};
  EXPECT_EQ(s.sensor().system.otf(f).re, expected.config.system.otf(f).re);
  EXPECT_EQ(s.sensor().system.otf(f).im, expected.config.system.otf(f).im);
  EXPECT_EQ(s.sensor().system.frame.pitch_x_um, 20.0);
  EXPECT_EQ(s.sensor().system.frame.pitch_y_um, 15.0);
  EXPECT_EQ(s.sensor().scene.sample_x_um, expected.config.scene.sample_x_um);  // an angle: follows the focal length
}

TEST(Schedule, AValueForBothAxesTakesThePlaceOfTwo) {
  ScheduledSensor s = scheduled("1,frame.pitch_x,20 um\n2,frame.pitch,15 um\n3,frame.pitch_y,30 um\n");
  ASSERT_TRUE(s.advance(1));
  ASSERT_TRUE(s.advance(2));
  EXPECT_EQ(s.sensor().system.frame.pitch_x_um, 15.0);
  EXPECT_EQ(s.in_force(), "frame.pitch = 15 um");
  ASSERT_TRUE(s.advance(3));
  EXPECT_EQ(s.sensor().system.frame.pitch_x_um, 15.0);
  EXPECT_EQ(s.sensor().system.frame.pitch_y_um, 30.0);
}

TEST(Schedule, ChangesTheBand) {
  std::string text = kSensor;
  const std::string one = "wavelength = \"4 um\"\n";
  text.replace(text.find(one), one.size(), "[band]\nwavelength = [\"3.7 um\", \"4.8 um\"]\n");
  const SensorConfig config = parse_config(text, "sensor.toml").config;
  ScheduledSensor changing(
      config, parse_schedule("frame,parameter,value\n2,band.wavelength,\"[\"\"3.4 um\"\", \"\"5 um\"\"]\"\n"
                             "4,band.wavelength[1],4.5 um\n",
                             "s.csv", config));
  const auto ends = [&](std::int64_t frame) {
    changing.advance(frame);
    return std::pair{changing.sensor().system.band->lo_um, changing.sensor().system.band->hi_um};
  };
  EXPECT_EQ(ends(1), std::pair(3.7, 4.8));
  EXPECT_EQ(ends(2), std::pair(3.4, 5.0));
  EXPECT_EQ(ends(4), std::pair(3.4, 4.5));
}

TEST(Schedule, ReadsWhatSpreadsheetsWrite) {
  const SensorConfig config = sensor();
  for (const char* text :
       {"\xEF\xBB\xBF"
        "frame,parameter,value\r\n3,jitter.rms,9 urad\r\n",
        "frame,parameter,value\r3,jitter.rms,9 urad\r",
        "# note\n\n\"frame\" , \"parameter\",\"value\"\n 3 , \"jitter.rms\" ,\"9 urad\"",
        "frame;parameter;value\n3;jitter.rms;9 urad\n\n", "value\tframe\tparameter\n9 urad\t3\tjitter.rms\n"}) {
    const Schedule schedule = parse_schedule(text, "s.csv", config);
    ASSERT_EQ(schedule.settings.size(), 1U) << text;
    EXPECT_EQ(schedule.settings[0].frame, 3);
    EXPECT_EQ(schedule.settings[0].parameter, "jitter.rms");
    EXPECT_EQ(schedule.settings[0].value, "9 urad");
  }
}

TEST(Schedule, NamesTheLineAndTheWayOut) {
  expect_line_refused("1,jiter.rms,8 urad", {"s.csv:2: error:", "did you mean jitter.rms?"});
  expect_line_refused("1,jitter,8 urad", {"s.csv:2:", "no parameter 'jitter'"});
  expect_line_refused("1,frame.format,\"[64, 64]\"", {"frame.format"});
  expect_line_refused("1,jitter.rms,8", {"s.csv:2:", "jitter.rms = 8", "has no unit"});
  expect_line_refused("1,jitter.rms,8 ms", {"s.csv:2:", "ms"});
  expect_line_refused("1,jitter.rms,-1 urad", {"s.csv:2:", "jitter.rms"});
  expect_line_refused("1,optics.f_number,two", {"s.csv:2:", "plain number"});
  expect_line_refused("1,optics.f_number,nan", {"not finite"});
  expect_line_refused("1,optics.f_number,0", {"s.csv:2:", "f_number"});
  expect_line_refused("1,wavefront.zernike[4],0.1", {"s.csv:2:", "4 elements"});
  expect_line_refused("1,wavefront.zernike[x],0.1", {"no parameter"});
  expect_line_refused("1,wavefront.zernike[3],11", {"s.csv:2:", "zernike"});
  expect_line_refused("1,sharpen.taps,\"[[1,\"", {"s.csv:2:", "taps"});
  expect_line_refused("1,jitter.rms,8 urad\n\n1,presample[1].rms,9 urad", {"s.csv:4:", "by line 2 already"});
  expect_line_refused("one,jitter.rms,8 urad", {"'one' is no frame"});
  expect_line_refused("-1,jitter.rms,8 urad", {"'-1' is no frame"});
  expect_line_refused("1e3,jitter.rms,8 urad", {"is no frame"});
  expect_line_refused("99999999999999999999,jitter.rms,8 urad", {"is no frame"});
  expect_line_refused("1,jitter.rms", {"2 values where 3 belong"});
  expect_line_refused("1,sharpen.taps,[[0, 1]]", {"4 values where 3 belong", "double quotes"});
  expect_line_refused("1,jitter.rms,\"8 urad", {"a quote is open"});
  expect_line_refused("1,,8 urad", {"no parameter is named"});
  expect_line_refused("1,jitter.rms,", {"no value"});
  expect_line_refused("1,jiter.rms,1\n2,optics.f,1", {"s.csv:2:", "s.csv:3:"});  // all in one pass
}

TEST(Schedule, FilesThatAreNone) {
  expect_text_refused("", {"s.csv:1: error:", "frame,parameter,value"});
  expect_text_refused("\n\n# nothing\n", {"nothing is in it"});
  expect_text_refused("frame,parameter,value\n", {"sets a parameter"});
  expect_text_refused("1,jitter.rms,8 urad\n", {"first line", "frame,parameter,value"});
  expect_text_refused(std::string("\x89PNG\r\n\x1a\n\0\0\0", 11), {"s.csv:"});
  expect_text_refused("frame,parameter,value\n1,jitter.rms,\x01\n", {"s.csv:2:", "no text"});
  expect_text_refused("frame,parameter,value,unit\n", {"found: frame,parameter,value,unit"});
  EXPECT_THROW(read_schedule("no-such-file.csv", sensor()), RuntimeError);
}

}  // namespace
}  // namespace mtf::io
