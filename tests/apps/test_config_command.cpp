// SPDX-License-Identifier: Apache-2.0

// `mtf config` and `mtf info`.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "mtf/component.h"
#include "mtf/io/config/config.h"
#include "mtf/io/image_io.h"
#include "tests/apps/command.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

TEST(Config, InitWritesTheStarterAndKeepsWhatIsThere) {
  const Scratch scratch;
  EXPECT_EQ(scratch.run("mtf config init").out, mtf::io::starter_config());
  EXPECT_EQ(scratch.run("mtf config init -o -").out, mtf::io::starter_config());
  ASSERT_EQ(scratch.run("mtf config init -o s.toml").status, 0);
  EXPECT_EQ(read_file(scratch / "s.toml"), mtf::io::starter_config());
  write_file(scratch / "s.toml", "mine");
  expect_error(scratch.run("mtf config init s.toml"), 2, {"--force"});
  EXPECT_EQ(read_file(scratch / "s.toml"), "mine");
  EXPECT_EQ(scratch.run("mtf config init s.toml --force").status, 0);
  EXPECT_EQ(read_file(scratch / "s.toml"), mtf::io::starter_config());
  EXPECT_EQ(scratch.run("mtf config init -o missing/s.toml").status, 1);
  for (const char* word : {"foo", "studi", "study foo", "toml"}) {
    expect_error(scratch.run(std::string("mtf config init ") + word), 2,
                 {"is no kind of file", "sensor, study, scene"});
    EXPECT_EQ(std::distance(fs::directory_iterator(scratch / "."), {}), 1) << word;
  }
}

TEST(Config, CheckSaysOkOrEveryErrorWithItsPlace) {
  const Scratch scratch;
  scratch.add_sensor();
  const Result good = scratch.run("mtf config check sensor.toml");
  EXPECT_EQ(good.status, 0);
  EXPECT_TRUE(good.out.starts_with("ok: sensor.toml")) << good.out;
  EXPECT_EQ(good.err, "");

  write_file(scratch / "bad.toml",
             "schema = 1\n[frame]\nfocal_lenght = \"100 mm\"\nfocal_length = \"100 mm\"\npitch = 15\n");
  const Result bad = scratch.run("mtf config check bad.toml");
  EXPECT_EQ(bad.status, 2);
  EXPECT_EQ(bad.out, "");
  expect_says(bad.err, {"bad.toml:3:1: error: ", "bad.toml:5:"});
  const Result curve = scratch.run("mtf curve bad.toml");
  EXPECT_EQ(curve.status, 2);
  EXPECT_EQ(curve.err, bad.err);

  const Result json = scratch.run("mtf config check bad.toml --format json");
  EXPECT_EQ(json.status, 2);
  const Json parsed = Json::parse(json.out);
  EXPECT_FALSE(parsed.at("ok").get<bool>());
  ASSERT_GE(parsed.at("diagnostics").size(), 2U);
  EXPECT_EQ(parsed.at("diagnostics")[0].at("severity"), "error");
  EXPECT_EQ(parsed.at("diagnostics")[0].at("line"), 3);
  EXPECT_EQ(scratch.run("mtf config check missing.toml").status, 1);
}

TEST(Config, CheckShowsNotesWithOk) {
  const Scratch scratch;
  write_file(scratch / "s.toml", "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n");
  const Result result = scratch.run("mtf config check s.toml");
  EXPECT_EQ(result.status, 0);
  EXPECT_TRUE(result.out.starts_with("ok: s.toml")) << result.out;
  expect_says(result.out, {"note: "});
  const Result curve = scratch.run("mtf curve s.toml --freq 0,1");
  EXPECT_EQ(curve.status, 0);
  expect_says(curve.err, {"note: "});
  EXPECT_EQ(scratch.run("mtf curve s.toml --freq 0,1 --quiet").err, "");
}

TEST(Config, ExplainShowsWhatNumbersBecome) {
  const Scratch scratch;
  scratch.add_sensor();
  const Result result = scratch.run("mtf config explain sensor.toml");
  EXPECT_EQ(result.status, 0);
  expect_says(result.out, {"frame.focal_length", "\"100 mm\"", "sensor.toml:", "125 cy/mm", "0.5333333333"});
}

