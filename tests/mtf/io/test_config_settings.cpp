// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/io/config/config.h"
#include "tests/expect_error.h"

// Tables that another library brings: a made-up one with a row of every type, and a row added to [optics].

namespace mtf::io {
namespace {

constexpr std::array<std::string_view, 2> kWords{"slow", "fast"};
const std::string kHead =
    "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n[optics]\nf_number = 2.0\nwavelength = \"4 "
    "um\"\n";

std::vector<TableInfo> schema() {
  const FieldInfo mass{.name = "charge",
                       .dimension = Dimension::electrons,
                       .unit = "e-",
                       .lo = 0.0,
                       .hi = 1e6,
                       .example = "\"5 ke-\"",
                       .doc = "a charge"};
  const auto row = [](std::string_view name, double hi, FieldType type) {
    FieldInfo info = optional_row(name, 0.0, hi, "1", "a row");
    info.type = type;
    if (type == FieldType::word) info.words = kWords;
    return info;
  };
  return {{"optics", "more optics", {row("transmission", 1.0, FieldType::number_or_file)}},
          {"widget",
           "a widget",
           {mass, row("count", 9.0, FieldType::whole), row("on", 0.0, FieldType::flag),
            row("speed", 0.0, FieldType::word), row("plane", 0.0, FieldType::text), row("map", 0.0, FieldType::file),
            row("gain", 2.0, FieldType::number_or_file)}}};
}

const std::string kWidget =
    "transmission = 0.9\n[widget]\ncharge = \"5 ke-\"\ncount = 3\non = true\nspeed = \"fast\"\nplane = \"Z\"\n"
    "map = \"maps/a.exr\"\ngain = \"gain.csv\"\n";

std::string first_error(const std::string& text) {
  const ConfigResult result = parse_config(text, "folder/s.toml", schema());
  return result.ok() ? "" : format_diagnostic(result.diagnostics.front(), "s.toml");
}

void expect_error(const std::string& body, std::initializer_list<std::string_view> parts) {
  expect_says(first_error(kHead + body), parts);
}

TEST(ConfigSettings, EveryTypeIsRead) {
  const SensorConfig config = parse_config(kHead + kWidget, "folder/s.toml", schema()).config;
  ASSERT_EQ(config.tables.size(), 2u);
  EXPECT_EQ(std::get<double>(*find_table(config.tables, "optics")->find("transmission")), 0.9);
  const SettingsTable& widget = *find_table(config.tables, "widget");
  EXPECT_EQ(std::get<double>(*widget.find("charge")), 5000.0);
  EXPECT_EQ(std::get<int>(*widget.find("count")), 3);
  EXPECT_TRUE(std::get<bool>(*widget.find("on")));
  EXPECT_EQ(std::get<int>(*widget.find("speed")), 1);
  EXPECT_EQ(std::get<std::string>(*widget.find("plane")), "Z");
  EXPECT_EQ(std::get<std::string>(*widget.find("map")), "folder/maps/a.exr");
  EXPECT_EQ(std::get<std::string>(*widget.find("gain")), "folder/gain.csv");
  EXPECT_EQ(config.system.optics.f_number, 2.0);
  EXPECT_TRUE(parse_config(kHead, "s.toml", schema()).config.tables.empty());
}

TEST(ConfigSettings, WritingAndReadingAgainKeepsThem) {
  const SensorConfig config = parse_config(kHead + kWidget, "folder/s.toml", schema()).config;
  const std::string text = write_config(config);
  const ConfigResult again = parse_config(text, "folder/s.toml", schema());
  ASSERT_TRUE(again.ok()) << format_diagnostic(again.diagnostics.front(), "again");
  ASSERT_EQ(again.config.tables.size(), config.tables.size());
  EXPECT_EQ(write_config(again.config), text);
  const SettingsTable &before = config.tables[1], &after = again.config.tables[1];
  ASSERT_EQ(after.settings.size(), before.settings.size());
  for (std::size_t i = 0; i < before.settings.size(); ++i) EXPECT_EQ(after.settings[i].value, before.settings[i].value);
  expect_says(explain_config(config), {"widget.charge"});
}

TEST(ConfigSettings, ErrorsSayWhere) {
  expect_error("[widget]\n", {"s.toml:8:1: error: widget.charge: missing", "charge = \"5 ke-\""});
  expect_error("[widget]\ncharge = 5\n", {"s.toml:9:10: error: widget.charge: 5", "no unit", "such as \"5 ke-\""});
  expect_error("[widget]\ncharge = \"5 um\"\n", {"s.toml:9:10: error: widget.charge: \"5", "does not fit"});
  expect_error("[widget]\ncharge = \"5 Me-\"\n", {"s.toml:9:10: error: widget.charge: 5e+06 e- is outside [0, "});
  expect_error("[widget]\ncharge = { value = \"1 e-\", fit = true }\n", {"s.toml:9:"});
  expect_error("[widget]\ncharge = \"1 e-\"\nspeed = \"fats\"\n", {"s.toml:10:9: error: widget.speed: unknown word"});
  expect_error("[widget]\ncharge = \"1 e-\"\nspede = 1\n",
               {"s.toml:10:1: error: widget.spede: unknown key in [widget]"});
  expect_error("[widget]\ncharge = \"1 e-\"\non = 1\n", {"s.toml:10:6: error: widget.on:", "true or"});
  expect_error("[widget]\ncharge = \"1 e-\"\nmap = \"\"\n", {"s.toml:10:7: error: widget.map: no file name"});
  expect_error("transmission = 1.5\n", {"s.toml:8:16: error: optics.transmission: 1.5 is outside [0, 1]"});
  expect_error("widget = 3\n", {"s.toml:8:1: error: optics.widget: unknown key"});
  expect_error("[widgets]\n", {"s.toml:8:2: error: widgets: unknown", "\"widget\""});
}

TEST(ConfigSettings, WithoutASchemaTheTableIsUnknown) {
  const ConfigResult result = parse_config(kHead + "[widget]\n", "s.toml");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.diagnostics.front().path, "widget");
}

TEST(ConfigSettings, ATableMayDependOnAWordOfTheFile) {
  std::vector<TableInfo> tables = schema();
  const FieldInfo weight{.name = "weight", .hi = 9.0, .presence = Presence::optional, .example = "1", .doc = "a row"};
  tables.push_back({.name = "widget",
                    .settings = {tables[1].settings[3], weight},
                    .where = GivenWord{"widget", "speed", "slow"},
                    .absent = {{"charge", "a slow widget has none; write weight"}}});
  const auto error = [&](const std::string& body) {
    const ConfigResult result = parse_config(kHead + body, "s.toml", tables);
    return result.ok() ? "" : result.diagnostics.front().path + ": " + result.diagnostics.front().text;
  };
  EXPECT_EQ(error("[widget]\nspeed = \"slow\"\nweight = 2\n"), "");
  expect_says(error("[widget]\nspeed = \"slow\"\ncharge = \"5 e-\"\n"), {"widget.charge: ", "write weight"});
  EXPECT_EQ(error("[widget]\nspeed = \"fast\"\ncharge = \"5 e-\"\n"), "");
  EXPECT_EQ(error("[widget]\nspeed = \"fast\"\nweight = 2\ncharge = \"5 e-\"\n").substr(0, 26),
            "widget.weight: unknown key");
  const ConfigResult slow = parse_config(kHead + "[widget]\nspeed = \"slow\"\nweight = 2\n", "s.toml", tables);
  EXPECT_EQ(slow.config.schema.size(), 2U);  // optics and one widget: what explains and writes the file
}

}  // namespace
}  // namespace mtf::io
