// SPDX-License-Identifier: Apache-2.0
// [scene] encoding: a scene whose file states a curve is refused until the sensor file says what to do with it.

#include "mtf/io/scene.h"

#include <OpenEXR/ImfVecAttribute.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "io_test_files.h"
#include "mtf/error.h"
#include "png_chunks.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace mtf::io {
namespace {

using io_test::TempFolder;

const std::string kHead = "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n[scene]\n";
const std::string kUnits = "sample = \"5 um\"\nquantity = \"radiance\"\ngain = 0.5\noffset = 10.0\n";
constexpr std::array<float, 5> kStored{0.0F, 1000.0F, 20000.0F, 32768.0F, 65535.0F};
// 65535 times the curves of IEC 61966-2-1 and of exponent 2.2 at stored / 65535, by mpmath with 20 digits.
constexpr std::array kSrgb{0.0, 77.399380804953560, 4969.5343052737303, 14027.648937611563, 65535.0};
constexpr std::array kGamma{0.0, 6.6104653857166318, 4813.9106586314760, 14263.361598596329, 65535.0};

class SceneEncoding : public testing::Test {
 protected:
  SceneEncoding() {
    Image image(kStored.size(), 1);
    std::copy(kStored.begin(), kStored.end(), image.data());
    for (const char* name : {"plain.png", "srgb.png", "gamma.png", "linear.png", "adobe.png"})
      write_integer(folder / name, {{"Y", image.view()}}, {}, {});
    io_test::add_chunks(folder / "srgb.png", {io_test::srgb_chunk()});
    io_test::add_chunks(folder / "gamma.png", {io_test::gamma_chunk(45455)});
    io_test::add_chunks(folder / "linear.png", {io_test::gamma_chunk(100000)});
    io_test::add_chunks(folder / "adobe.png", {io_test::profile_chunk("Adobe RGB (1998)")});
    write_exr(folder / "scene.exr", {{"Y", image.view()}}, {});
  }
  SensorConfig sensor(const std::string& keys) const {
    const ConfigResult result = parse_config(kHead + keys, folder / "s.toml");
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : format_diagnostic(result.diagnostics[0], "s.toml"));
    return result.config;
  }
  Scene load(const std::string& keys, const std::string& name) const {
    return load_scene(sensor(kUnits + keys), folder / name, {});
  }
  template <class Light>
  static void expect_values(const Scene& scene, const Light& light) {
    for (std::size_t i = 0; i < kStored.size(); ++i) {  // both roundings are of float32
      const double value = 0.5 * light(i) + 10.0;
      EXPECT_NEAR(scene.planes[0].data()[i], value, 2e-7 * value) << i;
    }
  }
  TempFolder folder;
};

TEST_F(SceneEncoding, AStatedCurveIsRefusedUntilTheSensorFileSays) {
  for (const auto& [name, says] : {std::pair{"srgb.png", "encoding = \"srgb\""},
                                   {"gamma.png", "encoding = \"gamma:2.2\""},
                                   {"adobe.png", "Adobe RGB (1998)"}}) {
    const std::string message = message_of<UsageError>([&] { load("", name); });
    for (const std::string& part : {std::string(says), std::string("encoding = \"linear\""), std::string("s.toml")})
      expect_says(message, {part});
  }
  // All that is missing, at once.
  const std::string all = message_of<UsageError>(
      [&] { static_cast<void>(load_scene(sensor("sample = \"5 um\"\n"), folder / "srgb.png", {})); });
  expect_says(all, {"gain, offset, quantity", "encoding = \"srgb\""});
}

TEST_F(SceneEncoding, TheCurveIsUndoneBeforeGainAndOffset) {
  expect_values(load("encoding = \"srgb\"\n", "srgb.png"), [](std::size_t i) { return kSrgb[i]; });
  expect_values(load("encoding = \"srgb\"\n", "plain.png"), [](std::size_t i) { return kSrgb[i]; });
  expect_values(load("encoding = \"gamma\"\n", "plain.png"), [](std::size_t i) { return kGamma[i]; });
  expect_values(load("encoding = \"gamma:2.2\"\n", "gamma.png"), [](std::size_t i) { return kGamma[i]; });
  EXPECT_TRUE(load("encoding = \"gamma:2.2\"\n", "gamma.png").warnings.empty());
  io_test::write_bytes(folder / "oecf.csv", "stored,linear\n0,1\n32768,3\n65535,7\n");
  const Scene table = load("encoding = \"oecf.csv\"\n", "plain.png");
  expect_values(table, [](std::size_t i) {
    return std::array{1.0, 1.0 + 2.0 * 1000 / 32768, 1.0 + 2.0 * 20000 / 32768, 3.0, 7.0}[i];
  });
  io_test::write_bytes(folder / "short.csv", "0,0\n30000,1\n");
  EXPECT_TRUE(says(load("encoding = \"short.csv\"\n", "plain.png").warnings, "2 samples lie outside"));
}

TEST_F(SceneEncoding, LinearTakesTheValuesAsTheyAre) {
  const auto stored = [](std::size_t i) { return static_cast<double>(kStored[i]); };
  for (const char* name : {"srgb.png", "gamma.png", "adobe.png", "plain.png"})
    expect_values(load("encoding = \"linear\"\n", name), stored);
  EXPECT_TRUE(says(load("encoding = \"linear\"\n", "srgb.png").warnings, "[scene] wins"));
  // Nothing to ask: no curve is stated, or a linear one.
  for (const char* name : {"plain.png", "linear.png"}) expect_values(load("", name), stored);
  // OpenEXR is linear by definition.
  const Scene exr = load("encoding = \"srgb\"\n", "scene.exr");
  expect_values(exr, stored);
  EXPECT_TRUE(says(exr.warnings, "linear by definition"));
}

