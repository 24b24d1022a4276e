// SPDX-License-Identifier: Apache-2.0

// `mtf measure`: units of frequency in every output, and frequencies of contrasts that were asked for.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/calib/made_edges.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

/// An edge of MTF50 0.3 cycles/pixel in 100 rows.
struct UnitsOfMeasure : testing::Test {
  Scratch scratch;
  UnitsOfMeasure() {
    const mtf::Image image = made::make(made::Step::gaussian(0.3), {.noise_sd = 0.01});
    mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", image.view()}}, {});
  }
  Json json(const std::string& options) const {
    const Result result = scratch.run("mtf measure edge.exr --format json " + options);
    EXPECT_EQ(result.status, 0) << result.err;
    return Json::parse(result.out);
  }
  std::string refusal(const std::string& options) const {
    const Result result = scratch.run("mtf measure edge.exr " + options);
    EXPECT_EQ(result.status, 2) << options;
    EXPECT_EQ(result.out, "");
    return result.err;
  }
};

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) all.push_back(cell);
  return all;
}

struct UnitCase {
  const char *options, *symbol, *name;
  double per_cy_px;
};

TEST_F(UnitsOfMeasure, EveryFrequencyIsInTheUnitThatIsNamed) {
  const Json plain = json("").at("edges")[0];
  // 1 / 5 um = 200 cycles/mm; at 50 mm a milliradian is 50 um, ten pixels; 100 rows.
  for (const UnitCase& unit : {UnitCase{"--unit cy/mm --pitch 5um", "cy/mm", "cycles/mm", 200.0},
                               {"--unit lp/mm --pitch 0.005mm", "lp/mm", "line pairs/mm", 200.0},
                               {"--unit cy/mrad --pitch 5um --focal-length 50mm", "cy/mrad", "cycles/mrad", 10.0},
                               {"--unit lw/ph", "lw/ph", "line widths/picture height", 200.0}}) {
    SCOPED_TRACE(unit.options);
    const std::string options = unit.options;
    const Json report = json(options), edge = report.at("edges")[0];
    EXPECT_EQ(report.at("unit"), unit.name);
    const auto expect_scaled = [&](const char* figure, double factor) {
      for (const char* part : {"value", "sd"}) {
        const double expected = factor * plain.at(figure).at(part).get<double>();
        EXPECT_NEAR(edge.at(figure).at(part).get<double>(), expected, 1e-12 * expected) << figure;
      }
    };
    for (const char* frequency : {"mtf50", "mtf30", "mtf20", "mtf10", "mtf50p"})
      expect_scaled(frequency, unit.per_cy_px);
    for (const char* other : {"nyquist", "rer", "fwhm_px", "mtfa", "sampling_efficiency"}) expect_scaled(other, 1.0);
    EXPECT_EQ(edge.at("mtf").at("frequency").back().get<double>(), unit.per_cy_px);
    EXPECT_EQ(edge.at("mtf").at("value"), plain.at("mtf").at("value"));

    const std::string table = scratch.run("mtf measure edge.exr " + options).out;
    expect_says(table, {"MTF50 [" + std::string(unit.symbol) + "]", "in " + std::string(unit.name) + ";"});

    ASSERT_EQ(
        scratch.run("mtf measure edge.exr --format csv -o e.csv --curves c.csv --map m.svg --plot p.svg " + options)
            .status,
        0);
    std::istringstream csv(read_file(scratch / "e.csv")), map(read_file(scratch / "m.svg.csv"));
    for (std::istringstream* file : {&csv, &map}) {
      std::string head, line;
      std::getline(*file, head);
      std::getline(*file, line);
      EXPECT_TRUE(head.ends_with(",frequency_unit")) << head;
      EXPECT_TRUE(line.ends_with("," + std::string(unit.symbol))) << line;
      const std::vector<std::string> names = cells(head), values = cells(line);
      const auto at = std::find(names.begin(), names.end(), "mtf50") - names.begin();
      EXPECT_NEAR(std::stod(values.at(static_cast<std::size_t>(at))), edge.at("mtf50").at("value").get<double>(), 1e-9);
    }
    const std::string curves = read_file(scratch / "c.csv");
    EXPECT_TRUE(curves.starts_with("edge,curve,x,value,sd,x_unit\n"));
    expect_says(curves, {"\n1,mtf," + std::to_string(static_cast<int>(unit.per_cy_px)) + ",", ",px\n"});
    expect_says(read_file(scratch / "p.svg.csv"), {"\"MTF over " + std::string(unit.symbol) + ", 2 sd\"," +
                                                   std::to_string(static_cast<int>(unit.per_cy_px))});
  }
}

TEST_F(UnitsOfMeasure, AUnitThatLacksALengthIsRefused) {
  expect_says(refusal("--unit cy/mm"), {"--pitch"});
  expect_says(refusal("--unit lp/mm"), {"--pitch"});
  expect_says(refusal("--unit cy/mrad --pitch 5um"), {"--focal-length"});
  expect_says(refusal("--unit cy/mm --pitch 5"), {"--pitch"});
  expect_says(refusal("--unit cy/mm --pitch 5urad"), {"--pitch: "});
  expect_says(refusal("--pitch 5um"), {"add --unit cy/mm"});
  expect_says(refusal("--unit lw/ph --focal-length 5mm"), {"--focal-length: "});
  for (const char* pitch : {"1e300um", "1e-300um", "1e-308um"})
    EXPECT_TRUE(says(refusal("--unit cy/mm --pitch " + std::string(pitch)), "is outside [1e-06, 1e+06]")) << pitch;
  expect_says(refusal("--unit cy/mm --pitch -5um"), {"length above 0"});
  expect_says(refusal("--unit lw/pw"), {"lw/ph"});
}

