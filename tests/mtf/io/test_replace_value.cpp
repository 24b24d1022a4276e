// SPDX-License-Identifier: Apache-2.0
// One value of a sensor file changed; everything else stays as it was written.

#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/replace_value.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using mtf::io::parse_config;
using mtf::io::replace_value;
using mtf::io::SensorConfig;

const std::string kHead =
    "# \xC2\xB5-lens\nschema = 1\n[frame]\nfocal_length = \"100 mm\" # nominal\npitch = \"15 um\"\n"
    "[optics]\nf_number = 2.0\nwavelength = \"4 um\"\n[[presample]]\nkind = \"diffraction\"\n";

SensorConfig read(const std::string& rest) {
  const auto result = parse_config(kHead + rest, "s.toml");
  for (const auto& found : result.diagnostics) EXPECT_FALSE(found.error) << found.text;
  return result.config;
}

/// What follows kHead after the change; kHead itself has to stay.
std::string after(const std::string& rest, const std::string& parameter, const std::string& value) {
  const std::string text = replace_value(read(rest), parameter, value);
  EXPECT_EQ(text.substr(0, kHead.size()), kHead);
  EXPECT_TRUE(parse_config(text, "s.toml").ok()) << text;
  return text.substr(kHead.size());
}

std::string refusal(const std::string& rest, const std::string& parameter, const std::string& value) {
  return message_of<mtf::UsageError>([&] { static_cast<void>(replaced(read(rest), parameter, value)); });
}

const std::string kJitter = "[[presample]]\n  kind = \"jitter\"\n  rms = \"20 urad\"  # mount\n";

}  // namespace

TEST(ReplaceValue, OnlyTheValueChanges) {
  EXPECT_EQ(after(kJitter, "jitter.rms", "0.5 px"),
            "[[presample]]\n  kind = \"jitter\"\n  rms = \"0.5 px\"  # mount\n");
  EXPECT_EQ(after(kJitter, "presample[1].rms", "10 urad"), after(kJitter, "jitter.rms", "10 urad"));
  const std::string text = replace_value(read(kJitter), "frame.focal_length", "101 mm");
  expect_says(text, {"focal_length = \"101 mm\" # nominal\npitch"});
}

TEST(ReplaceValue, APairOfAxesIsWrittenAsOneValueOrAsTwo) {
  const std::string apart =
      "[[presample]]\n  kind = \"jitter\"\n  rms_x = \"20 urad\"\n  rms_y = \"5 urad\"  # mount\n";
  EXPECT_EQ(after(kJitter, "jitter.rms_y", "5 urad"), apart);
  EXPECT_EQ(after(apart, "jitter.rms", "1 urad"), "[[presample]]\n  kind = \"jitter\"\n  rms = \"1 urad\"\n");
  const std::string text = replace_value(
      parse_config(replace_value(read(""), "frame.pitch_y", "12 um"), "s.toml").config, "frame.pitch_x", "9 um");
  expect_says(text, {"pitch_x = \"9 um\"\npitch_y = \"12 um\"\n"});
}

TEST(ReplaceValue, AKeyThatIsNotThereIsAdded) {
  const std::string pan = "[[presample]]\n\tkind = \"linear_motion\" # pan\n\ttravel = \"3 um\" # slow";
  EXPECT_EQ(after(pan + "\n\n# end\n", "linear_motion.direction", "45 deg"),
            pan + "\n\tdirection = \"45 deg\"\n\n# end\n");
  EXPECT_EQ(after(pan, "linear_motion.direction", "45 deg"), pan + "\n\tdirection = \"45 deg\"");
}

TEST(ReplaceValue, InlineTablesAndListsAreEditedInPlace) {
  const std::string inline_tables =
      "[[postsample]]\nkind = \"fir\"\ntaps = [[0, -0.25, 0], # row\n [-0.25, 2.0, -0.25], [0, -0.25, 0]]\n";
  EXPECT_EQ(after(inline_tables, "fir.taps", "[[1.0]]"), "[[postsample]]\nkind = \"fir\"\ntaps = [[1.0]]\n");
  const std::string waves =
      "[[presample]]\nkind = \"wavefront\"\nzernike = [0.0, 0.0, { value = 0.1, fit = true }, 0.05]\n";
  const auto result = parse_config(
      "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n[optics]\nf_number = 2.0\n"
      "wavelength = \"4 um\"\n" +
          waves,
      "s.toml");
  ASSERT_TRUE(result.ok());
  expect_says(replace_value(result.config, "wavefront.zernike[3]", "-0.1"), {"fit = true }, -0.1]"});
  expect_says(replace_value(result.config, "wavefront.zernike[2]", "0.2"), {"{ value = 0.2, fit = true }"});
}