TEST_F(SceneEncoding, TheSensorFileKeepsIt) {
  io_test::write_bytes(folder / "oecf.csv", "0,0\n65535,1\n");
  for (const std::string word : {"linear", "srgb", "gamma:1.8", "oecf.csv"}) {
    const SensorConfig config = sensor("encoding = \"" + word + "\"\n");
    const std::string text = write_config(config);
    expect_says(text, {"encoding = \"" + word + "\""});
    const ConfigResult again = parse_config(text, folder / "s.toml");
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again.config.scene.encoding->name, config.scene.encoding->name);
    EXPECT_EQ(again.config.scene.encoding->kind, config.scene.encoding->kind);
    const std::string explained = explain_config(config);
    expect_says(explained, {"scene.encoding", word});
  }
  EXPECT_FALSE(says(write_config(sensor("")), "encoding"));
  expect_says(explain_config(sensor("")), {"scene.encoding"});
}

// pHYs of 1000 x 2000 a metre, pixelAspectRatio 2: pixels twice as wide as high.
TEST_F(SceneEncoding, TheShapeOfPixelsHasToBeThatOfTheSamples) {
  Image image(4, 2);
  std::fill(image.data(), image.data() + image.size(), 1.0F);
  write_integer(folder / "wide.png", {{"Y", image.view()}}, {}, {});
  io_test::add_chunks(folder / "wide.png", {{"pHYs", io_test::big_endian(1000) + io_test::big_endian(2000) + '\1'}});
  Imf::Header header(4, 2);
  header.pixelAspectRatio() = 2.0F;
  io_test::write_scanline(folder / "wide.exr", header, {"Y"});
  header.insert("mtf:pixelPitch", Imf::V2dAttribute({5e-6, 5e-6}));
  io_test::write_scanline(folder / "pitch.exr", header, {"Y"});
  const std::string square = "sample = \"5 um\"\nquantity = \"radiance\"\ngain = 1.0\noffset = 0.0\n";
  const std::string wide =
      "sample_x = \"10 um\"\nsample_y = \"5 um\"\nquantity = \"radiance\"\ngain = 1.0\noffset = 0.0\n";
  for (const char* name : {"wide.png", "wide.exr"}) {
    const std::string message =
        message_of<UsageError>([&] { static_cast<void>(load_scene(sensor(square), folder / name, {})); });
    expect_says(message, {"2 times as wide", "5 x 5 um by [scene]", "sample_x and sample_y"});
    EXPECT_EQ(load_scene(sensor(wide), folder / name, {}).grid.step_x_um, 10.0);
  }
  expect_refused({"by its mtf:pixelPitch"},
                 [&] { static_cast<void>(load_scene(sensor(wide), folder / "pitch.exr", {})); });
}

TEST_F(SceneEncoding, GainAndOffsetThatTheFileStates) {
  Image image(4, 2);
  std::fill(image.data(), image.data() + image.size(), 1.0F);
  write_integer(folder / "a.png", {{"Y", image.view()}}, {0.01, 273.15}, {});
  expect_refused({"gain = 0.01", "offset = 273.15"},
                 [&] { static_cast<void>(load_scene(sensor("sample = \"5 um\"\n"), folder / "a.png", {})); });
  const Scene both = load("", "a.png");
  EXPECT_TRUE(says(both.warnings, "gain = 0.01") && says(both.warnings, "[scene] says gain = 0.5"));
  const std::string same = "sample = \"5 um\"\nquantity = \"radiance\"\ngain = 0.01\noffset = 273.15\n";
  EXPECT_TRUE(load_scene(sensor(same), folder / "a.png", {}).warnings.empty());
}

TEST_F(SceneEncoding, AGainBeyondFloatIsNamed) {
  const SensorConfig config = sensor(replaced(kUnits, "gain = 0.5", "gain = 1e36"));
  expect_refused<UsageError>({"gain = 1e+36", "[scene]", "1000 at column 1, row 0"},
                             [&] { load_scene(config, folder / "plain.png", {}); });
}

TEST_F(SceneEncoding, NotesOfTheFileAreWarnings) {
  io_test::add_chunks(folder / "plain.png", {{"tRNS", std::string("\x03\xe8", 2)}});
  const Scene scene = load("", "plain.png");
  EXPECT_TRUE(says(scene.warnings, "value 1000 (tRNS)"));
  EXPECT_TRUE(std::isnan(scene.planes[0].data()[1]));
}

TEST_F(SceneEncoding, WrongWordsAreErrorsOfTheirLine) {
  const auto first_error = [&](const std::string& value) {
    const ConfigResult result = parse_config(kHead + "encoding = " + value + "\n", folder / "s.toml");
    EXPECT_FALSE(result.ok()) << value;
    return result.diagnostics.empty() ? "" : format_diagnostic(result.diagnostics.front(), "s.toml");
  };
  for (const auto& [value, part] : {std::pair{"\"sRGB\"", "linear, srgb, gamma (2.2)"},
                                    {"\"gamma:0\"", "0.1 to 10"},
                                    {"2.2", "text in quotes"},
                                    {"\"missing.csv\"", "missing.csv"}}) {
    expect_says(first_error(value), {"s.toml:6:12: error: scene.encoding: ", part});
  }
}

}  // namespace
}  // namespace mtf::io