TEST(Config, KindsShowsEveryComponentFromItsFieldTable) {
  const Scratch scratch;
  const Result all = scratch.run("mtf config kinds");
  ASSERT_EQ(all.status, 0) << all.err;
  for (const std::string_view kind : mtf::component_kinds())
    EXPECT_TRUE(says("\n" + all.out, "\n" + std::string(kind) + ": ")) << kind;
  const Result one = scratch.run("mtf config kinds jitter");
  EXPECT_TRUE(one.out.starts_with("jitter: ")) << one.out;
  expect_says(one.out, {"\"8 urad\""});
  EXPECT_EQ(scratch.run("mtf config kinds jiter").status, 2);
}

TEST(Config, KindsDescribesTablesOfTheChain) {
  const Scratch scratch;
  const Result table = scratch.run("mtf config kinds detector");
  EXPECT_EQ(table.status, 0) << table.err;
  EXPECT_TRUE(table.out.starts_with("[detector]: ")) << table.out;
  expect_says(table.out, {"  quantum_efficiency ", "[0, 1], or a file", "  full_well "});
  expect_says(scratch.run("mtf config kinds shutter").out, {"global | rolling"});
  const std::string frame = scratch.run("mtf config kinds frame").out;  // its keys with and without a chain
  expect_says(frame, {"  focal_length ", "  pitch (or pitch_x", "  frame_time "});
  EXPECT_FALSE(says(frame, "[0, 0]")) << frame;  // their ranges follow from other values
  expect_says(scratch.run("mtf config kinds band").out, {"  wavelength "});
  expect_error(scratch.run("mtf config kinds bands"), 2, {"'bands'", "did you mean band?"});
  expect_error(scratch.run("mtf config kinds \"what is there\""), 2, {"mtf config kinds lists"});
}

#ifdef MTFKIT_HAVE_STUDY
TEST(Config, KindsDescribesStudies) {
  const Scratch scratch;
  const std::string study = scratch.run("mtf config kinds study").out;
  for (const char* key :
       {"\n  schema ", "\n  objectives ", "\n[[axis]]: ", "\n  parameter ", "\n[links]: ", "\n  draws "})
    EXPECT_TRUE(says(study, key)) << key;
  const std::string conditions = scratch.run("mtf config kinds conditions").out;
  EXPECT_TRUE(conditions.starts_with("[conditions]: ")) << conditions;
  expect_says(conditions, {"  target_size ", "\"3.1 m\"", "[0.001, 1e6]"});
  const std::string metrics = scratch.run("mtf config kinds metrics").out;
  expect_says(metrics, {"\n  netd ", "  mtf_nyquist* ", "[conditions] contrast and target_size"});
  EXPECT_TRUE(scratch.run("mtf config kinds netd").out.starts_with("netd: "));
  EXPECT_TRUE(scratch.run("mtf config kinds mtf_at_20_cy_mm_x").out.starts_with("mtf_at_20_cy_mm_x: "));
  expect_error(scratch.run("mtf config kinds ntd"), 2, {"'ntd'", "did you mean netd?"});
  const Json json = Json::parse(scratch.run("mtf config kinds conditions --format json").out);
  const auto& rows = json["tables"][0]["parameters"];
  const auto range = std::ranges::find_if(rows, [](const Json& row) { return row["name"] == "target_size"; });
  ASSERT_NE(range, rows.end());
  EXPECT_EQ((*range)["unit"], "m");
  const Json named = Json::parse(scratch.run("mtf config kinds metrics --format json").out)["metrics"];
  EXPECT_TRUE(std::ranges::any_of(named, [](const Json& one) { return one["name"] == "netd" && one["unit"] == "mK"; }));
  expect_error(scratch.run("mtf config kinds study --format json"), 2, {"mtf config schema study"});
  const Json one = Json::parse(scratch.run("mtf config kinds rer_x --format json").out)["metrics"];
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0]["name"], "rer_x");
  for (const char* format : {"json", "markdown"})
    expect_error(scratch.run("mtf config kinds netdd --format " + std::string(format)), 2, {"netdd", "netd?"});
  expect_error(scratch.run("mtf config kinds netd --format markdown"), 2, {"mtf config kinds netd", "--format json"});
}