TEST(ReplaceValue, TheSensorIsThatOfTheNewText) {
  const SensorConfig sensor = replaced(read(kJitter), "optics.f_number", "4");
  EXPECT_EQ(sensor.system.optics.f_number, 4.0);
  expect_says(sensor.text, {"f_number = 4\n"});
  EXPECT_NE(sensor.sha256, read(kJitter).sha256);
}

// Schedules and studies do not reach these; a user who changes a file does.
TEST(ReplaceValue, EveryKeyOfATableCanBeSet) {
  EXPECT_EQ(after("", "scene.border", "periodic"), "\n[scene]\nborder = \"periodic\"\n");
  EXPECT_EQ(after("[scene]\nsample = \"3 um\"\n" + kJitter, "scene.border", "periodic"),
            "[scene]\nsample = \"3 um\"\nborder = \"periodic\"\n" + kJitter);
  const std::string format = replace_value(read(kJitter), "frame.format", "[640, 512]");
  expect_says(format, {"pitch = \"15 um\"\nformat = [640, 512]\n"});
  const SensorConfig with_format = parse_config(format, "s.toml").config;
  expect_says(replace_value(with_format, "frame.format[1]", "480"), {"[640, 480]"});
  expect_says(refusal(kJitter, "scene.bordr", "periodic"), {"did you mean \"border\"?"});
  expect_says(refusal(kJitter, "scene.border[0]", "x"), {"0 elements"});
  for (const char* name : {"scene.", "scene", ".border", "scene.a b", "scene.a\n[x]", "sceen.border", "scene[0].x"})
    EXPECT_TRUE(says(refusal(kJitter, name, "1"), "no parameter")) << name;
}

TEST(ReplaceValue, MistakesAreNamed) {
  expect_says(refusal(kJitter, "jiter.rms", "1 px"), {"did you mean jitter.rms"});
  expect_says(refusal(kJitter, "jitter.rms", "3 kg"), {"s.toml:13:9: error"});
  expect_says(refusal(kJitter, "frame.pitch", "-1 um"), {"pitch"});
  expect_says(refusal(kJitter, "jitter.rms[2]", "1 px"), {"elements"});
  expect_says(refusal(kJitter, "jitter.rms", "\"\n[evil]\nx = 1"), {"s.toml"});
  expect_says(refusal(kJitter, "jitter.rms", "[1, 2"), {"s.toml"});
}

TEST(ReplaceValue, DottedKeysAreRefused) {
  const std::string text =
      "schema = 1\nframe.focal_length = \"100 mm\"\nframe.pitch = \"15 um\"\n[optics]\nf_number = 2.0\n"
      "wavelength = \"4 um\"\n[[presample]]\nkind = \"diffraction\"\n";
  const auto result = parse_config(text, "s.toml");
  ASSERT_TRUE(result.ok());
  expect_says(replace_value(result.config, "frame.pitch", "9 um"), {"frame.pitch = \"9 um\"\n"});
  EXPECT_THROW(static_cast<void>(replace_value(result.config, "frame.integration_time", "1 ms")), mtf::UsageError);
}

// Each value of the starter file set to itself: the text stays, byte for byte, up to how numbers are written.
TEST(ReplaceValue, EveryValueOfTheStarterFileCanBeSetToItself) {
  const SensorConfig starter = parse_config(mtf::io::starter_config(), "s.toml").config;
  const mtf::io::cfg::Tree tree = mtf::io::cfg::read_tree(starter.text);
  int values = 0;
  for (const auto& [name, target] : mtf::io::cfg::targets_of(starter)) {
    const mtf::io::cfg::Node* table = tree.root.find(target.table);
    if (table != nullptr && target.component) table = &table->items.at(target.index);
    const mtf::io::cfg::Node* value = table != nullptr ? table->find(target.key) : nullptr;
    if (value == nullptr || value->kind != mtf::io::cfg::Node::Kind::string) continue;
    EXPECT_EQ(replace_value(starter, name, value->text), starter.text) << name;
    ++values;
  }
  EXPECT_GE(values, 5);
}

TEST(ReplaceValue, ATableWithAFitTakesThePlaceOfANumber) {
  const std::string marked = "{ value = \"20 urad\", fit = true, max = \"50 urad\" }";
  EXPECT_EQ(after(kJitter, "jitter.rms", marked),
            "[[presample]]\n  kind = \"jitter\"\n  rms = " + marked + "  # mount\n");
  const SensorConfig fitted = replaced(read(kJitter), "jitter.rms", marked);
  ASSERT_EQ(fitted.fits.size(), 1U);
  EXPECT_TRUE(fitted.fits.front().fit);
  EXPECT_EQ(fitted.fits.front().max, 50.0);
  // A number changes the value in it, another table all of it.
  expect_says(replaced(fitted, "jitter.rms", "30 urad").text, {"{ value = \"30 urad\", fit = true"});
  expect_says(replaced(fitted, "jitter.rms", "{ value = \"30 urad\" }").text,
              {"rms = { value = \"30 urad\" }  # mount"});
  EXPECT_NE(refusal(kJitter, "jitter.rms", "{ value = "), "");
  EXPECT_NE(refusal(kJitter, "jitter.rms", "{ value = \"20 urad\", most = 3 }"), "");
}

