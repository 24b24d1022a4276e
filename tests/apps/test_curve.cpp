// SPDX-License-Identifier: Apache-2.0

// `mtf curve`: values that can be met by hand, units that agree, shapes that programs rely on.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "apps/sensor/otf_curves.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"
#include "tests/apps/command.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

Json curve(const Scratch& scratch, const std::string& arguments) {
  const Result result = scratch.run("mtf curve " + arguments + " --format json");
  EXPECT_EQ(result.status, 0) << result.err;
  return Json::parse(result.out);
}

const Json& component(const Json& json, const std::string& label) {
  for (const Json& entry : json.at("components"))
    if (entry.at("label") == label) return entry;
  throw std::runtime_error("no component " + label);
}

TEST(Curve, ValuesOfTheStarterSensor) {
  const Scratch scratch;
  scratch.add_sensor();
  // 4 um, F/2: cutoff 1 / (lambda N) = 125 cy/mm; 15 um pitch: Nyquist 33.33 cy/mm; Q = 8 um / 15 um.
  const Json json = curve(scratch, "sensor.toml --freq 0,33.333333333333336,125,200");
  EXPECT_NEAR(json.at("cutoff").get<double>(), 125.0, 1e-12);
  EXPECT_NEAR(json.at("nyquist").get<double>(), 100.0 / 3.0, 1e-12);
  EXPECT_NEAR(json.at("q").get<double>(), 8.0 / 15.0, 1e-15);

  const double v = (100.0 / 3.0) / 125.0;
  const double diffraction = 2.0 / std::numbers::pi * (std::acos(v) - v * std::sqrt(1.0 - v * v));
  const double footprint = 2.0 / std::numbers::pi;
  const double jitter = std::exp(-2.0 * std::pow(std::numbers::pi * 0.002 * 100.0 / 3.0, 2));
  EXPECT_NEAR(component(json, "diffraction").at("re")[1].get<double>(), diffraction, 1e-12);
  EXPECT_NEAR(component(json, "footprint").at("re")[1].get<double>(), footprint, 1e-12);
  EXPECT_NEAR(component(json, "jitter").at("re")[1].get<double>(), jitter, 1e-12);
  EXPECT_NEAR(json.at("system").at("re")[1].get<double>(), diffraction * footprint * jitter, 1e-12);
  EXPECT_NEAR(diffraction, 0.6645, 5e-5);
  EXPECT_NEAR(footprint, 0.6366, 5e-5);
  EXPECT_NEAR(jitter, 0.9160, 5e-5);
  EXPECT_NEAR(json.at("system").at("re")[1].get<double>(), 0.3875, 5e-5);
  EXPECT_NEAR(json.at("system").at("re")[0].get<double>(), 1.0, 1e-15);
  EXPECT_EQ(json.at("system").at("re")[2].get<double>(), 0.0);
  EXPECT_EQ(json.at("system").at("re")[3].get<double>(), 0.0);
}

TEST(Curve, AtAFieldPoint) {
  const Scratch scratch;
  const std::string head =
      "schema = 2\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\nformat = [640, 512]\n[optics]\nf_number = "
      "2.0\nwavelength = \"4 um\"\n[[presample]]\nkind = \"wavefront\"\n";
  write_file(scratch / "field.toml",
             head + "orientation = \"field\"\nw131 = { r = 0.7 }\nw020 = { 1 = -0.3, r2 = 0.5 }\n");
  write_file(scratch / "there.toml", head + "orientation = \"36.869897645844021 deg\"\nw131 = 0.7\nw020 = 0.2\n");
  const Json there = curve(scratch, "there.toml --freq 0:60:4"),
             here = curve(scratch, "field.toml --freq 0:60:4 --field 0.8,0.6");
  EXPECT_EQ(here.at("field"), Json::array({0.8, 0.6}));
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(here.at("system").at("re")[i].get<double>(), there.at("system").at("re")[i].get<double>(), 1e-12);
    EXPECT_NEAR(here.at("system").at("im")[i].get<double>(), there.at("system").at("im")[i].get<double>(), 1e-12);
  }
  const Json corner = curve(scratch, "field.toml --freq 0:60:4 --field 640px,512px");
  EXPECT_NEAR(std::hypot(corner.at("field")[0].get<double>(), corner.at("field")[1].get<double>()), 1.0, 1e-15);
  const Json map = curve(scratch, "field.toml --map mtf@30 --angle 90"),
             one = curve(scratch, "field.toml --freq 30,31 --angle 90 --field 160.25px,128.25px");
  EXPECT_EQ(map.at("places").size(), 81U);
  const auto value = [&](const Json& place) { return place.at("value").get<double>(); };
  EXPECT_DOUBLE_EQ(value(map.at("places")[2 * 9 + 2]),
                   std::hypot(one.at("system").at("re")[0].get<double>(), one.at("system").at("im")[0].get<double>()));
  for (const Json& place : map.at("places")) EXPECT_LE(value(map.at("worst")), value(place));
  double best = 0.0;  // not on the axis, which is out of focus
  for (const Json& place : map.at("places")) best = std::max(best, value(place));
  EXPECT_GT(best, value(map.at("axis")));
  EXPECT_LT(map.at("mean").get<double>(), best);
  EXPECT_GT(map.at("mean").get<double>(), value(map.at("worst")));
  EXPECT_LT(map.at("mean_error").get<double>(), 0.02);
  expect_error(scratch.run("mtf curve field.toml --field 0.9,0.9"), 2, {"--field", "1.27", "half diagonals"});
  expect_error(scratch.run("mtf curve field.toml --map mtf"), 2, {"--map", "mtf@nyquist"});
  expect_error(scratch.run("mtf curve field.toml --map mtf50 --field 0,0"), 2, {"--field", "leave"});
  expect_error(scratch.run("mtf curve field.toml --field 0.5"), 2, {"--field", "320px,40px"});
  expect_error(scratch.run("mtf curve field.toml --field 700px,10px"), 2, {"--field", "640 x 512"});
  expect_error(scratch.run("mtf curve field.toml --field 0.5,40px"), 2, {"--field", "px"});
  expect_error(scratch.run("mtf curve field.toml --field nan,0"), 2, {"--field"});
  expect_error(scratch.run("mtf curve field.toml --field 300,0"), 2, {"half diagonals"});
  const Result budget = scratch.run("mtf curve field.toml");
  EXPECT_EQ(budget.status, 0);
  expect_says(budget.err, {"presample[0].w131", "optical axis"});
}

