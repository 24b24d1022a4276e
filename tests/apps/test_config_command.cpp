// SPDX-License-Identifier: Apache-2.0

// `mtf config` and `mtf info`.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "mtf/component.h"
#include "mtf/io/config/config.h"
#include "mtf/io/image_io.h"
#include "tests/apps/command.h"

namespace {

using apps_test::Result;
using apps_test::Scratch;
using Json = nlohmann::json;

TEST(Config, InitWritesTheStarterAndKeepsWhatIsThere) {
  const Scratch scratch;
  EXPECT_EQ(scratch.run("mtf config init").out, mtf::io::starter_config());
  EXPECT_EQ(scratch.run("mtf config init -o -").out, mtf::io::starter_config());
  ASSERT_EQ(scratch.run("mtf config init -o s.toml").status, 0);
  EXPECT_EQ(apps_test::read_file(scratch / "s.toml"), mtf::io::starter_config());
  apps_test::write_file(scratch / "s.toml", "mine");
  const Result refused = scratch.run("mtf config init s.toml");
  expect_error(refused, 2, {"--force"});
  EXPECT_EQ(apps_test::read_file(scratch / "s.toml"), "mine");
  EXPECT_EQ(scratch.run("mtf config init s.toml --force").status, 0);
  EXPECT_EQ(apps_test::read_file(scratch / "s.toml"), mtf::io::starter_config());
  EXPECT_EQ(scratch.run("mtf config init -o missing/s.toml").status, 1);
}

TEST(Config, CheckSaysOkOrEveryErrorWithItsPlace) {
  const Scratch scratch;
  scratch.add_sensor();
  const Result good = scratch.run("mtf config check sensor.toml");
  EXPECT_EQ(good.status, 0);
  EXPECT_TRUE(good.out.starts_with("ok: sensor.toml")) << good.out;
  EXPECT_EQ(good.err, "");

  apps_test::write_file(scratch / "bad.toml",
                        "schema = 1\n[frame]\nfocal_lenght = \"100 mm\"\nfocal_length = \"100 mm\"\npitch = 15\n");
  const Result bad = scratch.run("mtf config check bad.toml");
  EXPECT_EQ(bad.status, 2);
  EXPECT_EQ(bad.out, "");
  EXPECT_NE(bad.err.find("bad.toml:3:1: error: "), std::string::npos) << bad.err;
  EXPECT_NE(bad.err.find("bad.toml:5:"), std::string::npos) << bad.err;
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
  apps_test::write_file(scratch / "s.toml", "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n");
  const Result result = scratch.run("mtf config check s.toml");
  EXPECT_EQ(result.status, 0);
  EXPECT_TRUE(result.out.starts_with("ok: s.toml")) << result.out;
  EXPECT_NE(result.out.find("note: "), std::string::npos) << result.out;
  const Result curve = scratch.run("mtf curve s.toml --freq 0,1");
  EXPECT_EQ(curve.status, 0);
  EXPECT_NE(curve.err.find("note: "), std::string::npos);
  EXPECT_EQ(scratch.run("mtf curve s.toml --freq 0,1 --quiet").err, "");
}

TEST(Config, ExplainShowsWhatNumbersBecome) {
  const Scratch scratch;
  scratch.add_sensor();
  const Result result = scratch.run("mtf config explain sensor.toml");
  EXPECT_EQ(result.status, 0);
  for (const char* text : {"frame.focal_length", "\"100 mm\"", "sensor.toml:", "125 cy/mm", "0.5333333333"})
    EXPECT_NE(result.out.find(text), std::string::npos) << text << "\n" << result.out;
}

TEST(Config, KindsShowsEveryComponentFromItsFieldTable) {
  const Scratch scratch;
  const Result all = scratch.run("mtf config kinds");
  ASSERT_EQ(all.status, 0) << all.err;
  for (const std::string_view kind : mtf::component_kinds())
    EXPECT_NE(("\n" + all.out).find("\n" + std::string(kind) + ": "), std::string::npos) << kind;
  const Result one = scratch.run("mtf config kinds jitter");
  EXPECT_TRUE(one.out.starts_with("jitter: ")) << one.out;
  EXPECT_NE(one.out.find("\"8 urad\""), std::string::npos) << one.out;
  EXPECT_EQ(scratch.run("mtf config kinds jiter").status, 2);
}

TEST(Config, KindsDescribesTablesOfTheChain) {
  const Scratch scratch;
  const Result table = scratch.run("mtf config kinds detector");
  EXPECT_EQ(table.status, 0) << table.err;
  EXPECT_TRUE(table.out.starts_with("[detector]: ")) << table.out;
  for (const char* text : {"  quantum_efficiency ", "[0, 1], or a file", "  full_well "})
    EXPECT_NE(table.out.find(text), std::string::npos) << text << "\n" << table.out;
  EXPECT_NE(scratch.run("mtf config kinds shutter").out.find("global | rolling"), std::string::npos);
  const std::string frame = scratch.run("mtf config kinds frame").out;  // its keys with and without a chain
  for (const char* text : {"  focal_length ", "  pitch (or pitch_x", "  frame_time "})
    EXPECT_NE(frame.find(text), std::string::npos) << text << "\n" << frame;
  EXPECT_EQ(frame.find("[0, 0]"), std::string::npos) << frame;  // their ranges follow from other values
  EXPECT_NE(scratch.run("mtf config kinds band").out.find("  wavelength "), std::string::npos);
  EXPECT_NE(scratch.run("mtf config kinds bands").err.find("tables: frame, scene, optics, band, "), std::string::npos);
}

TEST(Config, KindsTellsThePhysicsOfAComponent) {
  const Scratch scratch;
  const Result one = scratch.run("mtf config kinds footprint");
  for (const char* text : {"  otf = sinc(wx fx) sinc(wy fy)", "(Boreman, ", "parameter"})
    EXPECT_NE(one.out.find(text), std::string::npos) << text << "\n" << one.out;
  const Result section = scratch.run("mtf config kinds footprint --format markdown");
  EXPECT_TRUE(section.out.starts_with("## footprint\n")) << section.out;
  EXPECT_NE(section.out.find("\n\n    otf = sinc(wx fx) sinc(wy fy)"), std::string::npos) << section.out;
  EXPECT_EQ(scratch.run("mtf config kinds --format csv").status, 2);
}

TEST(Config, ComponentReadmeIsWhatKindsPrints) {
  const Scratch scratch;
  const Result result = scratch.run("mtf config kinds --format markdown");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(result.out == apps_test::read_file(apps_test::fs::path(MTFKIT_SOURCE_DIR) / "mtf/components/README.md"))
      << "stale; run: mtf config kinds --format markdown > mtf/components/README.md";
}

TEST(Config, ExplainListsFormulaAndSourceOfEachKindOnce) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string out = scratch.run("mtf config explain sensor.toml").out;
  for (const char* text : {"\nfootprint\n  otf = sinc(wx fx)", "\ndiffraction\n  otf = M(nu, e)", "  source: Goodman"})
    EXPECT_NE(out.find(text), std::string::npos) << text << "\n" << out;
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
  EXPECT_NE(table.out.find("radiance in W.m^-2.sr^-1 (stated in the file)"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("next: mtf simulate sensor.toml two.exr --layer a -o out.exr\n"), std::string::npos);
  const Result csv = scratch.run("mtf info two.exr --format csv --layer a");
  EXPECT_TRUE(csv.out.starts_with(
      "channel,type,layer,part,min,max,mean,std,not_finite\na.Y,float,a,0,0,7,3.5,2.29128784747792"))
      << csv.out;
  EXPECT_EQ(apps_test::lines(csv.out), 2U);
}

TEST(Info, SensorFilesAndWhatItCannotRead) {
  const Scratch scratch;
  scratch.add_sensor();
  const Result sensor = scratch.run("mtf info sensor.toml");
  EXPECT_EQ(sensor.status, 0);
  EXPECT_NE(sensor.out.find("next: mtf curve sensor.toml\n"), std::string::npos) << sensor.out;
  apps_test::write_file(scratch / "bad.toml", "schema = 2\n");
  EXPECT_EQ(scratch.run("mtf info bad.toml").status, 2);
  apps_test::write_file(scratch / "text.txt", "hello, world\n");
  const Result unknown = scratch.run("mtf info text.txt");
  EXPECT_EQ(unknown.status, 1);
  for (const char* format : {"OpenEXR", "PNG", "TIFF"})
    EXPECT_NE(unknown.err.find(format), std::string::npos) << unknown.err;
  apps_test::write_file(scratch / "empty.exr", "");
  for (const char* file : {"missing.exr", "empty.exr", "."})
    EXPECT_EQ(scratch.run(std::string("mtf info ") + file).status, 1) << file;
}

// One message in place of an error for each key that the other kind does not have.
TEST(Config, SaysWhatAFileIsThatIsOfAnotherKind) {
  const Scratch scratch;
  scratch.add_sensor();
  apps_test::write_file(scratch / "study.toml", "sensor = \"sensor.toml\"\n[[axis]]\nparameter = \"frame.pitch\"\n");
  apps_test::write_file(scratch / "scene.toml",
                        "schema = 1\n[place]\nlatitude = \"37 deg\"\n[[mesh]]\nfile = \"a.obj\"\n");
  const auto expect_one_message = [&](const std::string& command, const std::string& text) {
    const Result result = scratch.run(command);
    EXPECT_EQ(result.status, 2) << command;
    EXPECT_NE(result.err.find(text), std::string::npos) << command << ": " << result.err;
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << command << ": " << result.err;
  };
  const std::string scene = "the file of a 3-D scene, for it has [[mesh]]; ";
  for (const char* command : {"config check", "info"})
    expect_one_message("mtf " + std::string(command) + " scene.toml", scene + "`mtf scene check` reads it");
  for (const char* command : {"config explain", "curve", "budget"})
    expect_one_message("mtf " + std::string(command) + " scene.toml", scene + "a sensor file belongs here");
  expect_one_message("mtf curve study.toml", "a study, for it names a sensor; a sensor file belongs here");
  const Json json = Json::parse(scratch.run("mtf config check scene.toml --format json").out);
  EXPECT_EQ(json.at("diagnostics").size(), 1U);
#ifdef MTFKIT_HAVE_CALIB
  expect_one_message("mtf sweep sensor.toml -o out", "a sensor file, for it has [frame]; a study belongs here");
  expect_one_message("mtf sweep scene.toml -o out", scene + "a study belongs here");
#endif
  // A key that another kind has too is an error of its own place.
  apps_test::write_file(scratch / "named.toml", apps_test::read_file(scratch / "sensor.toml") + "[mesh]\n");
  EXPECT_NE(scratch.run("mtf config check named.toml").err.find("mesh: unknown key"), std::string::npos);
}

#ifdef MTFKIT_HAVE_CALIB
TEST(Config, CheckReadsStudiesToo) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string study =
      "schema = 1\nname = \"pitch\"\nsensor = \"sensor.toml\"\n[[axis]]\nparameter = \"frame.pitch\"\n"
      "values = [\"10 um\", \"12 um\"]\n[metrics]\nlist = [\"mtf_nyquist\"]\n";
  apps_test::write_file(scratch / "study.toml", study);
  const Result good = scratch.run("mtf config check study.toml");
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_TRUE(good.out.starts_with("ok: study.toml: pitch, 2 designs (a grid), 1 axis, 1 metric")) << good.out;
  const Result info = scratch.run("mtf info study.toml");
  EXPECT_EQ(info.status, 0);
  EXPECT_NE(info.out.find("next: mtf sweep study.toml"), std::string::npos) << info.out;

  apps_test::write_file(scratch / "study.toml", study + "[links]\nfocal_length = \"3 * (2 + 1 s)\"\n");
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

  apps_test::write_file(scratch / "study.toml", "sensor = [\n");  // neither: the place of the first wrong character
  EXPECT_EQ(scratch.run("mtf config check study.toml").status, 2);
}
#endif

}  // namespace
