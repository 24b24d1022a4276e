// SPDX-License-Identifier: Apache-2.0

// [atmosphere] of a sensor file and `mtf atmosphere`: the same air by several routes gives the same numbers. The model
// itself is tested in tests/radiometry/atmosphere.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "radiometry/light/blackbody.h"
#include "tests/apps/chain_sensor.h"
#include "tests/expect_error.h"

namespace apps_test {
namespace {

using Columns = std::vector<std::vector<double>>;

/// Columns of numbers below a header; an empty field is NaN.
Columns columns_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  Columns columns;
  while (std::getline(lines, line)) {
    if (line.empty() || line.front() == '#' || std::isalpha(static_cast<unsigned char>(line.front())) != 0) continue;
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t c = 0; std::getline(cells, cell, ','); ++c) {
      if (columns.size() <= c) columns.emplace_back();
      columns[c].push_back(cell.empty() ? std::nan("") : std::stod(cell));
    }
  }
  return columns;
}

const std::string kAir =
    "[atmosphere]\nmodel = \"mid_latitude_summer\"\nhaze = \"rural\"\nvisibility = \"10 km\"\nrange = \"2 km\"\n";

class AtmosphereCommand : public ChainSensor {};

TEST_F(AtmosphereCommand, components_multiply_to_the_transmittance_and_one_layer_emits_what_it_takes) {
  const Result r = scratch.run(
      "mtf atmosphere --model tropical --haze maritime --visibility '23 km' --rain '2 mm/h' --range '3 km' --format "
      "csv --quiet");
  ASSERT_EQ(r.status, 0) << r.err;
  const Columns c = columns_of(r.out);
  ASSERT_EQ(c.size(), 18U);
  for (std::size_t i = 0; i < c[0].size(); ++i) {
    EXPECT_NEAR(c[1][i] * c[0][i], 1e4, 1e-9);
    double product = 1.0;
    for (std::size_t k = 4; k < c.size(); ++k) product *= c[k][i];
    EXPECT_NEAR(product, c[2][i], 1e-12);
    if (c[0][i] > 3500.0) continue;
    // The tropical model has 299.7 K at the ground. W m^-2 sr^-1 um^-1 x lambda^2 / 1e4 is per cm^-1.
    const double planck = radiometry::planck(radiometry::Flux::watts, c[1][i], 299.7) * c[1][i] * c[1][i] * 1e-4;
    EXPECT_NEAR(c[3][i], planck * (1.0 - c[2][i]), 1e-7 * planck) << c[0][i];
  }
}

TEST_F(AtmosphereCommand, band_averages_are_those_of_the_spectrum) {
  const std::string air = "mtf atmosphere --model us_standard_1976 --range '5 km' --bands 8:12 ";
  const Columns c = columns_of(scratch.run(air + "--format csv --quiet").out);
  const Json json = Json::parse(scratch.run(air + "--format json --quiet").out);
  // By trapezia over the wavenumber, of steps that the response of a flat band does not see.
  double clear = 0.0, left = 0.0, added = 0.0;
  for (std::size_t i = 0; i + 1 < c[0].size(); ++i) {
    const double nu = 0.5 * (c[0][i] + c[0][i + 1]), step = c[0][i + 1] - c[0][i], um = 1e4 / nu;
    if (um < 8.0 || um > 12.0) continue;
    const double light = radiometry::planck(radiometry::Flux::watts, um, 300.0) * um * um * 1e-4 * step;
    clear += light;
    left += light * 0.5 * (c[2][i] + c[2][i + 1]);
    added += step * 0.5 * (c[3][i] + c[3][i + 1]);
  }
  const Json band = json["bands"][0];
  EXPECT_NEAR(band["transmission"].get<double>(), left / clear, 2e-3);
  EXPECT_NEAR(band["path_radiance"].get<double>(), added, 0.01 * added);  // the ends of the band fall within steps
  EXPECT_EQ(json["wavenumber_cm-1"].size(), c[0].size());
}