TEST(Curve, TableAndItsFooter) {
  const Scratch scratch;
  scratch.add_sensor();
  const Result result = scratch.run("mtf curve sensor.toml --freq 0:60:7");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  expect_says(result.out,
              {"cy/mm  diffraction  footprint   jitter  presample   system\n", "125.0 cy/mm", "33.33 cy/mm", "0.5333",
               "MTF at Nyquist along x  diffraction 0.6645 x footprint 0.6366 x jitter 0.9160 = 0.3875\n"});
  for (const auto& [angle, text] : {std::pair{"90", "\nMTF at Nyquist along y  diffraction "},
                                    std::pair{"45", "\nMTF at Nyquist at 45 deg  diffraction "}}) {
    const Result other = scratch.run(std::string("mtf curve sensor.toml --freq 0:60:7 --angle ") + angle);
    expect_says(other.out, {text});
  }
}

TEST(Curve, ShapeOfTheJson) {
  const Scratch scratch;
  scratch.add_sensor();
  const Json json = curve(scratch, "sensor.toml --freq 0:60:61 --unit cy/mm --angle 0");
  EXPECT_EQ(json.at("unit"), "cy/mm");
  EXPECT_EQ(json.at("angle_deg"), 0.0);
  ASSERT_EQ(json.at("frequency").size(), 61U);
  for (std::size_t i = 0; i < 61; ++i) EXPECT_EQ(json.at("frequency")[i].get<double>(), static_cast<double>(i));
  ASSERT_EQ(json.at("components").size(), 3U);
  for (const Json& entry : json.at("components")) {
    EXPECT_EQ(entry.at("stage"), "presample");
    EXPECT_EQ(entry.at("kind"), entry.at("label"));
    EXPECT_EQ(entry.at("re").size(), 61U);
    EXPECT_EQ(entry.at("im").size(), 61U);
  }
  for (const char* name : {"presample", "readout", "postsample", "system"}) {
    EXPECT_EQ(json.at(name).at("re").size(), 61U) << name;
    EXPECT_EQ(json.at(name).at("im").size(), 61U) << name;
  }
}

TEST(Curve, Mtf50OfAGaussianAndOfNone) {
  const Scratch scratch;
  const std::string head = "schema = 1\nname = \"blur\"\n[frame]\nfocal_length = \"50 mm\"\npitch = \"15 um\"\n";
  const auto found = [&](const std::string& rms_um) {
    write_file(scratch / "g.toml", head + "[[presample]]\nkind = \"gaussian\"\nsigma = \"" + rms_um + " um\"\n");
    const mtf::System<double> system = mtf::io::load_config((scratch / "g.toml").string()).system;
    return apps::mtf50(system, apps::otf_curves(system));
  };
  // exp(-2 (pi s f)^2) = 1/2.
  const double expected = std::sqrt(0.5 * std::log(2.0)) / (std::numbers::pi * 0.007);
  EXPECT_NEAR(found("7").value(), expected, 1e-5 * expected);
  EXPECT_FALSE(found("0.1")) << "0.999 at twice the Nyquist frequency";
}

