// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "mtf/io/config/config.h"
#include "mtf/io/sha256.h"
#include "tests/expect_error.h"

namespace mtf::io {
namespace {

TEST(ConfigStarter, PassesWithoutNotes) {
  const ConfigResult result = parse_config(starter_config(), "starter.toml");
  for (const auto& d : result.diagnostics) ADD_FAILURE() << format_diagnostic(d, "starter.toml");
  EXPECT_EQ(result.config.sha256, sha256_hex(starter_config()));
  EXPECT_EQ(result.config.scene.quantity, Quantity::radiance);
  EXPECT_EQ(result.config.scene.sample_x_um, 3.75);
}

// By hand: diffraction at nu = 33.33/125 -> 0.6645, footprint sinc(1/2) = 0.6366, jitter exp(-2 (pi 2/30)^2) = 0.9160.
TEST(ConfigStarter, IsTheSensorOfTheReadme) {
  const System<double> system = parse_config(starter_config(), "starter.toml").config.system;
  const Freq<double> nyquist{system.frame.nyquist_cy_mm(Axis::x), 0.0};
  EXPECT_NEAR(nyquist.x, 33.3333, 1e-4);
  const auto& list = system.list(Stage::presample);
  ASSERT_EQ(list.size(), 3u);
  EXPECT_NEAR(system.otf(list[0], nyquist).re, 0.6645, 5e-5);
  EXPECT_NEAR(system.otf(list[1], nyquist).re, 0.6366, 5e-5);
  EXPECT_NEAR(system.otf(list[2], nyquist).re, 0.9160, 5e-5);
  EXPECT_NEAR(system.otf(nyquist).re, 0.3875, 5e-5);
}

// Every line that is commented out as an example is accepted when its `#` is removed (each on its own).
TEST(ConfigStarter, CommentedExamplesWork) {
  std::string text = starter_config();
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  replace("# gain =", "gain =");
  replace("# offset =", "offset =");
  replace("# obscuration =", "obscuration =");
  replace("wavelength = \"4.0 um\"", "#");
  replace("# [band]\n# ", "[band]\n");
  replace("rms = \"2 um\"", "#");
  replace("# rms =", "rms =");
  replace("# [[postsample]]\n# kind = \"fir\"\n# taps", "[[postsample]]\nkind = \"fir\"\ntaps");
  const ConfigResult result = parse_config(text, "starter.toml");
  for (const auto& d : result.diagnostics) ADD_FAILURE() << format_diagnostic(d, "starter.toml");
  EXPECT_EQ(result.config.fits.size(), 1u);
  EXPECT_TRUE(result.config.system.band.has_value());
  EXPECT_EQ(result.config.system.list(Stage::postsample).size(), 1u);
}

TEST(ConfigStarter, Explain) {
  const ConfigResult result = parse_config(starter_config(), "starter.toml");
  const std::string text = explain_config(result.config);
  expect_says(text, {"optical cutoff          125 cy/mm", "Nyquist frequency       33.33333333 cy/mm",
                     "Q = lambda N / pitch    0.5333333333", "IFOV of a pixel         150 urad",
                     "scene samples per pitch 4", "\"10 ms\"", "0.01 s", "[optics] line 25", "starter.toml:10"});
  SensorConfig made;
  made.system = result.config.system;
  expect_says(explain_config(made), {"set by program"});
}

/// What any text has to lead to: an answer, with errors inside the text.
void expect_answer(const std::string& text) {
  const ConfigResult result = parse_config(text, "fuzz.toml");
  int lines = 1;
  for (const char c : text) lines += c == '\n';
  for (const auto& d : result.diagnostics) {
    ASSERT_LE(d.position.line, lines) << format_diagnostic(d, "fuzz.toml") << "\n" << text;
    ASSERT_FALSE(d.text.empty());
  }
  if (!result.ok()) return;
  ASSERT_TRUE(parse_config(write_config(result.config), "fuzz.toml").ok()) << text;
  ASSERT_FALSE(explain_config(result.config).empty());
}

TEST(ConfigStarter, EveryPrefixIsAnswered) {
  const std::string text = starter_config();
  for (std::size_t n = 0; n <= text.size() && !testing::Test::HasFailure(); ++n) expect_answer(text.substr(0, n));
}

TEST(ConfigStarter, MutationsAreAnswered) {
  const std::string whole = starter_config();
  const std::vector<std::string> words{
      "[",       "]",         "[[",           "{",       "}",      "\"",      "=",   ".",   "\n",   "-",  "0",
      "1e308",   "1e400",     "nan",          "true",    "\xC2",   "\\u0000", "fit", "min", "kind", "px", "cy/px",
      "\"fir\"", "\"curve\"", "file = \".\"", "pitch_x", "[band]", "'''",     "\0"};
  std::mt19937_64 random(7);
  int accepted = 0;
  for (int round = 0; round < 2000 && !testing::Test::HasFailure(); ++round) {
    std::string text = whole;
    for (std::uint64_t edits = 1 + random() % 4; edits > 0; --edits) {
      const std::size_t at = random() % text.size(), length = random() % 12;
      switch (random() % 4) {
        case 0:
          text.erase(at, length);
          break;
        case 1:
          text.insert(at, words[random() % words.size()]);
          break;
        case 2:
          text[at] = static_cast<char>(random() % 256);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), 40));
          break;
      }
    }
    expect_answer(text);
    accepted += parse_config(text, "fuzz.toml").ok();
  }
  EXPECT_GT(accepted, 20);  // otherwise nothing beyond the TOML parser was reached
  EXPECT_LT(accepted, 1900);
}

}  // namespace
}  // namespace mtf::io