TEST_F(AtmosphereCommand, a_sensor_sees_the_same_air_by_its_table_by_a_path_table_and_by_a_tape7) {
  sensor(kAir);
  const Json direct = budget();
  ASSERT_EQ(scratch.run("mtf atmosphere s.toml --table path.csv --ranges 1000,2000 --tape7 air.tp7").status, 0);
  sensor("[path]\ntable = \"path.csv\"\nrange = \"2 km\"\n");
  const Json by_table = budget();
  sensor("[path]\ntable = \"air.tp7\"\nrange = \"2 km\"\n");
  const Json by_tape7 = budget();
  for (const char* term : {"scene", "path", "netd"}) {
    const double value = direct[term]["value"];
    EXPECT_NEAR(by_table[term]["value"].get<double>(), value, 1e-9 * value) << term;
    EXPECT_NEAR(by_tape7[term]["value"].get<double>(), value, 1e-4 * value) << term;  // five digits of a radiance
  }
  sensor("");
  EXPECT_LT(direct["scene"]["value"].get<double>(), budget()["scene"]["value"].get<double>());
}

TEST_F(AtmosphereCommand, options_take_the_place_of_keys) {
  sensor(kAir);
  const auto transmission = [&](const std::string& more) {
    const Result r = scratch.run("mtf atmosphere s.toml --format json " + more);
    EXPECT_EQ(r.status, 0) << r.err;
    return Json::parse(r.out)["bands"][0]["transmission"].get<double>();
  };
  const double given = transmission("");
  EXPECT_EQ(transmission("--range '2 km'"), given);
  EXPECT_LT(transmission("--range 5km"), given);
  EXPECT_GT(transmission("--visibility '50 km'"), given);
  EXPECT_LT(transmission("--relative-humidity 0.99"), given);
  EXPECT_EQ(Json::parse(scratch.run("mtf atmosphere s.toml --format json").out)["bands"][0]["path_radiance_unit"],
            "ph s^-1 m^-2 sr^-1");
}

// Each pixel has its own range: an image of two ranges is made of the images of each.
TEST_F(AtmosphereCommand, ranges_of_pixels) {
  Image planes(64, 48), depth(64, 48);
  for (std::int64_t y = 0; y < 48; ++y)
    for (std::int64_t x = 0; x < 64; ++x) {
      planes.at(x, y) = 310.0F;
      depth.at(x, y) = x < 32 ? 500.0F : 4000.0F;
    }
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = "temperature";
  mtf::io::write_exr((scratch / "two.exr").string(), {{"Y", planes.view()}, {"Z", depth.view()}}, metadata);
  write_flat(scratch / "one.exr", 310.0F);
  const auto value = [&](const std::string& air, const std::string& scene, std::int64_t x) {
    sensor(air, "[scene]", scene == "two.exr" ? "[scene]\ndepth_channel = \"Z\"" : "[scene]");
    // The tail of the diffraction would carry half a percent of the step between the halves this far.
    std::string text = read_file(scratch / "s.toml");
    const std::string diffraction = "[[presample]]\nkind = \"diffraction\"\n";
    write_file(scratch / "s.toml", text.erase(text.find(diffraction), diffraction.size()));
    const Result r =
        scratch.run("mtf simulate s.toml " + scene + " --channel Y -o out.exr --stage electrons --report r.json");
    EXPECT_EQ(r.status, 0) << r.err;
    const float found = read(scratch / "out.exr").at(x, 12);
    fs::remove(scratch / "out.exr");
    return static_cast<double>(found);
  };
  const std::string air = kAir.substr(0, kAir.find("range"));
  const double near = value(air + "range = \"500 m\"\n", "one.exr", 8),
               far = value(air + "range = \"4 km\"\n", "one.exr", 8);
  EXPECT_LT(far, near);
  const double tolerance = 2e-5 * near;  // kTableError of apps/sensor/sensor_air.cpp, of transmission and of emission
  EXPECT_NEAR(value(air, "two.exr", 4), near, tolerance);
  EXPECT_NEAR(value(air, "two.exr", 28), far, tolerance);
  // The table's error is in the promise.
  const Json report = Json::parse(read_file(scratch / "r.json"));
  EXPECT_GT(report["plan"]["predicted_parts"]["arithmetic"].get<double>(), 1e-6);
}