const char* const kComplexSensor = R"(schema = 1
name = "all lists"
[frame]
focal_length = "50 mm"
pitch_x = "15 um"
pitch_y = "10 um"
[optics]
f_number = 2.0
[band]
wavelength = ["8 um", "12 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "rms_wavefront"
rms = 0.07
label = "a, \"b\""
[[readout]]
kind = "rc_lowpass"
cutoff = "40 cy/mm"
[[postsample]]
kind = "fir"
taps = [[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]
)";

TEST(Curve, EqualsTheLibraryInEveryUnitAndDirection) {
  const Scratch scratch;
  write_file(scratch / "s.toml", kComplexSensor);
  const mtf::io::SensorConfig config = mtf::io::load_config((scratch / "s.toml").string());
  const double angle = 30.0 * std::numbers::pi / 180.0;
  struct Case {
    const char* unit;
    double x, y;  // cycles/mm for one unit along each axis
  };
  for (const Case& c : {Case{"cy/mm", 1.0, 1.0}, Case{"cy/mrad", 20.0, 20.0}, Case{"cy/px", 1000.0 / 15.0, 100.0}}) {
    const Json json = curve(scratch, std::string("s.toml --freq 0,0.1,0.4,-0.3 --angle 30 --unit ") + c.unit);
    for (std::size_t i = 0; i < 4; ++i) {
      const double f = json.at("frequency")[i].get<double>();
      const mtf::Complex<double> h = config.system.otf({f * c.x * std::cos(angle), f * c.y * std::sin(angle)});
      EXPECT_NEAR(json.at("system").at("re")[i].get<double>(), h.re, 1e-12) << c.unit << " " << f;
      EXPECT_NEAR(json.at("system").at("im")[i].get<double>(), h.im, 1e-12) << c.unit << " " << f;
    }
  }
}

/// The CSV that a table would make, names without characters that need quotes.
std::string csv_of(const std::vector<apps::TableColumn>& table) {
  std::string text;
  for (const apps::TableColumn& column : table) text += (text.empty() ? "" : ",") + column.name;
  for (std::size_t i = 0; i < table.front().values.size(); ++i)
    for (const apps::TableColumn& column : table)
      text += (&column == table.data() ? "\n" : ",") + mtf::format_double(column.values[i]);
  return text + "\n";
}

TEST(Curve, CallGivesWhatTheCommandPrints) {
  const Scratch scratch;
  std::string text = kComplexSensor;
  const std::string quoted = R"(a, \"b\")";
  text.replace(text.find(quoted), quoted.size(), "polish");
  write_file(scratch / "s.toml", text);
  const mtf::System<double> system = mtf::io::load_config((scratch / "s.toml").string()).system;
  EXPECT_EQ(csv_of(apps::table_of(apps::otf_curves(system))), scratch.run("mtf curve s.toml --format csv").out);

  const apps::OtfCurves curves =
      apps::otf_curves(system, {0.0, 0.1, 0.4}, apps::make_direction(system.frame, "cy/px", 30.0));
  const std::string options = "s.toml --freq 0,0.1,0.4 --angle 30 --unit cy/px";
  EXPECT_EQ(csv_of(apps::table_of(curves)), scratch.run("mtf curve " + options + " --format csv").out);
  const Json json = curve(scratch, options);
  EXPECT_EQ(curves.name, json.at("name"));
  EXPECT_EQ(curves.figures.nyquist, json.at("nyquist").get<double>());
  EXPECT_EQ(curves.figures.cutoff.value(), json.at("cutoff").get<double>());
  EXPECT_EQ(curves.figures.q.value(), json.at("q").get<double>());
  ASSERT_EQ(curves.components.size(), json.at("components").size());
  for (std::size_t i = 0; i < curves.components.size(); ++i) {
    EXPECT_EQ(curves.components[i].label, json.at("components")[i].at("label"));
    EXPECT_EQ(curves.components[i].doc, json.at("components")[i].at("doc"));
  }
  EXPECT_EQ(curves.system.otf[2].im, json.at("system").at("im")[2].get<double>());
}

TEST(Curve, CallRefusesWhatTheCommandRefuses) {
  mtf::System<double> system;
  system.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  EXPECT_THROW(apps::make_direction(system.frame, "cy/mile", 0.0), mtf::UsageError);
  EXPECT_THROW(apps::make_direction(system.frame, "cy/mm", 361.0), mtf::UsageError);
  EXPECT_THROW(apps::otf_curves(system, {2e9}), mtf::UsageError);
  const apps::OtfCurves empty = apps::otf_curves(system, {0.0, 5.0});
  ASSERT_EQ(empty.columns().size(), 2u);  // presample and the system
  EXPECT_EQ(empty.system.otf[1].re, 1.0);
}

TEST(Curve, DirectionsAndNyquistOfPixelsThatAreNotSquare) {
  const Scratch scratch;
  write_file(scratch / "s.toml", kComplexSensor);
  EXPECT_NEAR(curve(scratch, "s.toml --freq 1 --angle 0").at("nyquist").get<double>(), 500.0 / 15.0, 1e-12);
  EXPECT_NEAR(curve(scratch, "s.toml --freq 1 --angle 90").at("nyquist").get<double>(), 50.0, 1e-12);
  EXPECT_NEAR(curve(scratch, "s.toml --freq 1 --angle 90 --unit cy/px").at("nyquist").get<double>(), 0.5, 1e-15);
  // The RC filter acts along x only: nothing of it is left along y, exactly.
  const Json down = curve(scratch, "s.toml --freq 20 --angle -270");
  EXPECT_EQ(component(down, "rc_lowpass").at("re")[0].get<double>(), 1.0);
  EXPECT_EQ(component(down, "rc_lowpass").at("im")[0].get<double>(), 0.0);
  const Json right = curve(scratch, "s.toml --freq 20 --angle 360");
  EXPECT_NEAR(component(right, "rc_lowpass").at("re")[0].get<double>(), 1.0 / (1.0 + 0.25), 1e-12);
  EXPECT_NEAR(component(right, "rc_lowpass").at("im")[0].get<double>(), -0.5 / (1.0 + 0.25), 1e-12);
}

TEST(Curve, CsvHasTheSameNumbers) {
  const Scratch scratch;
  write_file(scratch / "s.toml", kComplexSensor);
  const Json json = curve(scratch, "s.toml --freq 0:40:5");
  const Result result = scratch.run("mtf curve s.toml --freq 0:40:5 --format csv -o c.csv");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.out, "");
  std::istringstream csv(read_file(scratch / "c.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "frequency,diffraction,\"a, \"\"b\"\"\",rc_lowpass_re,rc_lowpass_im,fir,presample,readout_re,readout_im,"
            "postsample,system_re,system_im");
  for (std::size_t i = 0; i < 5; ++i) {
    ASSERT_TRUE(std::getline(csv, line));
    std::istringstream fields(line);
    std::vector<double> values;
    for (std::string field; std::getline(fields, field, ',');) values.push_back(std::stod(field));
    ASSERT_EQ(values.size(), 12U);
    EXPECT_EQ(values[0], json.at("frequency")[i].get<double>());
    EXPECT_EQ(values[4], component(json, "rc_lowpass").at("im")[i].get<double>());
    EXPECT_EQ(values[10], json.at("system").at("re")[i].get<double>());
    EXPECT_EQ(values[11], json.at("system").at("im")[i].get<double>());
  }
  EXPECT_FALSE(std::getline(csv, line));
}

TEST(Curve, BadFrequenciesAndOutputs) {
  const Scratch scratch;
  scratch.add_sensor();
  for (const char* arguments :
       {"--freq 0:60", "--freq 0:60:0", "--freq 0:60:1", "--freq 0:60:1000001", "--freq 0:60:1e3", "--freq 1,,2",
        "--freq ''", "--freq 1e300", "--freq nan", "--freq 0:inf:3", "--unit cy/furlong", "--angle 361", "--angle nan",
        "--plot x.jpg", "--plot ascii --format json", "--plot a.svg -o a.svg.csv", "-o sensor.toml", "-o ''",
        "--format yaml"}) {
    const Result result = scratch.run(std::string("mtf curve sensor.toml ") + arguments);
    EXPECT_EQ(result.status, 2) << arguments;
    EXPECT_EQ(result.out, "") << arguments;
    EXPECT_EQ(lines(result.err), 1U) << arguments << "\n" << result.err;
  }
  EXPECT_EQ(scratch.run("mtf curve sensor.toml -o missing/x.csv").status, 1);
  const auto refused = [&](const std::string& arguments, std::initializer_list<std::string_view> parts) {
    const Result result = scratch.run("mtf curve sensor.toml " + arguments);
    expect_error(result, 2, parts);
    EXPECT_EQ(lines(result.err), 1U) << result.err;
  };
  refused("--plot k.svg -o k.svg", {"k.svg", "two outputs", "its own name"});
  refused("--plot k.svg -o ./k.svg.csv", {"k.svg.csv and ./k.svg.csv", "two outputs", "its own name"});
  // A link to a file that is yet to be written leads to it all the same.
  ASSERT_EQ(scratch.run("ln -s k.svg link.csv").status, 0);
  refused("--plot k.svg -o link.csv", {"two outputs"});
  ASSERT_EQ(scratch.run("rm link.csv").status, 0);
  EXPECT_EQ(scratch.run("ls").out, "sensor.toml\n");
}

}  // namespace
}  // namespace apps_test
