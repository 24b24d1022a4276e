// SPDX-License-Identifier: Apache-2.0

// Edits of the live view: text stays what it was but for what is asked, and no edit names a file.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/live/access.h"
#include "apps/live/edits.h"
#include "apps/live/model.h"
#include "apps/sensor/sensor_air.h"
#include "mtf/error.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps::live {
namespace {

const std::string kText = R"(schema = 1
name = "camera"
[frame]
focal_length = "100 mm"
pitch = "15 um"          # of the data sheet
integration_time = "10 ms"
[optics]
f_number = 2.0
[band]
wavelength = ["3.4 um", "4.8 um"]

# the lens
[[presample]]
kind = "diffraction"

# the mount
[[presample]]
kind = "jitter"          # measured in May
rms = "20 urad"
[detector]
quantum_efficiency = 0.7
full_well = "1 Me-"
[noise]
seed = 1
)";

nlohmann::json as_the_page_reads(const Json& json) { return nlohmann::json::parse(json_document(json)); }

std::shared_ptr<const mtf::io::SensorConfig> camera() {
  auto result = mtf::io::parse_config(kText, "camera.toml", sensor_schema());
  EXPECT_TRUE(result.ok());
  return std::make_shared<const mtf::io::SensorConfig>(std::move(result.config));
}

std::string text_after(const std::vector<Edit>& edits) { return EditedSensor(camera()).with(edits)->text; }

std::string refusal_of(const Edit& edit) {
  return message_of<mtf::UsageError>([&] { EditedSensor(camera()).with(std::vector{edit}); });
}

TEST(LiveEdits, AKeyIsNoLongerGiven) {
  const std::string text = text_after(
      {{Edit::Kind::set, "diffraction.obscuration", "0.3"}, {Edit::Kind::unset, "diffraction.obscuration", ""}});
  EXPECT_EQ(text, kText);
  EXPECT_FALSE(says(text_after({{Edit::Kind::unset, "detector.full_well", ""}}), "full_well"));
  EXPECT_NE(refusal_of({Edit::Kind::unset, "optics.f_number", ""}), "") << "something has to be given";
  EXPECT_NE(refusal_of({Edit::Kind::unset, "diffraction.obscuration", ""}), "") << "the file does not state it";
}

TEST(LiveEdits, OfKeysThatExcludeEachOtherTheNewOneCounts) {
  const std::string text = text_after({{Edit::Kind::set, "optics.aperture", "40 mm"}});
  expect_says(text, {"aperture = \"40 mm\""});
  EXPECT_FALSE(says(text, "f_number")) << text;
  const std::string motion = text_after(
      {{Edit::Kind::add, "presample", "linear_motion"}, {Edit::Kind::set, "linear_motion.rate", "20 mrad/s"}});
  expect_says(motion, {"rate = \"20 mrad/s\""});
  EXPECT_FALSE(says(motion, "travel")) << motion;
  auto sampled = mtf::io::parse_config(kText + "[scene]\nsample = \"15 um\"\n", "camera.toml", sensor_schema());
  const auto scene = EditedSensor(std::make_shared<const mtf::io::SensorConfig>(std::move(sampled.config)))
                         .with(std::vector<Edit>{{Edit::Kind::set, "scene.ifov", "100 urad"}});
  expect_says(scene->text, {"[scene]\nifov = \"100 urad\"\n"});
  // A value that is wrong by itself takes nothing away.
  expect_says(refusal_of({Edit::Kind::set, "optics.aperture", "-40 mm"}), {"aperture"});
}

TEST(LiveEdits, TheOneThatCannotBeMadeIsNamed) {
  try {
    text_after({{Edit::Kind::set, "jitter.rms", "10 urad"},
                {Edit::Kind::set, "optics.f_number", "0"},
                {Edit::Kind::set, "jitter.rms", "9 urad"}});
    FAIL();
  } catch (const RefusedEdit& error) {
    EXPECT_EQ(error.index(), 1u);
    EXPECT_EQ(error.list(), "edits");
  }
}

TEST(LiveEdits, AValueChangesItsPlaceAndNothingElse) {
  std::string wanted = kText;
  wanted = replaced(wanted, "20 urad", "35 urad");
  EXPECT_EQ(text_after({{Edit::Kind::set, "jitter.rms", "35 urad"}}), wanted);
}