// An image whose pixels have one range is that of a sensor file with this range: surfaces of all temperatures with the
// spectrum of each, and the OTF of the band behind this air. In the second image ranges differ, and it is said by how
// much the OTF does.
TEST_F(AtmosphereCommand, one_range_for_all_pixels_is_that_of_the_file) {
  Image planes(64, 48), depth(64, 48);
  for (std::int64_t y = 0; y < 48; ++y)
    for (std::int64_t x = 0; x < 64; ++x) {
      planes.at(x, y) = 280.0F + 60.0F * (((x / 3) + (y / 5)) % 2 == 0 ? 1.0F : 0.0F);
      depth.at(x, y) = 4000.0F;
    }
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = "temperature";
  mtf::io::write_exr((scratch / "deep.exr").string(), {{"Y", planes.view()}, {"Z", depth.view()}}, metadata);
  const std::string air = kAir.substr(0, kAir.find("range"));
  const auto image = [&](const std::string& range, const std::string& scene) {
    sensor(air + range, "[scene]", scene);
    const Result r =
        scratch.run("mtf simulate s.toml deep.exr --channel Y -o out.exr --stage electrons --tolerance 3e-4");
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_FALSE(says(r.err, "scene.depth_channel")) << r.err;
    Image found = read(scratch / "out.exr");
    fs::remove(scratch / "out.exr");
    return found;
  };
  const Image by_file = image("range = \"4 km\"\n", "[scene]"), by_pixel = image("", "[scene]\ndepth_channel = \"Z\"");
  double most = 0.0, least = 1e300, worst = 0.0;
  for (std::int64_t i = 0; i < by_file.size(); ++i) {
    const double value = static_cast<double>(by_file.data()[i]);
    most = std::max(most, value), least = std::min(least, value);
    worst = std::max(worst, std::abs(value - static_cast<double>(by_pixel.data()[i])));
  }
  EXPECT_LT(worst, 2e-3 * (most - least));  // both plans may err by 3e-4 rms; the air of the file's OTF alone is 1e-2
  depth.at(0, 0) = 20.0F;
  mtf::io::write_exr((scratch / "deep.exr").string(), {{"Y", planes.view()}, {"Z", depth.view()}}, metadata);
  const Result said = scratch.run("mtf simulate s.toml deep.exr --channel Y -o out.exr --stage electrons");
  expect_says(said.err, {"by up to 0.0"});
  fs::remove(scratch / "out.exr");
  depth.at(5, 7) = 0.0F;
  mtf::io::write_exr((scratch / "deep.exr").string(), {{"Y", planes.view()}, {"Z", depth.view()}}, metadata);
  expect_refused("mtf simulate s.toml deep.exr --channel Y -o none.exr",
                 {"scene.depth_channel", "1 pixel", "column 5, row 7"});
}

// The aerosol of the path as a component: what haze scatters is a loss of contrast there, and none of light.
TEST_F(AtmosphereCommand, an_aerosol_component_takes_what_haze_scatters) {
  const std::string aerosol = "[[presample]]\nkind = \"aerosol\"\n";
  sensor(kAir);
  const Json lost = budget();
  sensor(kAir + aerosol);
  const Json kept = budget();
  EXPECT_GT(kept["scene"]["value"].get<double>(), lost["scene"]["value"].get<double>());
  const Result curve = scratch.run("mtf curve s.toml --freq 0,10 --format json");
  ASSERT_EQ(curve.status, 0) << curve.err;
  EXPECT_FALSE(says(curve.err, "twice")) << curve.err;
  double contrast = 0.0;
  const Json curves = Json::parse(curve.out);
  for (const Json& component : curves["components"])
    if (component["kind"] == "aerosol") contrast = component["re"][1];
  EXPECT_LT(contrast, 0.99);
  // What it takes from the contrast is about what the transmission lost before: both are exp(-scattering) of a band.
  EXPECT_NEAR(contrast, lost["scene"]["value"].get<double>() / kept["scene"]["value"].get<double>(), 0.01);
  sensor(kAir + aerosol + "scattering = 0.1\n");
  expect_says(scratch.run("mtf config check s.toml").out, {"count scattered light twice"});
  sensor(aerosol);
  expect_refused("mtf budget s.toml", {"scattering", "missing", "[atmosphere]"});
  sensor("[atmosphere]\nmodel = \"tropical\"\nrange = \"2 km\"\n" + aerosol);
  expect_refused("mtf budget s.toml", {"scattering", "with haze"});
}

