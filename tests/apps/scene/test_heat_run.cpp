// SPDX-License-Identifier: Apache-2.0

// Scenes from file to temperatures: closed forms, exchange, shadows, and what is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "apps/scene/heat/heat_run.h"
#include "radiometry/light/constants.h"
#include "tests/apps/scene/weather_texts.h"
#include "tests/apps/study/temp_folder.h"

namespace apps::scene {
namespace {

constexpr double kSigma = radiometry::kStefanBoltzmann_w_m2_k4;

/// A level plate of 1 m, facing up at a height of `z`.
std::string plate(double z, int first = 1, const std::string& group = "plate") {
  std::string text = "g " + group + "\n";
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}})
    text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
  text += "f";
  for (int i = 0; i < 4; ++i) text += " " + std::to_string(first + i);
  return text + "\n";
}

const std::string kSky = "[sky]\nlongwave = \"measured\"\n";
const std::string kDay = "[time]\nstart = 2016-03-20T00:00:00Z\nend = 2016-03-21T00:00:00Z\nstep = \"1 h\"\n";

std::string weather(double air_k, double wind, double direct, double diffuse, double longwave) {
  return "[weather]\nair_temperature = \"" + std::to_string(air_k) + " K\"\nwind_speed = \"" + std::to_string(wind) +
         " m/s\"\ndirect_normal = \"" + std::to_string(direct) + " W/m2\"\ndiffuse_horizontal = \"" +
         std::to_string(diffuse) + " W/m2\"\nlongwave_down = \"" + std::to_string(longwave) + " W/m2\"\n";
}

std::string material(const std::string& name, double absorptance, double emissivity, const std::string& convection,
                     const std::string& rest = "") {
  return "[[material]]\nname = \"" + name + "\"\nsolar_absorptance = " + std::to_string(absorptance) +
         "\nemissivity = " + std::to_string(emissivity) + "\nconvection = " + convection +
         "\nlayers = [{ conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", "
         "thickness = \"5 mm\" }]\n" +
         rest;
}

struct Outcome {
  HeatReport report;
  std::vector<double> times_s;
  std::vector<std::vector<double>> front, back;  ///< [output][facet]
};

class HeatRun : public testing::Test {
 protected:
  HeatScene prepare(const std::string& text, const std::string& obj, const HeatOptions& options = {}) {
    std::ofstream(folder_ / "plates.obj") << obj;
    std::ofstream(folder_ / "scene.toml") << "schema = 1\n[place]\nlatitude = \"0 deg\"\nlongitude = \"0 deg\"\n"
                                             "altitude = \"0 m\"\n"
                                          << text;
    return prepare_heat(load_scene((folder_ / "scene.toml").string()), options);
  }

  Outcome run(const std::string& text, const std::string& obj, const HeatOptions& options = {}) {
    const HeatScene scene = prepare(text, obj, options);
    Outcome outcome;
    outcome.report = run_heat(
        scene, options,
        [&](const HeatOutput& output) {
          outcome.times_s.push_back(output.time_s);
          outcome.front.emplace_back(output.front_k.begin(), output.front_k.end());
          outcome.back.emplace_back(output.back_k.begin(), output.back_k.end());
        },
        [](const std::string&, double) {});
    return outcome;
  }

  study_test::TempFolder folder_;
};

std::string region(const std::string& group, const std::string& rest) {
  return "[[region]]\nmesh = \"plates\"\n" + (group.empty() ? "" : "group = \"" + group + "\"\n") + rest + "\n";
}
const std::string kMesh = "[[mesh]]\nname = \"plates\"\nfile = \"plates.obj\"\nunit = \"1 m\"\n";