TEST(Config, TheStudyToStartFromRunsOnTheSensorToStartFrom) {
  const Scratch scratch;
  const std::string starter = scratch.run("mtf config init study").out;
  const Result written = scratch.run("mtf config init study -o study.toml");
  ASSERT_EQ(written.status, 0) << written.err;
  expect_says(written.err, {"mtf config init -o sensor.toml", "mtf config check study.toml"});
  EXPECT_EQ(read_file(scratch / "study.toml"), starter);
  expect_error(scratch.run("mtf config init study study.toml"), 2, {"study.toml", "--force"});
  expect_error(scratch.run("mtf config init study a.toml b.toml"), 2, {"'b.toml'", "a.toml"});
  expect_error(scratch.run("mtf config check study.toml"), 2, {"study.toml:", "sensor.toml"});
  scratch.add_sensor();
  const Result checked = scratch.run("mtf config check study.toml");
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_EQ(checked.err, "");
  EXPECT_EQ(scratch.run("mtf sweep study.toml -o trade").status, 0);
  // Its [conditions], in full, are as good as its other keys.
  std::string text = starter;
  for (std::size_t at = text.find("# [conditions]"); at != std::string::npos; at = text.find("\n# ", at))
    text.erase(text.find("# ", at), 2);
  for (const char* either : {"\nmagnification = ", "\nextinction = "}) text.insert(text.find(either) + 1, "# ");
  write_file(scratch / "study.toml", text);
  const Result all = scratch.run("mtf config check study.toml");
  EXPECT_EQ(all.status, 0) << all.err;
}

// Nothing is computed for a metric that no design can have, so a study that lists one is not what was meant.
TEST(Config, AStudyThatLacksWhatItsMetricNeedsFailsWithTheKeyToAdd) {
  const Scratch scratch;
  scratch.add_sensor();
  const auto check = [&](const std::string& list, const std::string& conditions) {
    write_file(scratch / "study.toml",
               "schema = 1\nsensor = \"sensor.toml\"\n[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"8 um\"]\n"
               "[metrics]\nlist = [\"mtf_nyquist\", " +
                   list + "]\n" + conditions);
    return scratch.run("mtf config check study.toml");
  };
  expect_error(check("\"gsd\"", ""), 2, {"study.toml:7:24: error: metrics.list: gsd", "range = \"5 km\""});
  EXPECT_EQ(check("\"gsd\"", "[conditions]\nrange = \"5 km\"\n").status, 0);
  expect_error(check("\"netd\"", ""), 2, {"study.toml:7:24: error: metrics.list: netd", "[detector]"});
  // What the list of metrics says of their needs is what the check asks for.
  const Json metrics = Json::parse(scratch.run("mtf config kinds metrics --format json").out)["metrics"];
  std::string all = "\"q\"";
  for (const Json& metric : metrics)
    if (metric["name"] != "q" && metric["name"] != "mtf_nyquist") all += ", " + metric["name"].dump();
  const std::string err = check(all, "").err;
  for (const Json& metric : metrics) {
    const std::string needs = metric["needs"], name = metric["name"];
    if (needs.find('[') == std::string::npos) {
      EXPECT_FALSE(says(err, ": " + name + " is asked")) << name;
    } else if (needs != "[frame] format") {
      EXPECT_TRUE(says(err, ": " + name + " is asked")) << name << ": " << needs;
    }
  }
}
#endif

TEST(Config, ASceneToStartFromIsThatOfTheDemo) {
  const Scratch scratch;
  const Result demo = scratch.run("mtf scene demo -o demo");
  if (says(demo.err, "libmtfkit_scenes")) GTEST_SKIP() << "no scenes";
  ASSERT_EQ(demo.status, 0) << demo.err;
  const Result written = scratch.run("mtf config init scene -o demo/mine.toml");
  ASSERT_EQ(written.status, 0) << written.err;
  expect_says(written.err, {"mtf scene demo -o FOLDER", "mtf scene check demo/mine.toml"});
  EXPECT_EQ(read_file(scratch / "demo/mine.toml"), read_file(scratch / "demo/scene.toml"));
  EXPECT_EQ(scratch.run("mtf scene check demo/mine.toml").status, 0);
}

