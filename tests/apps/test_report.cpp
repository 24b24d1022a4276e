// SPDX-License-Identifier: Apache-2.0

// `mtf report`: what stands in the page, which designs, and what it makes of folders that are not as a sweep leaves
// them. What a browser makes of the page is tests/report/check_report.mjs.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

/// Folder `sweep` as `mtf sweep` leaves it.
void make_sweep(const Scratch& scratch, const std::string& options = "") {
  const Result made = scratch.run(std::string(MTFKIT_PYTHON) +
                                  " '" MTFKIT_SOURCE_DIR "/tests/report/make_sweep.py' sweep --points 100 " + options);
  ASSERT_EQ(made.status, 0) << made.err;
}

std::string page_of(const Scratch& scratch, const std::string& options = "") {
  const Result result = scratch.run("mtf report sweep " + options);
  EXPECT_EQ(result.status, 0) << result.err;
  return read_file(scratch / "sweep/report.html");
}

Json data_of(const std::string& page) {
  const std::string mark = "id=\"data\">";
  const std::size_t begin = page.find(mark) + mark.size();
  return Json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

void change_json(const Scratch& scratch, const std::function<void(Json&)>& change) {
  Json json = Json::parse(read_file(scratch / "sweep/sweep.json"));
  change(json);
  write_file(scratch / "sweep/sweep.json", json.dump());
}

/// Rows without quoted cells.
std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string>& row = rows.emplace_back();
    for (std::size_t at = 0;;) {
      const std::size_t end = line.find(',', at);
      row.push_back(line.substr(at, end - at));
      if (end == std::string::npos) break;
      at = end + 1;
    }
  }
  return rows;
}

TEST(Report, HoldsEveryCellOfTheTableToTheLastBit) {
  const Scratch scratch;
  make_sweep(scratch);
  const Json data = data_of(page_of(scratch));
  const auto rows = rows_of(read_file(scratch / "sweep/designs.csv"));
  ASSERT_EQ(data["design"].size(), rows.size() - 1);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(data["design"][i - 1], i - 1);
    for (std::size_t c = 1; c < rows[i].size(); ++c) {
      const Json& cell = data["cells"][c - 1][i - 1];
      if (rows[i][c].empty())
        EXPECT_TRUE(cell.is_null());
      else
        EXPECT_EQ(cell.get<double>(), std::strtod(rows[i][c].c_str(), nullptr)) << rows[0][c];
    }
  }
}

TEST(Report, HasItsSectionsAndStaticCharts) {
  const Scratch scratch;
  make_sweep(scratch);
  const std::string page = page_of(scratch);
  for (const char* id : {"summary", "trade", "maps", "chosen", "sensitivities", "run", "definitions", "files"})
    EXPECT_EQ(count(page, "<section id=\"" + std::string(id) + "\">"), 1U) << id;
  EXPECT_GE(count(page, "<svg class=\"static\""), 6U);
  const std::size_t chosen = data_of(page)["chosen"].size();
  EXPECT_EQ(count(page, "src=\"data:image/png;base64,"), chosen);
  expect_says(page, {"niirs_giqe5</strong> is not here:", "mtf_nyquist &gt; 0.15", "with the design before",
                     "Lloyd, Thermal Imaging Systems, ch. 5"});
  // Nothing comes from elsewhere, and scripts are those of the page.
  expect_says(page, {"default-src 'none'; img-src data:;"});
  EXPECT_FALSE(says(page, "script-src 'unsafe")) << page;
  EXPECT_EQ(page.find("{{"), page.find("{{", page.find("id=\"data\""))) << "a name of the template is left";
}