/// eps L + a D = eps sigma T^4 + h (T - air), by bisection.
double equilibrium(double absorbed, double emissivity, double h, double air_k) {
  double low = 1.0, high = 1000.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (absorbed > emissivity * kSigma * std::pow(middle, 4) + h * (middle - air_k) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Values of DESIGN's study, to 30 digits: absorbed 0.7 x 900 + 0.9 x 300 W/m2, h = 10 W/m2/K, air of 293.15 K.
TEST_F(HeatRun, ASteadySceneHasItsClosedForm) {
  const Outcome outcome = run(kDay + weather(293.15, 1.0, 0.0, 900.0, 300.0) + kSky +
                                  material("paint", 0.7, 0.9, "{ h0 = \"10 W/m2/K\", h1 = \"0 J/m3/K\" }") + kMesh +
                                  region("", "material = \"paint\""),
                              plate(1.0), {.tolerance_k = 1e-3});
  ASSERT_EQ(outcome.front.size(), 25U);
  for (const auto& facets : outcome.front) EXPECT_NEAR(facets[0], 325.712777538, 1e-3);
  EXPECT_LE(outcome.report.promised.total_k(), 1e-3);
}

TEST_F(HeatRun, ASceneOfOneTemperatureKeepsIt) {
  const double longwave = kSigma * std::pow(290.0, 4);
  std::string obj = plate(0.5, 1, "lower") + plate(1.0, 5, "upper");
  const Outcome outcome = run(kDay + weather(290.0, 2.0, 0.0, 0.0, longwave) + kSky +
                                  material("steel", 0.7, 0.8, "\"mcadams\"", "inside = { kind = \"sheet\" }\n") +
                                  kMesh + region("", "material = \"steel\""),
                              obj);
  for (const auto& facets : outcome.front)
    for (const double kelvin : facets) EXPECT_NEAR(kelvin, 290.0, 1e-6);
  for (const auto& facets : outcome.back)
    for (const double kelvin : facets) EXPECT_NEAR(kelvin, 290.0, 1e-6);
}

// A square that faces one of 400 K at the same size and distance: F = .19982489569839.
TEST_F(HeatRun, PlatesExchangeByTheirViewFactor) {
  std::string obj = plate(0.0, 1, "cold") + "g hot\n";
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}})
    obj += "v " + std::to_string(x) + " " + std::to_string(y) + " 1\n";
  obj += "f 8 7 6 5\n";  // faces down
  const Outcome outcome =
      run(kDay + weather(300.0, 0.0, 0.0, 0.0, 100.0) + kSky + material("black", 1.0, 1.0, "\"none\"") + kMesh +
              region("cold", "material = \"black\"") + region("hot", "temperature = \"400 K\""),
          obj, {.rays = 65536});
  const double factor = 0.19982489569839;
  const double expected = equilibrium(factor * kSigma * std::pow(400.0, 4) + (1.0 - factor) * 100.0, 1.0, 0.0, 300.0);
  // 65536 rays have an rms error of 3.3e-4 in F; three of them are 0.3 K here.
  for (const auto& facets : outcome.front) EXPECT_NEAR(facets[0], expected, 0.3 + 0.1);
}

TEST_F(HeatRun, AShadeKeepsTheSunOff) {
  std::string obj = plate(0.0, 1, "shaded");
  obj += "g shade\nv -20 -20 1\nv 21 -20 1\nv 21 21 1\nv -20 21 1\nf 5 6 7 8\n";
  const std::string rest = kSky + material("paint", 0.7, 0.9, "\"mcadams\"") + kMesh +
                           region("shaded", "material = \"paint\"") + region("shade", "temperature = \"290 K\"");
  const Outcome dark = run(kDay + weather(290.0, 2.0, 0.0, 0.0, 350.0) + rest, obj);
  const Outcome sunny = run(kDay + weather(290.0, 2.0, 900.0, 0.0, 350.0) + rest, obj);
  const Outcome open = run(kDay + weather(290.0, 2.0, 900.0, 0.0, 350.0) + kSky +
                               material("paint", 0.7, 0.9, "\"mcadams\"") + kMesh + region("", "material = \"paint\""),
                           plate(0.0));
  for (std::size_t i = 6; i < 19; ++i) EXPECT_NEAR(sunny.front[i][0], dark.front[i][0], 1.0) << i;
  EXPECT_GT(open.front[12][0], sunny.front[12][0] + 30.0);  // 630 W/m2 over 19 W/m2/K
}