TEST_F(AtmosphereCommand, the_air_of_a_scene_begins_at_its_place) {
  ASSERT_EQ(scratch.run("mtf scene demo -o demo").status, 0);
  const std::string text = read_file(scratch / "demo/scene.toml");
  const auto from = text.find("[atmosphere]"), to = text.find("# Rolled armour");
  write_file(scratch / "demo/none.toml", text.substr(0, from) + text.substr(to));
  expect_refused("mtf atmosphere demo/none.toml --sky", {"has no [atmosphere]"});
  const Json sky = Json::parse(scratch.run("mtf atmosphere demo/scene.toml --sky --format json --quiet").out);
  EXPECT_GT(sky["altitude_m"].get<double>(), 0.0);
  const Json line = Json::parse(scratch.run("mtf atmosphere demo/scene.toml --range '1 km' --format json --quiet").out);
  EXPECT_EQ(line["line"]["target_altitude_m"], sky["altitude_m"]);
}

TEST_F(AtmosphereCommand, clouds_of_the_sky) {
  const std::string sky = "mtf atmosphere --model mid_latitude_summer --sky --format json --quiet ";
  const Json clear = Json::parse(scratch.run(sky).out);
  const Json half = Json::parse(scratch.run(sky + "--cloud-cover 0.5 --cloud-temperature '285 K'").out);
  const Json over = Json::parse(scratch.run(sky + "--cloud-cover 1 --cloud-temperature '285 K'").out);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](const Json& json) { return json["bands"][2]["radiance_W_m-2_sr-1"][i].get<double>(); };
    EXPECT_NEAR(at(half), 0.5 * (at(clear) + at(over)), 1e-9 * at(over));
    EXPECT_NEAR(at(over), radiometry::band_radiance(radiometry::Flux::watts, 8.0, 12.0, 285.0), 1e-5 * at(over));
  }
  const std::string flux = std::to_string(half["longwave_w_m2"].get<double>());
  const Json by_flux = Json::parse(scratch.run(sky + "--longwave " + flux + " --cloud-temperature '285 K'").out);
  EXPECT_NEAR(by_flux["cloud_cover"].get<double>(), 0.5, 1e-6);
  expect_refused("mtf atmosphere --model tropical --sky --cloud-cover 0.5", {"--cloud-temperature"});
  expect_refused("mtf atmosphere --model tropical --sky --cloud-cover 1.5 --cloud-temperature '280 K'",
                 {"from 0 to 1"});
  expect_refused("mtf atmosphere --model tropical --range '1 km' --cloud-cover 0.5 --cloud-temperature '280 K'",
                 {"--sky"});
}