TEST(Report, SaysAtOnceWhyDesignsAreInvalidAndMetricsHaveNoShares) {
  const Scratch scratch;
  make_sweep(scratch);
  EXPECT_FALSE(says(page_of(scratch), "No shares of"));
  change_json(scratch, [](Json& json) {
    json["invalid"] = {{"designs", 30},
                       {"no_sensor", 4},
                       {"not_finite", {{{"text", "minimize netd"}, {"designs", 26}}}},
                       {"cause", {{"text", "saturated at <b>"}, {"designs", 17}, {"looked_at", 20}}}};
    for (Json& one : json["sensitivities"]["indices"])
      if (one["column"] != "netd") {
        one["total"] = nullptr;
        one["used"] = one["column"] == "mtf50" ? 100 : 4096;
      }
  });
  const std::string page = page_of(scratch);
  expect_says(page,
              {"30 are invalid; the commonest cause, of 17 of the 20 that were looked at: saturated at &lt;b&gt;. By",
               "impossible as a sensor in 4; minimize netd not finite in 26",
               "<strong>mtf50</strong>, which fewer than half of the samples have.",
               "<strong>mtf_nyquist</strong>, which vary in no sample."});
  change_json(scratch, [](Json& json) {
    for (Json& one : json["sensitivities"]["indices"]) one["total"] = nullptr, one["used"] = 0;
  });
  expect_says(page_of(scratch), {"<strong>mtf_nyquist, netd, mtf50</strong>, which fewer"});
}

TEST(Report, TheCurvesAreThoseOfTheChosenFiles) {
  const Scratch scratch;
  make_sweep(scratch);
  const Json data = data_of(page_of(scratch));
  const Json& one = data["chosen"][0];
  const std::string file = "sweep/chosen/design_" + std::to_string(one["design"].get<int>()) + ".toml";
  const std::size_t at = one["frequency"].size() / 2;
  std::ostringstream frequency;
  frequency.precision(17);
  frequency << one["frequency"][at].get<double>();
  const Json curve =
      Json::parse(scratch.run("mtf curve " + file + " --freq " + frequency.str() + " --format json").out);
  // Curves are embedded with six digits.
  EXPECT_NEAR(one["system"][at].get<double>(), curve["system"]["re"][0].get<double>(), 2e-6);
  ASSERT_EQ(one["components"].size(), curve["components"].size());
  const Json budget = Json::parse(scratch.run("mtf budget " + file + " --format json").out);
  for (const Json& row : one["budget"]) EXPECT_EQ(row[1], budget["terms"][row[0].get<std::string>()]["value"]) << row;
}

TEST(Report, TextOfFilesStaysText) {
  const Scratch scratch;
  make_sweep(scratch);
  const std::string evil = "</script><script>bad()</script><img src=x onerror=bad()>&\"'\x01\xff{{data}}";
  const std::string shown = "</script><script>bad()</script><img src=x onerror=bad()>&\"'{{data}}";  // JSON wants UTF-8
  change_json(scratch, [&](Json& json) {
    json["study"]["name"] = json["machine"] = json["commit"] = shown;
    json["columns"][0]["definition"] = json["columns"][3]["source"] = json["constraints"][0]["text"] = shown;
    json["skipped"] = {shown};
    json["chosen"][0]["why"] = shown;
    json["best"][0]["limits"] = {{{"text", shown}, {"state", shown}}};
    json["date"] = json["conditions"]["lines"][0] = shown;
  });
  write_file(scratch / "sweep/study.toml", evil);
  const std::string page = page_of(scratch);
  EXPECT_FALSE(says(page, "<img src=x")) << page;
  EXPECT_FALSE(says(page, "<script>bad")) << page;
  EXPECT_EQ(count(page, "</script"), 3U);
  EXPECT_FALSE(says(page, "\x01")) << page;
  EXPECT_EQ(data_of(page)["chosen"][0]["why"], shown);
  expect_says(
      page,
      {"&lt;/script&gt;&lt;script&gt;bad()&lt;/script&gt;&lt;img src=x onerror=bad()&gt;&amp;&quot;&#39;??{{data}}"});
}