// The error that is promised is that of a run with a tolerance a hundred times smaller, and of twice the outputs.
TEST_F(HeatRun, RealisedErrorsAreBelowThePromise) {
  const std::string text = kDay + weather(280.0, 3.0, 800.0, 80.0, 280.0) + kSky +
                           material("thin", 0.8, 0.9, "\"mcadams\"", "inside = { kind = \"sheet\" }\n") + kMesh +
                           region("", "material = \"thin\"");
  const std::string obj = plate(0.0, 1, "lower") + plate(0.5, 5, "upper");
  const Outcome fine = run(text, obj, {.tolerance_k = 1e-3});
  for (const double tolerance : {1.0, 0.1, 0.01}) {
    const Outcome coarse = run(text, obj, {.tolerance_k = tolerance});
    double worst = 0.0;
    for (std::size_t i = 0; i < coarse.front.size(); ++i)
      for (std::size_t f = 0; f < coarse.front[i].size(); ++f)
        worst = std::max(
            {worst, std::abs(coarse.front[i][f] - fine.front[i][f]), std::abs(coarse.back[i][f] - fine.back[i][f])});
    EXPECT_LE(worst, coarse.report.promised.total_k() + fine.report.promised.total_k()) << tolerance;
    EXPECT_LE(coarse.report.promised.total_k(), tolerance);
  }
}

// A first day without sun must not decide how deep later days are followed into the material.
TEST_F(HeatRun, LaterDaysMayBeClearer) {
  std::string csv =
      "time,air_temperature (K),wind_speed (m/s),direct_normal (W/m2),diffuse_horizontal (W/m2),longwave_down (W/m2)\n";
  for (int hour = 0; hour <= 72; hour += 1)
    csv += "2016-03-" + std::to_string(20 + hour / 24) + "T" + (hour % 24 < 10 ? "0" : "") + std::to_string(hour % 24) +
           ":00:00Z,280,2,0," + (hour < 25 ? "0" : "900") + ",348\n";
  std::ofstream(folder_ / "weather.csv") << csv;
  const std::string text =
      "[time]\nstart = 2016-03-20T00:00:00Z\nend = 2016-03-23T00:00:00Z\nstep = \"1 h\"\n"
      "[weather]\nfile = \"weather.csv\"\n" +
      kSky +
      "[[material]]\nname = \"concrete\"\nsolar_absorptance = 0.7\nemissivity = 0.9\n"
      "convection = \"mcadams\"\nlayers = [{ conductivity = \"1.5 W/m/K\", density = \"2300 "
      "kg/m3\", heat_capacity = \"880 J/kg/K\", thickness = \"0.3 m\" }]\n" +
      kMesh + region("", "material = \"concrete\"");
  const Outcome fine = run(text, plate(1.0), {.tolerance_k = 0.01});
  const Outcome coarse = run(text, plate(1.0), {.tolerance_k = 0.1});
  ASSERT_EQ(coarse.front.size(), 73U);
  EXPECT_NEAR(fine.front[24][0], fine.front[0][0], 0.02);  // the day of the start repeats itself
  EXPECT_GT(fine.front[72][0], fine.front[24][0] + 20.0);
  for (std::size_t i = 0; i < coarse.front.size(); ++i)
    EXPECT_NEAR(coarse.front[i][0], fine.front[i][0], coarse.report.promised.total_k() + fine.report.promised.total_k())
        << i;
}

/// A square of 1 m at x that faces east (+x), or west.
std::string upright(double x, double y, bool east, int first, const std::string& group) {
  std::string text = "g " + group + "\n";
  for (const auto& [dy, z] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}})
    text += "v " + std::to_string(x) + " " + std::to_string(y + dy) + " " + std::to_string(z) + "\n";
  const auto corner = [&](int i) { return " " + std::to_string(first + i); };
  return text + "f" +
         (east ? corner(0) + corner(1) + corner(2) + corner(3) : corner(3) + corner(2) + corner(1) + corner(0)) + "\n";
}

// Facets with equal shares of sky, ground and other surfaces, one of which sees hot ones.
TEST_F(HeatRun, FacetsThatSeeHotSurfacesAreNoClassWithThoseThatSeeColdOnes) {
  const std::string obj = upright(0.0, 0.0, true, 1, "target") + upright(1.0, 0.0, false, 5, "hot") +
                          upright(0.0, 50.0, true, 9, "target") + upright(1.0, 50.0, false, 13, "cold");
  const double longwave = kSigma * std::pow(280.0, 4);
  const std::string text = kDay + weather(280.0, 1.0, 0.0, 0.0, longwave) + kSky +
                           material("paint", 0.7, 0.9, "\"mcadams\"") + kMesh +
                           region("target", "material = \"paint\"") + region("hot", "temperature = \"600 K\"") +
                           region("cold", "temperature = \"280 K\"");
  const Outcome outcome = run(text, obj, {.rays = 8192});
  std::vector<double> target{outcome.front.back()[0], outcome.front.back()[2]};
  const double factor = 0.19982489569839;
  const double hot =
      equilibrium(0.9 * (factor * kSigma * std::pow(600.0, 4) + (1.0 - factor) * longwave), 0.9, 5.7 + 3.8, 280.0);
  EXPECT_NEAR(target[0], hot, 2.0);  // an rms error of 1.6e-3 in F is 0.7 K here
  EXPECT_NEAR(target[1], 280.0, 0.1);
}