// A fit reads the unit from the file: the same result from curves in any of them.
TEST_F(UnitsOfMeasure, AFitReadsTheUnitOfCurves) {
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  const auto jitter = [&](const std::string& options) {
    EXPECT_EQ(scratch.run("mtf measure demo/edge.exr -o table --curves c.csv " + options).status, 0);
    const Result fit = scratch.run("mtf fit demo/fit.toml --curve c.csv@-5 --format json");
    EXPECT_TRUE(fit.status == 0 || fit.status == 3) << fit.err;
    return Json::parse(fit.out).at("parameters")[0].at("value").get<double>();
  };
  const double pixels = jitter("");
  EXPECT_NEAR(pixels, 2.0, 0.3);
  EXPECT_NEAR(jitter("--unit cy/mm --pitch 15um"), pixels, 1e-5);
  EXPECT_NEAR(jitter("--unit lp/mm --pitch 15um"), pixels, 1e-5);
  EXPECT_NEAR(jitter("--unit cy/mrad --pitch 15um --focal-length 100mm"), pixels, 1e-5);
  ASSERT_EQ(scratch.run("mtf measure demo/edge.exr -o table --curves c.csv --unit lw/ph").status, 0);
  expect_error(scratch.run("mtf fit demo/fit.toml --curve c.csv@-5"), 2, {"lw/ph"});
}

TEST_F(UnitsOfMeasure, ContrastsThatWereAskedFor) {
  const Json edge = json("--contrast-level 0.35 --contrast-level 0.125 --contrast-level 0.5").at("edges")[0];
  for (const auto& [name, contrast] : {std::pair{"mtf35", 0.35}, {"mtf12.5", 0.125}}) {
    const double truth = 0.3 * std::sqrt(std::log2(1.0 / contrast)), sd = edge.at(name).at("sd").get<double>();
    EXPECT_NEAR(edge.at(name).at("value").get<double>(), truth, 5.0 * sd) << name;
    EXPECT_GT(sd, 0.0);
    EXPECT_LT(sd, 0.02 * truth);
  }
  const Result table = scratch.run("mtf measure edge.exr --contrast-level 0.35 --unit lw/ph");
  expect_says(table.out, {"MTF35 [lw/ph]"});
  const std::string csv = scratch.run("mtf measure edge.exr --contrast-level 0.35 --format csv").out;
  expect_says(csv, {",mtf35,mtf35_sd,"});
  const Json standard = json("--method iso12233 --contrast-level 0.35").at("edges")[0];
  EXPECT_NEAR(standard.at("mtf35").at("value").get<double>(), 0.3 * std::sqrt(std::log2(1.0 / 0.35)), 0.01);
  EXPECT_TRUE(standard.at("mtf35").at("sd").is_null());
  for (const char* wrong : {"0", "1", "-0.2", "35"})
    EXPECT_TRUE(says(refusal(std::string("--contrast-level ") + wrong), "between 0 and 1")) << wrong;
}

// A contrast that is a figure of every edge in JSON and CSV has its column in the tables too.
TEST_F(UnitsOfMeasure, AContrastThatEveryEdgeHasStandsInTheTables) {
  const Json edge = json("").at("edges")[0];
  const Result table =
      scratch.run("mtf measure edge.exr --contrast-level 0.2 --contrast-level 0.35 --contrast-level 0.5 --table t.csv");
  expect_says(table.out, {"MTF50 [cy/px]", "MTF20 [cy/px]"});
  EXPECT_EQ(table.out.find("MTF50 [cy/px]"), table.out.rfind("MTF50 [cy/px]")) << table.out;
  std::istringstream csv(read_file(scratch / "t.csv"));
  std::string head, line;
  std::getline(csv, head);
  std::getline(csv, line);
  const std::vector<std::string> names = cells(head), values = cells(line);
  ASSERT_EQ(names.size(), 6U + 3U * 4U + 2U) << head;
  for (const char* figure : {"mtf50", "mtf20"})
    for (const char* kind : {"_best", "_median"}) {
      const auto at = std::find(names.begin(), names.end(), figure + std::string(kind));
      ASSERT_NE(at, names.end()) << head;
      EXPECT_NEAR(std::stod(values.at(static_cast<std::size_t>(at - names.begin()))),
                  edge.at(figure).at("value").get<double>(), 1e-9)
          << *at;
    }
}

TEST_F(UnitsOfMeasure, APitchThatIsNotTheFilesIsRemarked) {
  const mtf::Image image = made::make(made::Step::gaussian(0.3), {.noise_sd = 0.01});
  mtf::io::Metadata stated;
  stated.pairs["mtf:pixelPitch"] = {15e-6, 15e-6};
  mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", image.view()}}, stated);
  const std::string measure = "mtf measure edge.exr --unit cy/mm --pitch ";
  EXPECT_EQ(scratch.run(measure + "15um").err, "");
  const Result other = scratch.run(measure + "5um");
  expect_says(other.err, {"edge.exr", "15 x 15 um", "--pitch says 5 um"});
}

TEST_F(UnitsOfMeasure, AContrastToWhichTheMtfDoesNotFallIsNull) {
  const mtf::Image image = made::make(made::Step::gaussian(0.75), {});
  mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", image.view()}}, {});
  const Json edge = json("--contrast-level 0.15 --unit cy/mm --pitch 5um").at("edges")[0];
  EXPECT_TRUE(edge.at("mtf15").is_null());
  const std::string reason = edge.at("reason").get<std::string>();
  expect_says(reason, {"mtf15", "15 %", "200 cycles/mm"});
}

}  // namespace
}  // namespace apps_test