TEST(Report, OfManyDesignsHoldsAStatedPart) {
  const Scratch scratch;
  make_sweep(scratch, "--points 25000");
  const std::string page = page_of(scratch);
  EXPECT_LT(page.size(), 2'000'000U);
  const Json data = data_of(page);
  const Json sweep = Json::parse(read_file(scratch / "sweep/sweep.json"));
  const auto designs = data["design"].get<std::vector<std::int64_t>>();
  const std::set<std::int64_t> here(designs.begin(), designs.end());
  ASSERT_EQ(here.size(), designs.size());
  for (const Json& design : sweep["pareto"]) EXPECT_TRUE(here.contains(design.get<std::int64_t>()));
  for (const char* list : {"best", "chosen"})
    for (const Json& one : sweep[list]) EXPECT_TRUE(here.contains(one["design"].get<std::int64_t>()));
  const auto every = data["every"].get<std::int64_t>();
  ASSERT_GT(every, 1);
  expect_says(page, {"<span id=\"embedded\">" + std::to_string(designs.size()) + "</span> of " +
                         std::to_string(sweep["designs"].get<int>()) + " designs are in",
                     "one in " + std::to_string(every) + ","});
  // A fair draw: each tenth of the designs and each level of the last axis (here 158) has its share, within five
  // standard deviations of a binomial count.
  const double expected = 0.1 * sweep["designs"].get<double>() / static_cast<double>(every);
  const std::size_t front = sweep["pareto"].size() + 16;
  std::map<std::int64_t, double> tenth, level;
  for (const std::int64_t design : designs) {
    tenth[10 * design / sweep["designs"].get<std::int64_t>()] += 1.0;
    level[design % 158 * 10 / 158] += 1.0;
  }
  for (std::int64_t i = 0; i < 10; ++i)
    for (const double n : {tenth[i], level[i]}) {
      EXPECT_GT(n, expected - 5.0 * std::sqrt(expected)) << i;
      EXPECT_LT(n, expected + 5.0 * std::sqrt(expected) + static_cast<double>(front)) << i;
    }
  // The same again, byte for byte.
  EXPECT_EQ(page_of(scratch), page);
  // Their cells are those of the file.
  const auto rows = rows_of(read_file(scratch / "sweep/designs.csv"));
  for (std::size_t i = 0; i < designs.size(); i += 37)
    EXPECT_EQ(data["cells"][3][i].get<double>(),
              std::strtod(rows[static_cast<std::size_t>(designs[i]) + 1][4].c_str(), nullptr));
}

struct Damage {
  const char *name, *shell, *message;
};

class ReportOf : public testing::TestWithParam<Damage> {};

TEST_P(ReportOf, IsOneClearErrorAndLeavesTheOldReport) {
  const Scratch scratch;
  make_sweep(scratch);
  write_file(scratch / "sweep/report.html", "old");
  const Result damaged = scratch.run(std::string("cd sweep\n") + GetParam().shell);
  ASSERT_EQ(damaged.status, 0) << damaged.err;
  const Result result = scratch.run("mtf report sweep");
  EXPECT_EQ(result.status, 2) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(lines(result.err), 1U) << result.err;
  expect_says(result.err, {GetParam().message});
  EXPECT_EQ(read_file(scratch / "sweep/report.html"), "old");
}