TEST_F(HeatRun, BacksThatAreSeenAndNotSolvedAreSaid) {
  const std::string obj = upright(0.0, 0.0, true, 1, "target") + upright(0.5, 0.0, true, 5, "plate");
  const std::string text = kDay + weather(280.0, 1.0, 0.0, 0.0, 300.0) + kSky +
                           material("paint", 0.7, 0.9, "\"mcadams\"") + kMesh + region("", "material = \"paint\"");
  const HeatScene scene = prepare(text, obj);
  ASSERT_FALSE(scene.warnings.empty());
  EXPECT_NE(scene.warnings.back().find("are backs of its open surfaces"), std::string::npos) << scene.warnings.back();
}

/// An NPY file of float32, rows of facets.
void write_npy(const std::filesystem::path& path, const std::vector<std::vector<float>>& rows) {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(rows.size()) + ", " +
                       std::to_string(rows.front().size()) + "), }";
  header.resize(117, ' ');
  std::ofstream file(path, std::ios::binary);
  file << std::string("\x93NUMPY\x01\0\x76\0", 10) << header << "\n";
  for (const auto& row : rows)
    file.write(reinterpret_cast<const char*>(row.data()), static_cast<std::streamsize>(4 * row.size()));
}

// A plate below one of given temperature is the same whether that comes from the file, a CSV or an NPY; a table that
// changes is a straight line between its times, and stands in the output as it is.
TEST_F(HeatRun, TemperaturesOfFacetsComeFromTables) {
  std::string obj = plate(0.0, 1, "cold") + "g hot\n";
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}})
    obj += "v " + std::to_string(x) + " " + std::to_string(y) + " 1\n";
  obj += "f 8 7 6 5\n";
  const auto text = [&](const std::string& hot) {
    return kDay + weather(300.0, 1.0, 0.0, 0.0, 300.0) + kSky + material("black", 1.0, 1.0, "\"mcadams\"") + kMesh +
           region("cold", "material = \"black\"") + region("hot", "temperature = \"" + hot + "\"");
  };
  const Outcome constant = run(text("400 K"), obj);
  std::ofstream(folder_ / "hot.csv") << "facet,temperature_K\n1,400\n";
  EXPECT_EQ(run(text("hot.csv"), obj).front, constant.front);
  write_npy(folder_ / "hot.npy", {{300.0F, 400.0F}});
  EXPECT_EQ(run(text("hot.npy"), obj).front, constant.front);

  write_npy(folder_ / "warming.npy", {{0.5F, 300.0F}, {0.5F, 420.0F}});
  std::ofstream(folder_ / "times.csv")
      << "output,time,time_s\n0,2016-03-20T00:00:00Z,0\n1,2016-03-21T00:00:00Z,86400\n";
  const Outcome warming = run(text("warming.npy"), obj);
  for (std::size_t i = 0; i < warming.times_s.size(); ++i)
    EXPECT_NEAR(warming.front[i][1], 300.0 + 120.0 * warming.times_s[i] / 86400.0, 1e-3);
  EXPECT_GT(warming.front.back()[0], warming.front[6][0] + 5.0);

  const auto refusal = [&](const std::string& hot) { return test::message_of([&] { prepare(text(hot), obj); }); };
  write_npy(folder_ / "many.npy", {{300.0F, 400.0F, 400.0F}});
  EXPECT_NE(refusal("many.npy").find("has 3 facets, the scene 2"), std::string::npos);
  std::ofstream(folder_ / "other.csv") << "facet,temperature_K\n0,400\n";
  EXPECT_NE(refusal("other.csv").find("facet 1 of region 'hot' has no temperature"), std::string::npos);
  std::ofstream(folder_ / "far.csv") << "facet,temperature_K\n7,400\n";
  EXPECT_NE(refusal("far.csv").find("far.csv:2: error: the scene has no such facet"), std::string::npos);
  std::ofstream(folder_ / "cut.npy") << "\x93NUMPY";
  EXPECT_NE(refusal("cut.npy").find("is no NPY file"), std::string::npos);
  write_npy(folder_ / "wrong.npy", {{300.0F, -4.0F}});
  EXPECT_NE(refusal("wrong.npy").find("which no surface has"), std::string::npos);
}

