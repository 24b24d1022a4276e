// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "apps/scene/scene_file/scene_file.h"
#include "tests/apps/scene/scene_folder.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps::scene {
namespace {

using namespace test;

/// All errors of the text, a line each: "scene.toml:3:12: error: ...".
std::string errors_of(const SceneFolder& folder, const std::string& text) {
  std::string errors;
  for (const auto& diagnostic : folder.parse(text).diagnostics)
    if (diagnostic.error) errors += mtf::io::format_diagnostic(diagnostic, "scene.toml") + "\n";
  return errors;
}

// The air is checked whether or not the sky is made of it: render sees through it.
TEST(SceneErrors, OfTheAirWhateverTheSkyIs) {
  const SceneFolder folder;
  const auto with_air = [&](const std::string& air) {
    return errors_of(folder, scene_text() + "[atmosphere]\n" + air);
  };
  EXPECT_EQ(with_air("model = \"mid_latitude_winter\"\n"), "");
  expect_says(with_air("model = \"tropical\"\nrange = \"2 km\"\n"), {"error: atmosphere:", "the air alone"});
  expect_says(with_air("model = \"tropical\"\nvisibility = \"2 km\"\n"), {"error: atmosphere.visibility: needs haze"});
  expect_says(with_air("profile = \"none.csv\"\n"), {"error: atmosphere.profile: "});
  expect_says(with_air("haze = \"rural\"\n"), {"nothing of the air"});
}

// Of a blackbody at 300 K 1.28 % lies from 3 to 5 um (0.01285 - 0.00009, Howell's table of the fraction below lambda T
// at 1500 and 900 um K), and 52 % from 3 to 14 um.
TEST(SceneErrors, EmissivitiesThatEndWhereTheSurfaceRadiatesAreSaid) {
  const SceneFolder folder;
  folder.write("short.csv", "wavelength_um,emissivity\n3,0.1\n5,0.2\n");
  const auto said = [&](const std::string& table) {
    std::string all;
    for (const auto& found : folder.parse(replaced(scene_text(), "paint.csv", table)).diagnostics) all += found.text;
    return all;
  };
  expect_says(said("short.csv"), {"beyond the table", "98.7 %", "3 um to 5 um"});
  EXPECT_FALSE(says(said("paint.csv"), "beyond the table"));
}

struct Fault {
  const char* from;
  const char* to;
  std::vector<std::string_view> says{};  ///< place and remedy
};

TEST(SceneErrors, EachHasItsPlaceAndItsRemedy) {
  const SceneFolder folder;
  for (const Fault& fault : {
           Fault{"schema = 1", "schema = 2", {"scene.toml:1:10", "schema", "schema = 1"}},
           Fault{"schema = 1\n", "", {"schema", "missing", "schema = 1"}},
           Fault{"[place]", "[plase]", {"scene.toml:2:2", "plase", "\"place\""}},
           Fault{"\"37.70 deg\"",
                 "37.70",
                 {"scene.toml:3:12", "place.latitude", "37.7 has no unit", "such as \"37.70 deg\""}},
           Fault{"37.70 deg", "97.70 deg", {"scene.toml:3:12", "place.latitude", "97.7 deg", "[-90, 90] deg"}},
           Fault{"37.70 deg", "37.70 m", {"\"m\"", "\"37.70 deg\""}},
           Fault{"longitude = \"-105.92 deg\"\n", "", {"place.longitude", "missing", "longitude = \"-105.92 deg\""}},
           Fault{"altitude", "altitud", {"\"altitude\""}},
           Fault{"2016-01-01T00:00:00Z", "2016-01-01T00:00:00", {"scene.toml:8:9", "time.start", "time zone"}},
           Fault{"2016-01-01T00:00:00Z", "2016-01-01", {"without a time"}},
           Fault{"2016-01-01T00:00:00Z", "5", {"date and time"}},
           Fault{"2016-01-03T00:00:00Z", "2016-01-01T00:00:00Z", {"scene.toml:9:7", "time.end", "not after"}},
           Fault{"2016-01-03T00:00:00Z", "2316-01-01T00:00:00Z", {"1900 to 2100"}},
           Fault{"\"10 min\"", "\"7 min\"", {"scene.toml:10:8", "time.step", "divisor"}},
           Fault{"\"10 min\"", "\"0.1 s\"", {"million"}},
           Fault{"\"10 min\"", "\"10 mins\"", {"unknown unit \"mins\""}},
           Fault{"\"10 min\"", "\"-10 min\"", {"is outside"}},
           Fault{"file = \"weather.csv\"", "fil = \"weather.csv\"", {"\"file\""}},
           Fault{"file = \"weather.csv\"",
                 "file = \"weather.csv\"\nwind_speed = \"3 m/s\"",
                 {"scene.toml:13:14", "weather.wind_speed", "file"}},
           Fault{"file = \"weather.csv\"", "", {"weather.file", "missing"}},
           Fault{"file = \"weather.csv\"", "air_temperature = \"95 degC\"", {"368.15 K, is outside"}},
           Fault{"file = \"weather.csv\"", "direct_normal = \"1600 W/m2\"", {"1600 W/m2 is outside [0, 1500] W/m2"}},
           Fault{"file = \"weather.csv\"", "relative_humidity = 0.5", {"needs air_temperature"}},
           Fault{"file = \"weather.csv\"",
                 "global_horizontal = \"600 W/m2\"\ndirect_normal = \"500 W/m2\"",
                 {"weather.global_horizontal", "the sun moves", "give direct_normal and diffuse_horizontal"}},
           Fault{"\"instant\"",
                 "\"instnat\"",
                 {"scene.toml:13:9", "weather.stamp", "unknown word \"instnat\"", "\"instant\""}},
           Fault{"\"none\"", "\"week\"", {"unknown word \"week\""}},
           Fault{"\"measured\"", "\"measure\"", {"\"measured\""}},
           Fault{"\"from_longwave\"", "1.5", {"sky.cloud", "1.5 is outside [0, 1]"}},
           Fault{"name = \"armour\"\n", "", {"material[0].name", "missing"}},
           Fault{"name = \"soil\"", "name = \"armour\"", {"material[1].name", "twice"}},
           Fault{"solar_absorptance = 0.7",
                 "solar_absorptance = 1.7",
                 {"scene.toml:20:21", "material[0].solar_absorptance", "1.7 is outside [0, 1]"}},
           Fault{"solar_absorptance = 0.7\n", "", {"material[0].solar_absorptance", "missing"}},
           Fault{"\"paint.csv\"", "\"pain.csv\"", {"scene.toml:21:14", "material[0].emissivity", "cannot read"}},
           Fault{"\"paint.csv\"", "\"0.9\"", {"without quotes"}},
           Fault{"\"paint.csv\"", "-0.1", {"is outside [0, 1]"}},
           Fault{"emissivity = \"paint.csv\"\n", "", {"material[0].emissivity", "missing"}},
           Fault{"\"mcadams\"", "\"mcadam\"", {"\"mcadams\""}},
           Fault{"\"mcadams\"", "5.7", {"or a table"}},
           Fault{"h1 = \"3.8 W/m2/K/(m/s)\"", "h2 = \"3.8 W/m2/K/(m/s)\"", {"convection of [[material]] soil"}},
           Fault{"\"3.8 W/m2/K/(m/s)\"", "\"3.8 W/m2/K\"", {"does not fit"}},
           Fault{"45 W/m/K",
                 "-45 W/m/K",
                 {"material[0].layers[0].conductivity", "-45 W/m/K is outside (0, 10000] W/m/K"}},
           Fault{"7800 kg/m3",
                 "0 kg/m3",
                 {"scene.toml:23:50", "material[0].layers[0].density", "0 kg/m3 is outside (0,"}},
           Fault{"\"20 mm\"", "\"-20 mm\"", {"thickness", "-0.02 m", "(0, 100] m"}},
           Fault{"thickness = \"20 mm\"", "thicknes = \"20 mm\"", {"\"thickness\""}},
           Fault{"layers = [{ conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", "
                 "thickness = \"20 mm\" }]\n",
                 "",
                 {"material[0].layers", "missing", "layers = [{ conductivity"}},
           Fault{"layers = [{ conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", "
                 "thickness = \"20 mm\" }]",
                 "layers = []",
                 {"at least one"}},
           Fault{"kind = \"film\"", "kind = \"flim\"", {"\"film\""}},
           Fault{"kind = \"film\"", "kind = \"fixed\"", {"material[0].inside.h", "inside of [[material]] armour"}},
           Fault{"kind = \"film\", ", "", {"material[0].inside.kind", "missing"}},
           Fault{"\"engine.csv\"",
                 "\"engin.csv\"",
                 {"scene.toml:24:58", "material[0].inside.temperature", "cannot read"}},
           Fault{"\"engine.csv\"", "\"heater.csv\"", {"heater.csv:1", "flux"}},
           Fault{"\"engine.csv\"", "\"-300 degC\"", {"-26.85 K", "(0, 3000] K"}},
           Fault{"name = \"terrain\"", "name = \"vehicle\"", {"mesh[1].name", "twice"}},
           Fault{"file = \"vehicle.obj\"\n", "", {"mesh[0].file", "missing"}},
           Fault{"\"1 mm\"", "\"1 kg\"", {"does not fit"}},
           Fault{"\"1 mm\"", "1", {"1 has no unit", "\"1 mm\""}},
           Fault{"material = \"armour\"", "material = \"armor\"", {"no material \"armor\"", "\"armour\""}},
           Fault{"mesh = \"terrain\"", "mesh = \"terain\"", {"no mesh \"terain\"", "\"terrain\""}},
           Fault{"mesh_material = \"cloth\"", "group = \"power_top\"", {"same faces"}},
           Fault{"group = \"others\"", "group = \"tent\"", {"region \"tent\""}},
           Fault{"temperature = \"30 degC\"", "", {"[[material]], or temperature"}},
           Fault{"temperature = \"30 degC\"", "temperature = \"30\"", {"no unit"}},
           Fault{"[ground]\nmaterial = \"soil\"", "[ground]\nmaterial = \"sand\"", {"no material \"sand\""}},
           Fault{"[\"14 m\", \"-12 m\", \"5 m\"]", "[\"14 m\", \"-12 m\"]", {"camera.position", "three lengths"}},
           Fault{"[\"14 m\", \"-12 m\", \"5 m\"]", "[14, \"-12 m\", \"5 m\"]", {"14 has no unit", "\"14 m\""}},
           Fault{"[\"14 m\", \"-12 m\", \"5 m\"]", "[\"0 m\", \"0 m\", \"1.2 m\"]", {"own position"}},
           Fault{"[camera]", "[[camera]]", {"a table belongs"}},
           Fault{"[[mesh]]", "[mesh]", {"not valid TOML"}},
       }) {
    const std::string text = replaced(scene_text(), fault.from, fault.to);
    ASSERT_FALSE(text.empty()) << fault.from << " is not in the scene";
    const std::string errors = errors_of(folder, text);
    SCOPED_TRACE(std::string(fault.from) + " -> " + fault.to);
    for (const auto part : fault.says) expect_says(errors, {part});
  }
}

TEST(SceneErrors, OneFaultIsOneError) {
  const SceneFolder folder;
  for (const Fault& fault :
       {Fault{"latitude", "lattitude"}, Fault{"\"10 min\"", "\"10 mins\""},
        Fault{"emissivity = \"paint.csv\"", "emisivity = \"paint.csv\""},
        Fault{"thickness = \"20 mm\"", "thicknes = \"20 mm\""}, Fault{"[weather]", "[wether]"},
        Fault{"name = \"canvas\"", "nam = \"canvas\""}, Fault{"material = \"armour\"", "materal = \"armour\""}}) {
    const std::string errors = errors_of(folder, replaced(scene_text(), fault.from, fault.to));
    EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << errors;
  }
}

TEST(SceneErrors, AllOfAFileAtOnceInItsOrder) {
  const SceneFolder folder;
  std::string text = scene_text();
  for (const auto& [from, to] :
       {std::pair{"37.70 deg", "137.70 deg"}, std::pair{"7800 kg/m3", "0 kg/m3"}, std::pair{"\"1 mm\"", "\"1 kg\""},
        std::pair{"\"armour\"\n[[region]]", "\"armor\"\n[[region]]"}, std::pair{"120 cm", "120"}})
    text = replaced(text, from, to);
  const SceneResult result = folder.parse(text);
  ASSERT_EQ(result.diagnostics.size(), 5u);
  EXPECT_FALSE(result.ok());
  for (std::size_t i = 1; i < 5; ++i)
    EXPECT_GT(result.diagnostics[i].position.line, result.diagnostics[i - 1].position.line);
  folder.write("scene.toml", text);
  const std::string thrown = message_of([&] { load_scene(folder.file("scene.toml")); });
  EXPECT_EQ(std::count(thrown.begin(), thrown.end(), '\n'), 4);
  expect_says(thrown, {folder.file("scene.toml") + ":3:12: error: place.latitude"});
  EXPECT_FALSE(folder.parse("").ok());
  folder.write("scene.toml", "schema = 1\n[frame]\npitch = \"15 um\"\n");
  expect_refused({folder.file("scene.toml"), "a sensor file", "[frame]", "a 3-D scene belongs"},
                 [&] { load_scene(folder.file("scene.toml")); });
}

TEST(SceneErrors, DamagedFilesEndInErrorsOrValues) {
  const SceneFolder folder;
  const std::string good = scene_text();
  std::uint64_t state = 99;
  const auto random = [&](std::size_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>(state >> 33) % below;
  };
  int refused = 0;
  for (int round = 0; round < 1500; ++round) {
    std::string text = good;
    if (round % 3 == 0) text[random(text.size())] = static_cast<char>(random(256));
    if (round % 3 == 1) {  // a stretch is lost
      const std::size_t at = random(text.size());
      text.erase(at, random(40));
    }
    if (round % 3 == 2) {  // two lines change places
      const std::size_t a = text.find('\n', random(text.size() / 2)) + 1, b = text.find('\n', a + random(400)) + 1;
      const std::string first = text.substr(a, text.find('\n', a) + 1 - a),
                        second = text.substr(b, text.find('\n', b) + 1 - b);
      text.replace(b, second.size(), first);
      text.replace(a, first.size(), second);
    }
    const SceneResult result = folder.parse(text);
    if (result.ok())
      EXPECT_EQ(result.scene.text, text);
    else
      ++refused;
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace apps::scene