TEST(LiveEdits, KeysThatNoScheduleReachesAreSetInTheirTable) {
  std::string wanted = kText;
  wanted.insert(wanted.find("[band]"), "transmission = 0.5\n");
  EXPECT_EQ(text_after({{Edit::Kind::set, "optics.transmission", "0.5"}}), wanted);
  const std::string text =
      text_after({{Edit::Kind::set, "scene.border", "periodic"}, {Edit::Kind::set, "scene.border", "replicate"}});
  EXPECT_EQ(text, kText + "\n[scene]\nborder = \"replicate\"\n");
}

TEST(LiveEdits, PairsAreChangedNumberByNumber) {
  std::string wanted = kText;
  wanted = replaced(wanted, "4.8 um", "4.2 um");
  EXPECT_EQ(text_after({{Edit::Kind::set, "band.wavelength[1]", "4.2 um"}}), wanted);
  const std::string text =
      text_after({{Edit::Kind::set, "frame.format", "[640, 512]"}, {Edit::Kind::set, "frame.format[0]", "320"}});
  expect_says(text, {"format = [320, 512]\n"});
  expect_says(refusal_of({Edit::Kind::set, "frame.format[0]", "320"}), {"0 elements"});
  EXPECT_FALSE(refusal_of({Edit::Kind::set, "frame.format", "\"/etc/passwd\""}).empty());
  EXPECT_FALSE(refusal_of({Edit::Kind::set, "scene.gain[0]", "1.0"}).empty());
}

TEST(LiveModel, PairsHaveARowForEachNumber) {
  const auto sensor = EditedSensor(camera()).with(std::vector<Edit>{{Edit::Kind::set, "frame.format", "[640, 512]"}});
  const auto model = as_the_page_reads(model_json(*sensor, sensor_kinds()));
  std::vector<std::string> names;
  for (const auto& table : model["tables"])
    for (const auto& row : table["rows"])
      if (row["control"] == "number") names.push_back(row["name"]);
  for (const char* name : {"band.wavelength[0]", "band.wavelength[1]", "frame.format[0]", "frame.format[1]"})
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
}

TEST(LiveEdits, OffIsACommentAndOnBringsItBack) {
  const std::string off = text_after({{Edit::Kind::off, "jitter"}});
  expect_says(off, {"# the mount\n#- [[presample]]\n#- kind = \"jitter\"          # measured in May\n#- rms"});
  EXPECT_EQ(text_after({{Edit::Kind::off, "jitter"}, {Edit::Kind::on, "0"}}), kText);
  EXPECT_EQ(
      text_after(
          {{Edit::Kind::off, "[noise]"}, {Edit::Kind::off, "jitter"}, {Edit::Kind::on, "1"}, {Edit::Kind::on, "0"}}),
      kText);
  const auto sensor = EditedSensor(camera()).with(std::vector<Edit>{{Edit::Kind::off, "jitter"}});
  EXPECT_EQ(sensor->system.list(mtf::Stage::presample).size(), 1u);
}

TEST(LiveEdits, RemovedTablesTakeTheirLinesAlong) {
  const std::string text = text_after({{Edit::Kind::remove, "diffraction"}});
  EXPECT_FALSE(says(text, "diffraction")) << text;
  expect_says(text, {"# the mount\n[[presample]]\nkind = \"jitter\""});
  EXPECT_FALSE(says(text_after({{Edit::Kind::remove, "[noise]"}}), "seed"));
}

TEST(LiveEdits, EveryKindAndTableWithoutAFileCanBeAdded) {
  const SensorKinds kinds = sensor_kinds();
  const auto model = as_the_page_reads(model_json(*camera(), kinds));
  int added = 0;
  for (const char* list : {"presample", "readout", "postsample", "table"})
    for (const auto& entry : model["addable"][list]) {
      const std::string name = entry[0];
      try {
        const auto sensor = EditedSensor(camera()).with(std::vector<Edit>{{Edit::Kind::add, list, name}});
        EXPECT_TRUE(sensor->text.starts_with(kText)) << name;
        ++added;
      } catch (const mtf::UsageError& error) {
        // A second pupil, or what does not go with a photon detector: the reader's own words.
        EXPECT_FALSE(std::string(error.what()).empty());
      }
    }
  EXPECT_GT(added, 40);
}