/// A closed box of 1 m x 1 m, from z = 1 to z = 1 + thickness: bottom, top, four rims.
std::string box(double thickness) {
  std::string text;
  for (const double z : {1.0, 1.0 + thickness})
    for (const auto& [x, y] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}})
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
  return text + "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
}

const std::string kFoamPair =
    "[[material]]\nname = \"foam\"\nsolar_absorptance = 0.7\nemissivity = 0.9\nconvection = { h0 = \"8 W/m2/K\", h1 = "
    "\"0 J/m3/K\" }\nlayers = [{ conductivity = \"0.05 W/m/K\", density = \"30 kg/m3\", heat_capacity = \"1400 "
    "J/kg/K\", "
    "thickness = \"10 mm\" }]\ninside = { kind = \"pair\" }\n";

// A wall of conductance k / d between a top under light and sky and a bottom above ground of the air's temperature:
//   a D + eps L - eps sigma T1^4 - h (T1 - Ta) = k / d (T1 - T2)
//   eps sigma Ta^4 - eps sigma T2^4 - h (T2 - Ta) = k / d (T2 - T1)
TEST_F(HeatRun, WallsOfAClosedBoxConductToTheOtherSide) {
  constexpr double air = 285.0, sky = 250.0, light = 600.0, h = 8.0, eps = 0.9, conductance = 5.0;
  const std::string text =
      kDay + weather(air, 1.0, 0.0, light, sky) + kSky + kFoamPair + kMesh + region("", "material = \"foam\"");
  const HeatOptions options{.tolerance_k = 0.01, .rays = 4096};
  const Outcome outcome = run(text, box(0.01), options);
  double top = air, bottom = air;
  for (int i = 0; i < 200; ++i) {  // each side in balance with the other: the conductance is less than half of the loss
    top = equilibrium(0.7 * light + eps * sky + conductance * bottom + h * air, eps, h + conductance, 0.0);
    bottom = equilibrium(eps * kSigma * std::pow(air, 4) + conductance * top + h * air, eps, h + conductance, 0.0);
  }
  ASSERT_EQ(outcome.front.front().size(), 6U);
  EXPECT_TRUE(outcome.back.front().empty());
  for (const auto& facets : outcome.front) {
    // The air's ground is black and reflects no light, so the bottom has none.
    EXPECT_NEAR(facets[1], top, 0.02);
    EXPECT_NEAR(facets[0], bottom, 0.02);
    EXPECT_GT(facets[1] - facets[0], 10.0);
  }
  // The rims have no opposite face so near.
  ASSERT_FALSE(outcome.report.warnings.empty());
  const auto said = [&](const std::string& words) {
    return std::any_of(outcome.report.warnings.begin(), outcome.report.warnings.end(),
                       [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(said("4 of 6 facets have no opposite face of that material within 0.02 m"));

  // A mesh of another thickness than the layers is said.
  const HeatScene thick = prepare(text, box(0.019), options);
  EXPECT_TRUE(std::any_of(thick.warnings.begin(), thick.warnings.end(), [](const std::string& warning) {
    return warning.find("the walls of the mesh 0.019 m (median)") != std::string::npos;
  }));
}

// A slab with a uniform source q between a surface that gives off what equilibrium() has and a film of the inside:
//   k T' = loss(T0) - absorbed at x = 0,  T = T0 + T' x - q x^2 / (2 k),  -k T'(d) = h_in (T(d) - T_in)
TEST_F(HeatRun, SourcesInLayersComeOutOfTheSurfaces) {
  constexpr double air = 290.0, sky = 300.0, h = 8.0, eps = 0.9, k = 0.2, d = 0.04, q = 8000.0;
  constexpr double h_in = 10.0, inner = 280.0;
  const auto scene = [&](const std::string& inside) {
    return kDay + weather(air, 1.0, 0.0, 0.0, sky) + kSky +
           "[[material]]\nname = \"heater\"\nsolar_absorptance = 0.7\nemissivity = 0.9\nconvection = { h0 = \"8 "
           "W/m2/K\", "
           "h1 = \"0 J/m3/K\" }\nlayers = [{ conductivity = \"0.2 W/m/K\", density = \"500 kg/m3\", heat_capacity = "
           "\"1000 J/kg/K\", thickness = \"40 mm\", source = \"8000 W/m3\" }]\ninside = " +
           inside + "\n" + kMesh + region("", "material = \"heater\"");
  };
  const HeatOptions options{.tolerance_k = 0.01};
  const double insulated = run(scene("{ kind = \"adiabatic\" }"), plate(1.0), options).front.back()[0];
  EXPECT_NEAR(insulated, equilibrium(eps * sky + q * d, eps, h, air), 0.02);

  double low = 200.0, high = 500.0;
  for (int i = 0; i < 200; ++i) {
    const double t0 = 0.5 * (low + high);
    const double slope = (eps * kSigma * std::pow(t0, 4) + h * (t0 - air) - eps * sky) / k;
    const double back = t0 + slope * d - q * d * d / (2.0 * k);
    // Too warm a surface asks for more heat than the slab generates less what the inside takes.
    (-k * (slope - q * d / k) > h_in * (back - inner) ? low : high) = t0;
  }
  const double film = run(scene("{ kind = \"film\", h = \"10 W/m2/K\", temperature = \"280 K\" }"), plate(1.0), options)
                          .front.back()[0];
  EXPECT_NEAR(film, low, 0.02);
  EXPECT_GT(insulated - film, 3.0);
}

// Over a day of sun the pair and a sheet of the same layers are the same: top and bottom, front and back.
TEST_F(HeatRun, APairIsASheetWithTwoFaces) {
  const std::string head = kDay + weather(285.0, 1.0, 700.0, 80.0, 270.0) + kSky;
  std::string sheet = kFoamPair;
  sheet.replace(sheet.find("\"pair\""), 6, "\"sheet\"");
  const HeatOptions options{.tolerance_k = 0.05, .directions = 48, .rays = 4096};
  const Outcome pair = run(head + kFoamPair + kMesh + region("", "material = \"foam\""), box(0.01), options);
  const Outcome plain = run(head + sheet + kMesh + region("", "material = \"foam\""), plate(1.0), options);
  ASSERT_EQ(pair.front.size(), plain.front.size());
  for (std::size_t i = 0; i < pair.front.size(); ++i) {
    EXPECT_NEAR(pair.front[i][1], plain.front[i][0], 0.1) << i;
    EXPECT_NEAR(pair.front[i][0], plain.back[i][0], 0.1) << i;
  }
}

TEST_F(HeatRun, TheSameForEveryNumberOfThreads) {
  const std::string text = kDay + weather(280.0, 3.0, 800.0, 80.0, 280.0) + kSky +
                           material("thin", 0.8, 0.9, "\"mcadams\"") + kMesh + region("", "material = \"thin\"");
  const std::string obj = plate(0.0, 1, "lower") + plate(0.5, 5, "upper");
  EXPECT_EQ(run(text, obj, {.tolerance_k = 0.1, .threads = 1}).front,
            run(text, obj, {.tolerance_k = 0.1, .threads = 2}).front);
}

TEST_F(HeatRun, RefusesWhatItCannotSolve) {
  const std::string head = kDay + weather(280.0, 3.0, 800.0, 80.0, 280.0) + kSky;
  const auto refusal = [&](const std::string& text) { return test::message_of([&] { prepare(text, plate(0.0)); }); };
  EXPECT_NE(test::message_of([&] {
              run(head + material("wall", 0.8, 0.9, "\"mcadams\"", "inside = { kind = \"sheet\" }\n") + kMesh +
                      region("", "material = \"wall\"") + "[ground]\nmaterial = \"wall\"\n",
                  plate(0.0));
            }).find("[ground]: material 'wall' is a sheet"),
            std::string::npos);
  EXPECT_NE(refusal(head + material("wall", 0.8, 0.0, "\"none\"") + kMesh + region("", "material = \"wall\""))
                .find("nothing determines its temperature"),
            std::string::npos);
  EXPECT_NE(refusal(head + material("wall", 0.8, 0.9, "\"mcadams\"") + kMesh + region("roof", "material = \"wall\""))
                .find("has no group 'roof' (there are: plate)"),
            std::string::npos);
}

}  // namespace
}  // namespace apps::scene
