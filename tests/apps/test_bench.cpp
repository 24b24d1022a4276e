// SPDX-License-Identifier: Apache-2.0
// What `mtf bench` writes: its promises, its shapes, and rivals that do the same job.
#include <nlohmann/json.hpp>
#include <set>

#include "tests/apps/bench_csv.h"
#include "tests/expect_error.h"

namespace apps_test {
namespace {

constexpr const char* kHeader =
    "tolerance,method,chosen,promised,rms_error,max_error,time_ms_min,time_ms_median,plan_ms,memory_mib,floor_ms,"
    "floor_image_ms";

/// Every row as it has to be, whatever was measured.
void check_rows(const std::vector<Row>& rows) {
  std::map<double, int> chosen;
  std::set<double> refused;
  for (const Row& row : rows) {
    const double tolerance = value(row, "tolerance");
    const std::string& method = row.at("method");
    chosen[tolerance] += row.at("chosen") == "1" ? 1 : 0;
    if (method == "refused") {
      refused.insert(tolerance);
      for (const char* name : {"promised", "rms_error", "max_error", "time_ms_min"}) EXPECT_EQ(row.at(name), "");
      expect_says(row.at("detail"), {"reachable: "});
      continue;
    }
    EXPECT_GE(value(row, "max_error"), value(row, "rms_error")) << method;
    for (const char* name : {"time_ms_min", "floor_ms", "floor_image_ms", "memory_mib"})
      EXPECT_GT(value(row, name), 0.0) << name << " " << method << " " << tolerance;
    EXPECT_GE(value(row, "time_ms_median"), value(row, "time_ms_min"));
    EXPECT_EQ(row.at("promised").empty(), is_rival(row)) << method;
    EXPECT_EQ(row.at("plan_ms").empty(), is_rival(row)) << method;
    if (is_rival(row)) continue;
    EXPECT_LE(value(row, "promised"), tolerance) << method;
    EXPECT_LE(value(row, "rms_error"), value(row, "promised")) << method;
    EXPECT_GT(value(row, "rms_error"), 0.0) << method;  // of float: an error of 0 would be a broken measure
  }
  EXPECT_EQ(chosen.size(), 7U);
  for (const auto& [tolerance, count] : chosen) EXPECT_EQ(count, refused.count(tolerance) == 0 ? 1 : 0) << tolerance;
}

struct RatioAndBorder {
  double samples;
  const char* border;
};

void expect_rows_to_keep_their_promises(std::initializer_list<RatioAndBorder> cases) {
  const Scratch scratch;
  write_bench_scene(scratch / "scene.exr", 60, 48);
  for (const RatioAndBorder& c : cases) {
    write_bench_sensor(scratch / "sensor.toml", c.samples, c.border, kDiffraction);
    const Result result = scratch.run("mtf bench sensor.toml scene.exr -o b --force" + kQuick);
    ASSERT_EQ(result.status, 0) << c.border << "\n" << result.err;
    const std::string csv = read_file(scratch / "b/bench.csv");
    ASSERT_TRUE(csv.starts_with(kHeader)) << csv;
    const std::vector<Row> rows = read_rows(csv);
    check_rows(rows);
    EXPECT_EQ(value(rows.front(), "tolerance"), 1e-1);
    EXPECT_EQ(value(rows.back(), "tolerance"), 1e-7);
  }
}

TEST(Bench, RowsKeepTheirPromises) { expect_rows_to_keep_their_promises({{2, "replicate"}, {2.3, "reflect"}}); }
TEST(BenchLong, RowsKeepTheirPromises) {
  expect_rows_to_keep_their_promises({{1, "reflect"}, {3, "constant"}, {4, "periodic"}});
}

TEST(Bench, StagesBehindTheSamplingAndABand) {
  const Scratch scratch;
  write_bench_scene(scratch / "scene.exr", 40, 40);
  write_bench_sensor(
      scratch / "sensor.toml", 2, "reflect",
      "[band]\nwavelength = [\"3.4 um\", \"4.8 um\"]\n" + kDiffraction +
          "[[postsample]]\nkind = \"fir\"\ntaps = [[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]\n");
  std::string text = read_file(scratch / "sensor.toml");
  text.erase(text.find("wavelength = \"4.0 um\"\n"), 22);
  write_file(scratch / "sensor.toml", text);
  const Result result = scratch.run("mtf bench sensor.toml scene.exr -o b" + kQuick);
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.err, {"no rows for OpenCV"});
  const auto rows = read_rows(read_file(scratch / "b/bench.csv"));
  check_rows(rows);
  for (const Row& row : rows) EXPECT_FALSE(is_rival(row));
}

struct Rivals {
  double samples;
  const char* border;
  const std::string& stages;
};

void expect_opencv_to_do_the_same_job(std::initializer_list<Rivals> cases) {
  const Scratch scratch;
  write_bench_scene(scratch / "scene.exr", 60, 48);
  for (const Rivals& c : cases) {
    write_bench_sensor(scratch / "sensor.toml", c.samples, c.border, c.stages);
    const Result result = scratch.run("mtf bench sensor.toml scene.exr -o b --force" + kQuick);
    ASSERT_EQ(result.status, 0) << result.err;
    if (result.err.find("no rows for OpenCV") != std::string::npos) GTEST_SKIP() << "no OpenCV";
    std::map<std::string, double> best;
    for (const Row& row : read_rows(read_file(scratch / "b/bench.csv")))
      if (is_rival(row)) {
        const auto [known, fresh] = best.try_emplace(row.at("method"), value(row, "rms_error"));
        known->second = std::min(known->second, value(row, "rms_error"));
      }
    EXPECT_LT(best.at("opencv_dft"), 5e-6) << c.samples << " " << c.border;  // float rounding is what remains
    EXPECT_LT(best.at("opencv_filter2d"), &c.stages == &kSeparable ? 5e-6 : 3e-2) << c.samples << " " << c.border;
    EXPECT_EQ(best.count("opencv_sep"), &c.stages == &kSeparable ? 1U : 0U);
    for (const auto& [method, error] : best) EXPECT_TRUE(method != "opencv_sep" || error < 5e-6) << error;
  }
}

TEST(Bench, OpenCvDoesTheSameJob) {
  expect_opencv_to_do_the_same_job({{2, "constant", kSeparable}, {1, "periodic", kDiffraction}});
}
TEST(BenchLong, OpenCvDoesTheSameJob) {
  expect_opencv_to_do_the_same_job(
      {{1, "reflect", kSeparable}, {3, "replicate", kSeparable}, {3, "reflect", kDiffraction}});
}

TEST(Bench, FilesAndFormats) {
  const Scratch scratch;
  scratch.add_sensor();
  write_bench_scene(scratch / "scene.exr", 64, 48);
  const Result csv = scratch.run("mtf bench sensor.toml scene.exr -o b --format csv" + kQuick);
  ASSERT_EQ(csv.status, 0) << csv.err;
  EXPECT_EQ(csv.out, read_file(scratch / "b/bench.csv"));
  const auto json = nlohmann::json::parse(read_file(scratch / "b/bench.json"));
  EXPECT_EQ(json.at("rows").size(), read_rows(csv.out).size());
  EXPECT_EQ(json.at("scene_size"), nlohmann::json({64, 48}));
  EXPECT_EQ(json.at("threads"), 1);
  EXPECT_GE(json.at("machine").at("cores"), 1);
  expect_says(json.at("command").get<std::string>(), {"mtf bench sensor.toml scene.exr", "-o b "});
  for (const char* name : {"git_commit", "fft", "floors", "warnings", "version"})
    EXPECT_TRUE(json.contains(name)) << name;
  for (const auto& row : json.at("rows")) EXPECT_EQ(row.at("time_ms_min").is_null(), row.at("method") == "refused");
  if (scratch.run("command -v gnuplot").status == 0) {
    const std::string svg = read_file(scratch / "b/bench.svg");
    expect_says(svg, {"chosen by the plan", "Pareto front", "FFTW 64x48", "fft_float"});
    EXPECT_TRUE(read_file(scratch / "b/bench.png").starts_with("\x89PNG"));
  }
  const Result table = scratch.run("mtf bench sensor.toml scene.exr -o b --force --progress plain" + kQuick);
  expect_says(table.out, {"rms error"});
  expect_says(table.err, {"timing 100 %"});
  const Result as_json = scratch.run("mtf bench sensor.toml scene.exr -o b --force --format json" + kQuick);
  EXPECT_TRUE(nlohmann::json::accept(as_json.out)) << as_json.out;
}

/// Shape and colour of a method in the legend of bench.svg, "" without the method.
std::string symbol_of(const std::string& svg, const std::string& method) {
  const std::size_t name = svg.find("<text>" + method + "</text>");
  if (name == std::string::npos) return "";
  const std::size_t shape = svg.find("#gpPt", name), colour = svg.find("color='rgb", shape);
  return svg.substr(shape, svg.find('\'', shape) - shape) + " " + svg.substr(colour, svg.find(')', colour) - colour);
}

TEST(Bench, AMethodHasOneSymbolWhicheverOthersArePresent) {
  const Scratch scratch;
  if (scratch.run("command -v gnuplot").status != 0) GTEST_SKIP() << "no gnuplot";
  write_bench_scene(scratch / "scene.exr", 60, 48);
  std::vector<std::string> charts;
  for (const std::string& stages : {kDiffraction, kSeparable}) {
    write_bench_sensor(scratch / "sensor.toml", 2, "reflect", stages);
    ASSERT_EQ(scratch.run("mtf bench sensor.toml scene.exr -o b --force" + kQuick).status, 0);
    charts.push_back(read_file(scratch / "b/bench.svg"));
  }
  std::map<std::string, std::string> of;  // the methods of both charts, by symbol
  for (const char* method : {"separable", "fft_float", "fft_cut", "fft_double", "opencv_dft", "opencv_filter2d"}) {
    const std::string first = symbol_of(charts[0], method), second = symbol_of(charts[1], method);
    if (first.empty() || second.empty()) continue;
    EXPECT_EQ(first, second) << method;
    EXPECT_TRUE(of.try_emplace(first, method).second) << method << " and " << of[first];
  }
  EXPECT_GE(of.size(), 2U);
  EXPECT_NE(symbol_of(charts[0], "separable").empty(), symbol_of(charts[1], "separable").empty())
      << "the charts are to differ in their methods";
}

TEST(Bench, WithoutGnuplotTheNumbersAreThere) {
  const Scratch scratch;
  scratch.add_sensor();
  write_bench_scene(scratch / "scene.exr", 32, 32);
  const Result result =
      scratch.run("m=$(command -v mtf); PATH=/nonexistent $m bench sensor.toml scene.exr -o b" + kQuick);
  EXPECT_EQ(result.status, 0) << result.err;
  expect_says(result.err, {"gnuplot is not installed"});
  EXPECT_EQ(scratch.run("ls b").out, "bench.csv\nbench.json\n");
}

TEST(Bench, WithoutOpenCvThePlansAreTimed) {
  const Scratch scratch;
  scratch.add_sensor();
  write_bench_scene(scratch / "scene.exr", 32, 32);
  const Result result =
      scratch.run("MTFKIT_OPENCV=/nonexistent mtf bench sensor.toml scene.exr -o b --format csv" + kQuick);
  EXPECT_EQ(result.status, 0) << result.err;
  expect_says(result.err, {"no rows for OpenCV", "/nonexistent", "Debian package mtfkit-codecs"});
  EXPECT_FALSE(says(result.out, "opencv_")) << result.out;
  check_rows(read_rows(result.out));
}

}  // namespace
}  // namespace apps_test