TEST(LiveEdits, ASecondPupilIsRefusedInTheReadersWords) {
  const std::string words = refusal_of({Edit::Kind::add, "presample", "defocus"});
  expect_says(words, {"pupil"});
  expect_says(refusal_of({Edit::Kind::set, "optics.f_number", "0.001"}), {"outside [0.1"});
}

TEST(LiveEdits, NoEditNamesAFile) {
  for (const char* name : {"detector.quantum_efficiency", "optics.transmission", "scene.emissivity"})
    EXPECT_TRUE(says(refusal_of({Edit::Kind::set, name, "/etc/passwd"}), "in the sensor file"))
        << name << refusal_of({Edit::Kind::set, name, "/etc/passwd"});
  EXPECT_FALSE(refusal_of({Edit::Kind::add, "presample", "curve"}).empty());
}

TEST(LiveEdits, ListsAreReadStrictly) {
  EXPECT_EQ(read_edits(parse_json(R"([["set", "jitter.rms", "2 um"], ["off", "jitter"]])")).size(), 2u);
  for (const char* wrong : {"{}", "[[]]", "[[\"set\"]]", "[[\"set\", 1, 2]]", "[[\"what\", \"a\", \"b\"]]",
                            "[[\"set\", \"a\", \"b\\n\"]]", "[", "[[\"set\",\"a\",\"b\",\"c\"]]"})
    EXPECT_THROW(read_edits(parsed_json(wrong).value_or(Json())), mtf::UsageError) << wrong;
}

TEST(LiveBlocks, HeadersInStringsAreNone) {
  const auto blocks = toml_blocks("a = \"\"\"\n[no]\n\"\"\"\n[yes]\nb = 1\n# end\n\n# of the next\n[[list]]\n");
  ASSERT_EQ(blocks.size(), 2u);
  EXPECT_EQ(blocks[0].header, "yes");
  EXPECT_TRUE(blocks[1].list);
}

TEST(LiveBlocks, LinesOfACurveStayTogether) {
  const std::string curve =
      "[[presample]]\nkind = \"curve\"\nfile = \"\"\"\nfrequency_cy_mm,mtf\n\n0,1\n# bench\"\"\"\n";
  const std::string text = "a = 1\n" + curve + "[noise]\nseed = 1\n";
  const auto blocks = toml_blocks(text);
  ASSERT_EQ(blocks.size(), 2u);
  EXPECT_EQ(blocks[1].header, "noise");
  const std::string off = switched_off(text, blocks[0]);
  const auto after = toml_blocks(off);
  ASSERT_EQ(after.size(), 2u) << off;
  EXPECT_TRUE(after[0].off);
  EXPECT_EQ(switched_on(off, after[0]), text);
}

TEST(LiveModel, SlidersHoldTheirValueAndKeepToTheRange) {
  const SensorKinds kinds = sensor_kinds();
  const auto check = [](const nlohmann::json& row) {
    if (row["control"] != "number") return;
    const double low = row["low"], high = row["high"], value = row["number"];
    EXPECT_LT(low, high) << row;
    EXPECT_TRUE(low <= value && value <= high) << row;
    if (!row["min"].is_null()) {
      EXPECT_GE(low, row["min"].get<double>()) << row;
    }
    if (!row["max"].is_null()) {
      EXPECT_LE(high, row["max"].get<double>()) << row;
    }
    if (row["log"]) {
      EXPECT_GT(low, 0.0) << row;
    }
  };
  const auto model = as_the_page_reads(model_json(*camera(), kinds));
  for (const char* owners : {"components", "tables"})
    for (const auto& owner : model[owners])
      for (const auto& row : owner["rows"]) check(row);
}

TEST(LiveAccess, NamesOfThisMachine) {
  for (const char* good : {"127.0.0.1", "127.0.0.1:80", "localhost:8080", "[::1]:9", "localhost"})
    EXPECT_TRUE(is_this_machine(good)) << good;
  for (const char* bad : {"", "127.0.0.1.evil.test", "localhost.evil.test", "127.0.0.1:", "127.0.0.1:x", "evil.test",
                          "127.0.0.1:123456", "127.0.0.11"})
    EXPECT_FALSE(is_this_machine(bad)) << bad;
}

TEST(LiveAccess, TokensAre128BitsAndNeverTheSame) {
  const std::string a = new_token(), b = new_token();
  EXPECT_EQ(a.size(), 32u);
  EXPECT_EQ(a.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(a, b);
}

}  // namespace
}  // namespace apps::live