TEST(Config, KindsTellsThePhysicsOfAComponent) {
  const Scratch scratch;
  const Result one = scratch.run("mtf config kinds footprint");
  expect_says(one.out, {"  otf = sinc(wx fx) sinc(wy fy)", "(Boreman, ", "parameter"});
  const Result section = scratch.run("mtf config kinds footprint --format markdown");
  EXPECT_TRUE(section.out.starts_with("## footprint\n")) << section.out;
  expect_says(section.out, {"\n\n    otf = sinc(wx fx) sinc(wy fy)"});
  EXPECT_EQ(scratch.run("mtf config kinds --format csv").status, 2);
}

TEST(Config, ComponentReadmeIsWhatKindsPrints) {
  const Scratch scratch;
  const Result result = scratch.run("mtf config kinds --format markdown");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(result.out == read_file(fs::path(MTFKIT_SOURCE_DIR) / "mtf/components/README.md"))
      << "stale; run: mtf config kinds --format markdown > mtf/components/README.md";
}

TEST(Config, ExplainListsFormulaAndSourceOfEachKindOnce) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string out = scratch.run("mtf config explain sensor.toml").out;
  expect_says(out, {"\nfootprint\n  otf = sinc(wx fx)", "\ndiffraction\n  otf = M(nu, e)", "  source: Goodman"});
  EXPECT_EQ(out.find("source: Goodman"), out.rfind("source: Goodman"));
}

TEST(Info, DescribesAnImageAndSaysWhatToRun) {
  const Scratch scratch;
  mtf::Image first(4, 2), second(4, 2);
  for (int i = 0; i < 8; ++i) {
    first.data()[i] = static_cast<float>(i);
    second.data()[i] = 2.0F;
  }
  second.at(1, 1) = std::numeric_limits<float>::quiet_NaN();
  mtf::io::Metadata metadata;
  metadata.text = {{"mtf:quantity", "radiance"}, {"mtf:units", "W.m^-2.sr^-1"}};
  mtf::io::write_exr((scratch / "two.exr").string(), {{"a.Y", first.view()}, {"b.Y", second.view()}}, metadata);

  const Result json = scratch.run("mtf info two.exr --format json");
  ASSERT_EQ(json.status, 0) << json.err;
  const Json parsed = Json::parse(json.out);
  EXPECT_EQ(parsed.at("format"), "OpenEXR");
  EXPECT_EQ(parsed.at("width"), 4);
  EXPECT_EQ(parsed.at("height"), 2);
  ASSERT_EQ(parsed.at("channels").size(), 2U);
  const Json& a = parsed.at("channels")[0];
  EXPECT_EQ(a.at("name"), "a.Y");
  EXPECT_EQ(a.at("layer"), "a");
  EXPECT_EQ(a.at("min"), 0.0);
  EXPECT_EQ(a.at("max"), 7.0);
  EXPECT_EQ(a.at("mean"), 3.5);
  EXPECT_NEAR(a.at("std").get<double>(), std::sqrt(5.25), 1e-12);
  const Json& b = parsed.at("channels")[1];
  EXPECT_EQ(b.at("not_finite"), 1);
  EXPECT_EQ(b.at("mean"), 2.0);
  EXPECT_EQ(parsed.at("next"), "mtf simulate sensor.toml two.exr --layer a -o out.exr");

  const Result table = scratch.run("mtf info two.exr");
  expect_says(table.out, {"W.m^-2.sr^-1 (stated", "two.exr --layer a -o"});
  const Result csv = scratch.run("mtf info two.exr --format csv --layer a");
  EXPECT_TRUE(csv.out.starts_with(
      "channel,type,layer,part,min,max,mean,std,not_finite\na.Y,float,a,0,0,7,3.5,2.29128784747792"))
      << csv.out;
  EXPECT_EQ(lines(csv.out), 2U);
}

TEST(Info, SensorFilesAndWhatItCannotRead) {
  const Scratch scratch;
  scratch.add_sensor();
  const Result sensor = scratch.run("mtf info sensor.toml");
  EXPECT_EQ(sensor.status, 0);
  expect_says(sensor.out, {"next: mtf curve sensor.toml\n"});
  write_file(scratch / "bad.toml", "schema = 2\n");
  EXPECT_EQ(scratch.run("mtf info bad.toml").status, 2);
  write_file(scratch / "text.txt", "hello, world\n");
  const Result unknown = scratch.run("mtf info text.txt");
  EXPECT_EQ(unknown.status, 1);
  expect_says(unknown.err, {"OpenEXR", "PNG", "TIFF"});
  write_file(scratch / "empty.exr", "");
  for (const char* file : {"missing.exr", "empty.exr", "."})
    EXPECT_EQ(scratch.run(std::string("mtf info ") + file).status, 1) << file;
}