TEST_F(AtmosphereCommand, refusals_name_place_and_remedy) {
  const auto refused = [&](const std::string& air, std::initializer_list<std::string_view> parts) {
    sensor(air);
    for (const char* command :
         {"mtf budget s.toml", "mtf config check s.toml", "mtf simulate s.toml t300.exr -o out.exr"})
      expect_refused(command, parts);
  };
  refused("[atmosphere]\nrange = \"2 km\"\n", {"s.toml:25:2: error: [atmosphere]", "nothing of the air"});
  refused("[atmosphere]\nmodel = \"tropical\"\n", {"no line of sight"});
  refused("[atmosphere]\nmodel = \"tropic\"\nrange = \"2 km\"\n", {"s.toml:26:", "tropical"});
  refused(kAir + "[path]\ntransmission = 0.8\n", {"[atmosphere]", "count twice"});
  refused("[atmosphere]\nmodel = \"tropical\"\nrange = \"2 km\"\nvisibility = \"5 km\"\n",
          {"s.toml:28:1: error: atmosphere.visibility", "needs haze"});
  refused("[atmosphere]\nmodel = \"tropical\"\nrange = \"2 km\"\nrelative_humidity = 55\n", {"s.toml:28:", "[0, 1]"});
  refused("[atmosphere]\nmodel = \"tropical\"\nrange = \"2 km\"\npressure = \"1013 hPa\"\n",
          {"atmosphere.pressure", "given together with model"});
  refused("[atmosphere]\npressure = \"1013 hPa\"\nrange = \"2 km\"\n", {"needs temperature and relative_humidity"});
  refused("[atmosphere]\nmodel = \"tropical\"\ntarget_altitude = \"0 m\"\n", {"needs range or zenith_angle"});
  refused("[atmosphere]\nmodel = \"tropical\"\ntarget_altitude = \"0 m\"\nzenith_angle = \"90 deg\"\n",
          {"atmosphere.target_altitude", "the same as sensor_altitude"});
  write_file(scratch / "one.csv", "altitude_m,pressure_pa,temperature_k,relative_humidity\n100,100000,288,.5\n");
  refused("[atmosphere]\nprofile = \"one.csv\"\nsensor_altitude = \"3 km\"\nrange = \"2 km\"\n",
          {"atmosphere.profile", "one level, at 100"});
  sensor("[atmosphere]\nprofile = \"none.csv\"\nrange = \"2 km\"\n");
  expect_refused("mtf budget s.toml", {"s.toml:26:1: error: atmosphere.profile", "none.csv"}, 1);
  write_file(scratch / "p.csv", "altitude_m,pressure_pa,temperature_k,relative_humidity\n0,1013,288,.5\n");
  refused("[atmosphere]\nprofile = \"p.csv\"\nrange = \"2 km\"\n", {"p.csv:2:", "1013 Pa at 0"});
  expect_refused("mtf atmosphere", {"nothing of the air"});
  expect_refused("mtf atmosphere --model tropical --range 2", {"--range", "no unit"});
  expect_refused("mtf atmosphere --model tropical --range '2 km' --bands 5:3", {"--bands"});
  expect_refused("mtf atmosphere --model tropical --range '2 km' --bands 14:20", {"um"});
  expect_refused("mtf atmosphere --model tropical --range '2 km' --bands 1:5 --tape7 a.tp7", {"--tape7", "2.857 um"});
  EXPECT_FALSE(fs::exists(scratch / "a.tp7"));
  expect_refused("mtf atmosphere s.toml --tape7 s.toml", {"s.toml"});
}

TEST_F(AtmosphereCommand, limits_of_the_model_are_warnings) {
  expect_says(scratch.run("mtf atmosphere --model tropical --range '2 km' --bands 0.5:0.9").err, {"warning: "});
  expect_says(scratch.run("mtf atmosphere --model tropical --range '2 km' --bands 10:10.01").err, {"20 cm^-1"});
  EXPECT_EQ(scratch.run("mtf atmosphere --model tropical --range '2 km' --bands 8:12").err, "");
  expect_says(scratch
                  .run("mtf atmosphere --pressure '1013 hPa' --temperature '60 degC' --relative-humidity 0.2 --range "
                       "'2 km' --bands 8:12")
                  .err,
              {"333.2 K", "at 0 m"});
}

TEST_F(AtmosphereCommand, the_sky_is_colder_upwards) {
  const Json sky = Json::parse(scratch.run("mtf atmosphere --model mid_latitude_summer --sky --format json").out);
  const std::vector<double> radiance = sky["radiance_W_m-2_sr-1"];
  EXPECT_TRUE(std::is_sorted(radiance.begin(), radiance.end()));
  EXPECT_GT(sky["longwave_w_m2"].get<double>(), 300.0);  // 294 K at the ground
  EXPECT_LT(sky["longwave_w_m2"].get<double>(), 420.0);
}

}  // namespace
}  // namespace apps_test