TEST(ReplaceValue, TheValueThatAFileStates) {
  EXPECT_EQ(mtf::io::stated_value(read(kJitter), "jitter.rms"), "\"20 urad\"");
  EXPECT_EQ(mtf::io::stated_value(read(kJitter), "jitter.rms_y"), "\"20 urad\"");
  EXPECT_EQ(mtf::io::stated_value(read(kJitter), "optics.f_number"), "2.0");
  EXPECT_EQ(mtf::io::stated_value(read(kJitter), "optics.obscuration"), "");
  const SensorConfig fitted = replaced(read(kJitter), "jitter.rms", "{ value = \"1 px\", fit = true }");
  EXPECT_EQ(mtf::io::stated_value(fitted, "jitter.rms"), "\"1 px\"");
  EXPECT_THROW(mtf::io::stated_value(fitted, "jitter.rmz"), mtf::UsageError);
}

TEST(ReplaceValue, AKeyGoesOut) {
  const SensorConfig sensor = read(kJitter);
  const std::string without = mtf::io::without_value(sensor, "optics.wavelength");
  EXPECT_EQ(without, [&] {
    std::string text = sensor.text;
    return text.erase(text.find("wavelength = \"4 um\"\n"), std::string("wavelength = \"4 um\"\n").size());
  }());
  // Of a component, whose comment goes with it.
  EXPECT_EQ(mtf::io::without_value(sensor, "jitter.rms"), kHead + "[[presample]]\n  kind = \"jitter\"\n");
  for (const char* name :
       {"optics.aperture", "jitter.rms_x", "diffraction.obscuration", "frame.nothing", "nothing.rms"})
    EXPECT_THROW(static_cast<void>(mtf::io::without_value(sensor, name)), mtf::UsageError) << name;
}

TEST(ReplaceValue, TermsOfANumberThatChangesOverTheField) {
  const std::string lens = "[[presample]]\nkind = \"rms_wavefront\"\nrms = ";
  EXPECT_EQ(after(lens + "{ 1 = 0.05, r2 = 0.1 } # here\n", "rms_wavefront.rms.r2", "0.2"),
            lens + "{ 1 = 0.05, r2 = 0.2 } # here\n");
  EXPECT_EQ(after(lens + "{ r2 = 0.1 }\n", "presample[1].rms.1", "0.05"), lens + "{ r2 = 0.1, 1 = 0.05 }\n");
  EXPECT_EQ(after(lens + "0.05\n", "rms_wavefront.rms.1", "0.07"), lens + "{ 1 = 0.07 }\n");
  // A number that gets a term is that of the optical axis.
  EXPECT_EQ(after(lens + "0.05\n", "rms_wavefront.rms.x", "0.01"), lens + "{ 1 = 0.05, x = 0.01 }\n");
  const std::string jitter = "[[presample]]\nkind = \"jitter\"\n";
  EXPECT_EQ(after(jitter + "rms = \"1 um\"\n", "jitter.rms_y.r2", "2 um"),
            jitter + "rms_x = \"1 um\"\nrms_y = { 1 = \"1 um\", r2 = \"2 um\" }\n");
  const SensorConfig config = read(lens + "{ 1 = 0.05, r2 = 0.1 }\n");
  EXPECT_EQ(mtf::io::stated_value(config, "rms_wavefront.rms.r2"), "0.1");
  EXPECT_EQ(mtf::io::stated_value(config, "rms_wavefront.rms.xy"), "");
  expect_says(mtf::io::without_value(config, "rms_wavefront.rms.r2"), {"rms = { 1 = 0.05 }"});
  expect_says(refusal(lens + "{ r2 = 0.1 }\n", "rms_wavefront.rms", "0.1"), {"name one of its terms"});
  expect_says(refusal(jitter + "rms_x = \"1 um\"\nrms_y = \"1 um\"\n", "jitter.rms.r2", "1 um"), {"rms_x and rms_y"});
  expect_says(refusal(lens + "0.05\n", "rms_wavefront.rms.r3", "0.1"), {"no parameter"});
  expect_says(refusal(lens + "0.05\n", "optics.f_number.r2", "0.1"), {"no parameter"});
}