// One message in place of an error for each key that the other kind does not have.
TEST(Config, SaysWhatAFileIsThatIsOfAnotherKind) {
  const Scratch scratch;
  scratch.add_sensor();
  write_file(scratch / "study.toml", "sensor = \"sensor.toml\"\n[[axis]]\nparameter = \"frame.pitch\"\n");
  write_file(scratch / "scene.toml", "schema = 1\n[place]\nlatitude = \"37 deg\"\n[[mesh]]\nfile = \"a.obj\"\n");
  const auto expect_one_message = [&](const std::string& command, std::initializer_list<std::string_view> parts) {
    const Result result = scratch.run(command);
    expect_error(result, 2, parts);
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << command << ": " << result.err;
  };
  for (const char* command : {"config check", "info"})
    expect_one_message("mtf " + std::string(command) + " scene.toml", {"3-D scene", "[[mesh]]", "`mtf scene check`"});
  for (const char* command : {"config explain", "curve", "budget"})
    expect_one_message("mtf " + std::string(command) + " scene.toml",
                       {"3-D scene", "[[mesh]]", "a sensor file belongs"});
  expect_one_message("mtf curve study.toml", {"a study", "names a sensor", "a sensor file belongs"});
  const Json json = Json::parse(scratch.run("mtf config check scene.toml --format json").out);
  EXPECT_EQ(json.at("diagnostics").size(), 1U);
#ifdef MTFKIT_HAVE_CALIB
  expect_one_message("mtf sweep sensor.toml -o out", {"a sensor file", "[frame]", "a study belongs"});
  expect_one_message("mtf sweep scene.toml -o out", {"3-D scene", "[[mesh]]", "a study belongs"});
#endif
  // A key that another kind has too is an error of its own place.
  write_file(scratch / "named.toml", read_file(scratch / "sensor.toml") + "[mesh]\n");
  expect_says(scratch.run("mtf config check named.toml").err, {"mesh: unknown key"});
}

#ifdef MTFKIT_HAVE_CALIB
TEST(Config, CheckReadsStudiesToo) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string study =
      "schema = 1\nname = \"pitch\"\nsensor = \"sensor.toml\"\n[[axis]]\nparameter = \"frame.pitch\"\n"
      "values = [\"10 um\", \"12 um\"]\n[metrics]\nlist = [\"mtf_nyquist\"]\n";
  write_file(scratch / "study.toml", study);
  const Result good = scratch.run("mtf config check study.toml");
  EXPECT_EQ(good.status, 0) << good.err;
  expect_says(good.out, {"ok: study.toml: pitch", "2 designs (a grid)", "1 axis, 1 metric"});
  const Result info = scratch.run("mtf info study.toml");
  EXPECT_EQ(info.status, 0);
  expect_says(info.out, {"next: mtf sweep study.toml"});

  write_file(scratch / "study.toml", study + "[links]\nfocal_length = \"3 * (2 + 1 s)\"\n");
  const Result bad = scratch.run("mtf config check study.toml");
  EXPECT_EQ(bad.status, 2);
  EXPECT_EQ(bad.out, "");
  EXPECT_TRUE(bad.err.starts_with("study.toml:10:22: error: links.focal_length: cannot add")) << bad.err;
  EXPECT_EQ(scratch.run("mtf info study.toml").status, 2);
  const Result json = scratch.run("mtf config check study.toml --format json");
  EXPECT_EQ(json.status, 2);
  const Json parsed = Json::parse(json.out);
  EXPECT_EQ(parsed.at("name"), "pitch");
  EXPECT_EQ(parsed.at("diagnostics").at(0).at("column"), 22);

  write_file(scratch / "study.toml", "sensor = [\n");  // neither: the place of the first wrong character
  EXPECT_EQ(scratch.run("mtf config check study.toml").status, 2);
}
#endif

}  // namespace
}  // namespace apps_test