INSTANTIATE_TEST_SUITE_P(
    Damaged, ReportOf,
    testing::Values(
        Damage{"NoSweep", "rm sweep.json designs.csv", "has no sweep.json"},
        Damage{"Unfinished", "rm sweep.json && mkdir parts", "not finished"},
        Damage{"NotEvaluated", "sed -i 's/\"evaluated\": 100/\"evaluated\": 7/' sweep.json", "7 of 100 designs"},
        Damage{"ForeignSchema", "sed -i 's/\"schema\": 1/\"schema\": 9/' sweep.json", "schema 9"},
        Damage{"ForeignKind", "sed -i 's/\"kind\": \"sweep\"/\"kind\": \"fit\"/' sweep.json",
               "what `mtf sweep` writes"},
        Damage{"HalfJson", "head -c 900 sweep.json >a && mv a sweep.json", "is no JSON"},
        Damage{"DeepJson", "printf '%0100000d' 0 | tr 0 '[' >sweep.json", "nested too deeply"},
        Damage{"WrongType", "sed -i 's/\"feasible\": [0-9]*/\"feasible\": \"many\"/' sweep.json",
               "sweep.json.feasible: is not"},
        Damage{"DesignOutside", "sed -i 's/\"best\": \\[/\"best\": [{\"design\": 100},/' sweep.json", "there are 100"},
        Damage{"MissingKey", "sed -i 's/\"columns\"/\"colums\"/' sweep.json", "1 to 1000 columns"},
        Damage{"HalfTable", "head -c 4000 designs.csv >a && mv a designs.csv", "the file is incomplete"},
        Damage{"FewerRows", "sed -i '$d' designs.csv", "99 designs where sweep.json has 100"},
        Damage{"MoreRows", "tail -n 1 designs.csv >>designs.csv", "than the 100"},
        Damage{"OtherColumn", "sed -i '1s/mtf50/mtf51/' designs.csv", "column 'mtf51' where sweep.json has 'mtf50'"},
        Damage{"FewerCells", "sed -i '5s/,[^,]*$//' designs.csv", "designs.csv:5: "},
        Damage{"OutOfOrder", "sed -i '7s/^5,/6,/' designs.csv", "design '6' where 5 follows"},
        Damage{"OtherGaps", "sed -i '9s/,[^,]*$/,/' designs.csv", "column 'pareto' has 1"},
        Damage{"OpenQuote", "printf '\"' >>designs.csv", "never closed"},
        Damage{"HugeRow", "head -c 3000000 /dev/zero | tr '\\0' 7 >>designs.csv", "a row of more"}),
    [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(Report, NamesAFolderThatIsNone) {
  const Scratch scratch;
  for (const char* name : {"nowhere", "file"}) {
    write_file(scratch / "file", "text");
    expect_error(scratch.run(std::string("mtf report ") + name), 2, {"is no folder", "mtf sweep"});
  }
}

TEST(Report, ShowsADesignWithoutItsFileAsAGap) {
  const Scratch scratch;
  make_sweep(scratch);
  write_file(scratch / "secret.toml", "name = \"hidden words\"\n");
  const Json sweep = Json::parse(read_file(scratch / "sweep/sweep.json"));
  ASSERT_GE(sweep["chosen"].size(), 3U);
  std::filesystem::remove(scratch / "sweep" / sweep["chosen"][0]["file"].get<std::string>());
  write_file(scratch / ("sweep/" + sweep["chosen"][2]["file"].get<std::string>()), "schema = 1\nnonsense = 2\n");
  change_json(scratch, [](Json& json) {
    json["chosen"][1]["file"] = "../secret.toml";
    json["sensors"][0]["file"] = "/etc/hostname";
  });
  const std::string page = page_of(scratch);
  EXPECT_EQ(count(page, "</strong> has no curves"), 3U);
  expect_says(page, {"../secret.toml: is not", "/etc/hostname: is not"});
  EXPECT_FALSE(says(page, "hidden words")) << page;
  EXPECT_EQ(count(page, "src=\"data:image/png"), sweep["chosen"].size() - 3);
}

TEST(Report, NamesWhatASensorWithoutDetectorDoesNotHave) {
  const Scratch scratch;
  make_sweep(scratch);
  scratch.add_sensor();
  const Json sweep = Json::parse(read_file(scratch / "sweep/sweep.json"));
  std::filesystem::copy_file(scratch / "sensor.toml",
                             scratch / ("sweep/" + sweep["chosen"][0]["file"].get<std::string>()),
                             std::filesystem::copy_options::overwrite_existing);
  const std::string page = page_of(scratch);
  EXPECT_EQ(count(page, "no [detector]"), 1U);
  EXPECT_EQ(count(page, "src=\"data:image/png"), sweep["chosen"].size());
}

TEST(Report, OfNoFeasibleDesignNamesTheNearest) {
  const Scratch scratch;
  make_sweep(scratch, "--kind infeasible");
  const std::string page = page_of(scratch);
  expect_says(page, {"nearest is design 0", "misses mtf_nyquist &gt; 0.9"});
}

TEST(Report, ReadsQuotedLevels) {
  const Scratch scratch;
  make_sweep(scratch, "--kind levels");
  const Json data = data_of(page_of(scratch));
  EXPECT_EQ(data["cells"][1][0], "[\"3.4 um\", \"4.8 um\"]");
  EXPECT_EQ(data["cells"][1][1], "[\"7.8 um\", \"10 um\"]");
}

TEST(Report, StaysSmallWhateverTheFiles) {
  const Scratch scratch;
  make_sweep(scratch, "--points 5000");
  write_file(scratch / "sweep/study.toml", std::string(5 << 20, '<'));
  write_file(scratch / "sweep/camera.toml", std::string(200 << 10, '<'));
  const std::string page = page_of(scratch);
  EXPECT_LT(page.size(), 2'000'000U);
  expect_says(page, {"12000 of 204800 bytes"});
}

TEST(Report, WritesWhereItIsTold) {
  const Scratch scratch;
  make_sweep(scratch);
  const std::string page = page_of(scratch, "-o sweep/report.html");
  EXPECT_EQ(scratch.run("mtf report sweep -o -").out, page);
  write_file(scratch / "sweep/columns.csv", "column,unit,definition\n");
  for (const std::string file : {"designs.csv", "columns.csv"}) {
    expect_error(scratch.run("mtf report sweep -o sweep/" + file), 2, {"is the input"});
  }
  EXPECT_EQ(scratch.run("mtf report sweep -o nowhere/report.html").status, 1);
}

/// A board of two temperatures as board.exr.
void write_board(const Scratch& scratch, float difference_k) {
  mtf::Image scene(400, 400);
  for (std::int64_t y = 0; y < 400; ++y)
    for (std::int64_t x = 0; x < 400; ++x)
      scene.at(x, y) = 290.0F + difference_k * static_cast<float>((x / 40 + y / 40) % 2);
  mtf::io::Metadata metadata;
  metadata.pairs["mtf:pixelPitch"] = {4e-6, 4e-6};
  metadata.text["mtf:quantity"] = "temperature";
  metadata.text["mtf:units"] = "K";
  mtf::io::write_exr((scratch / "board.exr").string(), {{"Y", scene.view()}}, metadata);
}

TEST(Report, LooksAtASceneOfOnesOwn) {
  const Scratch scratch;
  make_sweep(scratch);
  write_board(scratch, 1.0F);
  const std::string own = page_of(scratch, "--scene board.exr");
  expect_says(own, {"The scene <code>board.exr</code>"});
  EXPECT_EQ(count(own, "src=\"data:image/png"), data_of(own)["chosen"].size());
  EXPECT_EQ(count(own, "cannot be kept"), 0U);
  const Result missing = scratch.run("mtf report sweep --scene nowhere.exr");
  EXPECT_EQ(missing.status, 1);
  EXPECT_EQ(lines(missing.err), 1U) << missing.err;
  fs::remove(scratch / "sweep/report.html");
  write_file(scratch / "board.exr", "no image");
  expect_error(scratch.run("mtf report sweep --scene board.exr"), 2, {"--scene: ", "board.exr"});
  EXPECT_FALSE(fs::exists(scratch / "sweep/report.html"));
}

// Float32 cannot keep the tolerance of the page for a scene of so little contrast; the image is shown, and says so.
TEST(Report, ShowsASceneOfLittleContrastAsWellAsItCan) {
  const Scratch scratch;
  make_sweep(scratch);
  write_board(scratch, 1e-4F);
  const std::string page = page_of(scratch, "--scene board.exr");
  EXPECT_EQ(count(page, "src=\"data:image/png"), data_of(page)["chosen"].size());
  EXPECT_EQ(count(page, "cannot be kept"), data_of(page)["chosen"].size());
}

}  // namespace
}  // namespace apps_test
