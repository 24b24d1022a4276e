// SPDX-License-Identifier: Apache-2.0
// New values in the text of a sensor file that stays otherwise as it was.

#include <gtest/gtest.h>

#include "mtf/io/config/config.h"

namespace {

using mtf::io::parse_config;
using mtf::io::SensorConfig;

const std::string kHead =
    "# \xC2\xB5-lens\nschema = 1\n[frame]\nfocal_length = \"100 mm\" # nominal\npitch = \"5 um\"\n"
    "[optics]\nwavelength = \"0.5 um\"\n[[presample]]\nkind = \"gaussian\"\n";

SensorConfig read(const std::string& line) {
  const auto result = parse_config(kHead + line, "s.toml");
  for (const auto& found : result.diagnostics) EXPECT_FALSE(found.error) << found.text;
  return result.config;
}

/// The line with the value 0.25 px, and the standard error given.
std::string spliced(const std::string& line, std::optional<double> sd) {
  SensorConfig config = read(line);
  EXPECT_EQ(config.fits.size(), 1U);
  config.fits[0].stderr_value = sd;
  const std::optional<double> value = 0.25;
  const std::string text = splice_fits(config, {&value, 1});
  EXPECT_EQ(text.substr(0, kHead.size()), kHead);
  const auto again = parse_config(text, "s.toml");
  EXPECT_TRUE(again.ok());
  EXPECT_EQ(again.config.fits.at(0).stderr_value, sd);
  return text.substr(kHead.size());
}

}  // namespace

TEST(ConfigSplice, OnlyTheNumbersChange) {
  EXPECT_EQ(spliced("sigma = { value = \"0.5 px\", fit = true } # \xC2\xB5\n", 0.01),
            "sigma = { value = \"0.25 px\", stderr = \"0.01 px\", fit = true } # \xC2\xB5\n");
  EXPECT_EQ(spliced("sigma = {fit = true, stderr= '1 px', value='0.5 px'}\n", 0.01),
            "sigma = {fit = true, stderr= \"0.01 px\", value=\"0.25 px\"}\n");
}

TEST(ConfigSplice, AnErrorThatIsNoMoreGoes) {
  EXPECT_EQ(spliced("sigma = { value = \"0.5 px\", stderr = \"1 px\", fit = true }\n", std::nullopt),
            "sigma = { value = \"0.25 px\", fit = true }\n");
}

TEST(ConfigSplice, TextWithoutFitsStays) {
  const SensorConfig config = read("sigma = \"0.5 px\"\n");
  EXPECT_EQ(splice_fits(config, {}), config.text);
}
