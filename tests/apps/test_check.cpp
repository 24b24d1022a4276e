// SPDX-License-Identifier: Apache-2.0

// `mtf check`: what it prints, and that it fails when a value is off.

#include <gtest/gtest.h>

#include <cstdlib>
#include <iomanip>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "apps/check/check.h"
#include "apps/check/check_engine.h"
#include "mtf/system.h"
#include "tests/apps/command.h"
#include "tests/mtf/components/own_test.h"

namespace apps_test {
namespace {

using apps::check::BuiltInTable;
using apps::check::Check;
using apps::check::CheckResult;
using apps::check::Tables;
using apps::check::Tally;
using Json = nlohmann::json;

std::string built_in(std::string_view name) {
  for (const BuiltInTable& table : apps::check::built_in_tables())
    if (table.name == name) return std::string(table.text);
  throw std::runtime_error("no table " + std::string(name));
}

/// The cell of one row and column (from 0) replaced.
std::string with_cell(const std::string& csv, int row, int column, const std::string& value) {
  std::size_t at = 0;
  for (int i = 0; i < row; ++i) at = csv.find('\n', at) + 1;
  for (int i = 0; i < column; ++i) at = csv.find(',', at) + 1;
  return csv.substr(0, at) + value + csv.substr(csv.find_first_of(",\n", at));
}

TEST(CheckCommand, PassesAndSaysSoInItsLastLine) {
  const Scratch scratch;
  const Result result = scratch.run("mtf check");
  EXPECT_EQ(result.status, 0) << result.out << result.err;
  EXPECT_FALSE(says(result.out, "FAIL")) << result.out;
  const std::string last = result.out.substr(result.out.rfind('\n', result.out.size() - 2) + 1);
  EXPECT_TRUE(last.starts_with("all ") && last.find(" checks passed: ") != std::string::npos) << last;
  EXPECT_EQ(result.err, "");
}

TEST(CheckCommand, JsonHasEveryCheckWithItsErrors) {
  const Scratch scratch;
  const Result result = scratch.run("mtf check --format json -o check.json");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.out, "");
  const Json json = Json::parse(read_file(scratch / "check.json"));
  EXPECT_TRUE(json["passed"]);
  EXPECT_EQ(json["checks"].size(), apps::check::all_checks().size());
  std::set<std::pair<std::string, std::string>> names;
  for (const Json& check : json["checks"]) {
    EXPECT_GT(check["values"], 3) << check;
    EXPECT_TRUE(check["worst_abs"].is_number() && check["worst_rel"].is_number()) << check;
    EXPECT_LT(check["worst_abs"].get<double>(), 0.01) << check;  // relative: anything, where a slope vanishes
    EXPECT_NE(check["promise"], "");
    names.emplace(check["component"], check["case"]);
  }
  EXPECT_EQ(names.size(), json["checks"].size()) << "two checks of one name";
}

TEST(CheckCommand, AWrongValueFailsWithItsPlace) {
  const Scratch scratch;
  fs::create_directory(scratch / "tables");
  // The first value 5e-15 off, where 4e-16 is promised.
  write_file(scratch / "tables/circular_mtf_extremes.csv",
             with_cell(built_in("circular_mtf_extremes.csv"), 1, 5, "0.03738607346850"));
  const Result result = scratch.run("mtf check --reference tables");
  EXPECT_EQ(result.status, 3);
  expect_says(result.out, {"circular_mtf_extremes.csv:2: "});
  const Result quiet = scratch.run("mtf check --reference tables --format csv -o out.csv --quiet");
  EXPECT_EQ(quiet.status, 3);
  EXPECT_EQ(quiet.out + quiet.err, "");
  expect_says(read_file(scratch / "out.csv"), {",FAIL,"});
}

TEST(CheckCommand, FoldersThatAreNotTablesAreRefused) {
  const Scratch scratch;
  fs::create_directory(scratch / "tables");
  const auto refused = [&](std::initializer_list<std::string_view> parts) {
    const Result result = scratch.run("mtf check --reference tables");
    expect_error(result, 2, parts);
    EXPECT_EQ(lines(result.err), 1U) << result.err;
  };
  refused({"no reference tables"});
  write_file(scratch / "tables/sinc_extreme.csv", "x\n1\n");
  refused({"did you mean sinc_extremes.csv?"});
  fs::remove(scratch / "tables/sinc_extreme.csv");
  write_file(scratch / "tables/sinc_extremes.csv", "x,sinc_pi_x\n1,0\n");
  refused({"sinc_extremes.csv:2: no column x_hex"});
  write_file(scratch / "tables/sinc_extremes.csv", "x_hex,sinc_pi_x\n1,zero\n");
  refused({"sinc_extremes.csv:2: 'zero'", "column sinc_pi_x"});
  write_file(scratch / "tables/sinc_extremes.csv", "x_hex,sinc_pi_x\n1\n");
  refused({"sinc_extremes.csv:2: 1 cells under 2 columns"});
  write_file(scratch / "tables/sinc_extremes.csv", "x_hex,sinc_pi_x\n");
  refused({"sinc_extremes.csv: no rows"});
  EXPECT_EQ(scratch.run("mtf check --reference nowhere").status, 2);
}

/// Every decimal number of the table a thousandth smaller: arguments and values no longer belong together.
std::string distorted(const BuiltInTable& table) {
  const std::string header(table.text.substr(0, table.text.find('\n')));
  std::string text = header + "\n";
  for (const auto& row : apps::check::parse_table(std::string(table.name), table.text)) {
    std::istringstream columns(header);
    std::string line;
    for (std::string column; std::getline(columns, column, ',');) {
      const std::string& cell = row.at(column);
      char* end = nullptr;
      const long double value = std::strtold(cell.c_str(), &end);
      const bool decimal = *end == '\0' && cell.find("0x") == std::string::npos;
      std::ostringstream scaled;
      scaled << std::setprecision(25) << value * 0.999L;
      line += (line.empty() ? "" : ",") + (decimal ? scaled.str() : cell);
    }
    text += line + "\n";
  }
  return text;
}

TEST(Check, NoTableCheckPassesOnWrongValues) {
  const Scratch scratch;
  const auto folder = scratch / "tables";
  fs::create_directory(folder);
  for (const BuiltInTable& table : apps::check::built_in_tables())
    if (table.name != "gradients.csv" && table.name != "kolmogorov.csv")  // of the test suite, refused in a folder
      write_file(folder / std::string(table.name), distorted(table));
  const Tables wrong(folder.string());
  int of_tables = 0;
  for (const Check& check : apps::check::all_checks()) {
    if (check.component == "engine") continue;
    EXPECT_FALSE(run(check, wrong).passed) << check.component << " " << check.name;
    ++of_tables;
  }
  EXPECT_GE(of_tables, 8);
}

TEST(Check, EveryKindOfComponentIsCheckedHereOrInATestOfItsOwn) {
  std::set<std::string_view> checked;
  const std::vector<Check> checks = apps::check::all_checks();
  for (const Check& check : checks) checked.insert(check.component);
  int of_tables = 0;
  for (const std::string_view kind : mtf::component_kinds()) {
    EXPECT_TRUE(checked.contains(kind) || mtf::test::has_own_test(kind))
        << kind << ": give it reference values, in tests/mtf/components/test_" << kind
        << ".cpp or in notebooks-data/reference/generators/golden_components.py";
    of_tables += checked.contains(kind) ? 1 : 0;
  }
  EXPECT_GE(of_tables, 35);
}

// An OTF that is off by a thousandth where the engine's rounding is 1e-6, and the right one.
TEST(Check, EngineIsHeldToItsPrediction) {
  const auto system = apps::check::optics();
  const auto otf = apps::check::otf_of(system, mtf::Stage::presample);
  const mtf::Image scene = apps::check::noisy(31, 18);
  for (const double off : {0.0, 1e-3}) {
    Tally tally;
    apps::check::keeps_promise(tally, system, scene, 2.0, mtf::Border::reflect,
                               [&](double fx, double fy) { return otf(fx, fy) * (1.0 + off); });
    EXPECT_EQ(tally.count(), 1);
    EXPECT_EQ(tally.failure().empty(), off == 0.0) << tally.failure();
  }
}

TEST(Check, OwnTablesTakeThePlaceOfTheBuiltInOnes) {
  const Scratch scratch;
  write_file(scratch / "sinc_extremes.csv", "x_hex,sinc_pi_x\r\n0x1p-1,0.63661977236758134307553505349\r\n");
  const Tables own((scratch / ".").string());
  EXPECT_EQ(own.rows("sinc_extremes.csv").size(), 1U);
  EXPECT_EQ(own.rows("gaussian_extremes.csv").size(), Tables().rows("gaussian_extremes.csv").size());
  for (const Check& check : apps::check::all_checks())
    if (check.name == "sinc") {
      const CheckResult result = run(check, own);
      EXPECT_TRUE(result.passed && result.count == 1) << result.failure;
    }
}

TEST(Check, ComparisonsFailBeyondTheirAllowance) {
  const auto result = [](double value, double exact, double allowed) {
    return apps::check::run(
        {"a", "b", "c", [=](const Tables&, Tally& tally) { tally.compare(value, exact, allowed, "here"); }}, {});
  };
  EXPECT_TRUE(result(1.0, 1.0, 0.0).passed);
  EXPECT_TRUE(result(1.5, 1.0, 0.5).passed);
  EXPECT_FALSE(result(1.5000000001, 1.0, 0.5).passed);
  EXPECT_FALSE(result(std::numeric_limits<double>::quiet_NaN(), 1.0, 0.5).passed);
  EXPECT_FALSE(result(std::numeric_limits<double>::infinity(), 1.0, 0.5).passed);
  const CheckResult off = result(3.0, 2.0, 0.25);
  EXPECT_EQ(off.worst_abs, 1.0);
  EXPECT_EQ(off.worst_rel, 0.5);
  expect_says(off.failure, {"here: ", "3 instead of 2", "off by 1", "0.25"});
  EXPECT_FALSE(apps::check::run({"a", "b", "c", [](const Tables&, Tally&) {}}, {}).passed) << "nothing compared";
}

}  // namespace
}  // namespace apps_test
