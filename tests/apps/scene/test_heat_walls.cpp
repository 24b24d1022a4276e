// SPDX-License-Identifier: Apache-2.0

// Walls of closed shells, sources in their layers, and temperatures from tables.

#include "tests/apps/scene/heat_run_case.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps::scene {
namespace {

using namespace test;

class HeatWalls : public HeatRun {};

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
TEST_F(HeatWalls, TemperaturesOfFacetsComeFromTables) {
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

  const auto refusal = [&](const std::string& hot) { return message_of([&] { prepare(text(hot), obj); }); };
  write_npy(folder_ / "many.npy", {{300.0F, 400.0F, 400.0F}});
  expect_says(refusal("many.npy"), {"3 facets", "the scene 2"});
  std::ofstream(folder_ / "other.csv") << "facet,temperature_K\n0,400\n";
  expect_says(refusal("other.csv"), {"facet 1 of", "region 'hot'"});
  std::ofstream(folder_ / "far.csv") << "facet,temperature_K\n7,400\n";
  expect_says(refusal("far.csv"), {"far.csv:2: error:", "no such facet"});
  std::ofstream(folder_ / "cut.npy") << "\x93NUMPY";
  expect_says(refusal("cut.npy"), {"is no NPY file"});
  write_npy(folder_ / "wrong.npy", {{300.0F, -4.0F}});
  expect_says(refusal("wrong.npy"), {"which no surface has"});
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
TEST_F(HeatWalls, WallsOfAClosedBoxConductToTheOtherSide) {
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
  EXPECT_TRUE(says(outcome.report.warnings, "4 of 6 facets"));

  // A mesh of another thickness than the layers is said.
  const HeatScene thick = prepare(text, box(0.019), options);
  EXPECT_TRUE(says(thick.warnings, "0.019 m (median)"));
}

// A slab with a uniform source q between a surface that gives off what equilibrium() has and a film of the inside:
//   k T' = loss(T0) - absorbed at x = 0,  T = T0 + T' x - q x^2 / (2 k),  -k T'(d) = h_in (T(d) - T_in)
TEST_F(HeatWalls, SourcesInLayersComeOutOfTheSurfaces) {
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

// A schedule takes another way through the solver than a constant: the same power has to come to the same temperatures.
TEST_F(HeatWalls, SourcesBySchedule) {
  std::ofstream(folder_ / "even.csv") << "time (h),source (W/m3)\n0,8000\n30,8000\n";
  std::ofstream(folder_ / "switched.csv") << "time (h),source (W/m3)\n0,0\n6,0\n6.5,40000\n12,40000\n12.5,0\n24,0\n";
  std::ofstream(folder_ / "flux.csv") << "time (h),flux (W/m2)\n0,0\n6,0\n6.5,200\n12,200\n12.5,0\n24,0\n";
  const HeatOptions options{.tolerance_k = 0.02};
  const auto wall = [&](const std::string& source, const std::string& layer, const std::string& inside) {
    return run(kDay + weather(290.0, 1.0, 300.0, 50.0, 300.0) + kSky +
                   "[[material]]\nname = \"heater\"\nsolar_absorptance = 0.7\nemissivity = 0.9\n"
                   "convection = \"mcadams\"\nlayers = [{ " +
                   layer + (source.empty() ? "" : ", source = \"" + source + "\"") + " }]\ninside = " + inside + "\n" +
                   kMesh + region("", "material = \"heater\""),
               plate(1.0), options);
  };
  const auto expect_same = [&](const Outcome& a, const Outcome& b) {
    ASSERT_EQ(a.front.size(), b.front.size());
    for (std::size_t i = 0; i < a.front.size(); ++i) EXPECT_NEAR(a.front[i][0], b.front[i][0], 0.04) << i;
    EXPECT_LE(a.report.promised.total_k(), options.tolerance_k);
    for (const MaterialRun& material : a.report.materials) EXPECT_LT(material.drift, 1e-12);
  };
  const std::string board =
      "conductivity = \"0.2 W/m/K\", density = \"500 kg/m3\", heat_capacity = \"1000 J/kg/K\", thickness = \"40 mm\"";
  for (const std::string inside :
       {"{ kind = \"adiabatic\" }", "{ kind = \"sheet\" }", "{ kind = \"fixed\", temperature = \"285 K\" }",
        "{ kind = \"film\", h = \"10 W/m2/K\", temperature = \"280 K\" }"})
    expect_same(wall("even.csv", board, inside), wall("8000 W/m3", board, inside));
  // In 5 mm of steel it does not matter where heat comes from.
  const std::string steel =
      "conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", thickness = \"5 mm\"";
  const Outcome switched = wall("switched.csv", steel, "{ kind = \"adiabatic\" }");
  expect_same(switched, wall("", steel, "{ kind = \"flux\", flux = \"flux.csv\" }"));
  EXPECT_GT(switched.front[12][0], wall("", steel, "{ kind = \"adiabatic\" }").front[12][0] + 5.0);
}

// A wet plate in the dark: eps L + h (T_air - T) = eps sigma T^4 + h / gamma (e_s(T) - e).
TEST_F(HeatWalls, WetSurfacesAreColder) {
  std::string air = weather(293.15, 2.0, 0.0, 0.0, 350.0);
  const std::string rest = kSky + material("felt", 0.7, 0.9, "\"mcadams\"", "wet_fraction = 0.5\n") + kMesh +
                           region("", "material = \"felt\"");
  expect_refused<mtf::Error>({"vapour_pressure"}, [&] { run(kDay + air + rest, plate(1.0)); });
  air += "vapour_pressure = \"1000 Pa\"\n";
  const double kelvin = run(kDay + air + rest, plate(1.0), {.tolerance_k = 0.01}).front.back()[0];
  double low = 200.0, high = 400.0;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.5 * (low + high), celsius = t - 273.15, h = 5.7 + 3.8 * 2.0;
    const double saturated = 611.2 * std::exp(17.62 * celsius / (243.12 + celsius));
    const double gains = 0.9 * 350.0 + h * (293.15 - t) - 0.9 * kSigma * std::pow(t, 4) -
                         0.5 * h / (1013.0 * 101325.0 / (0.622 * 2.45e6)) * (saturated - 1000.0);
    (gains > 0.0 ? low : high) = t;
  }
  EXPECT_NEAR(kelvin, low, 0.01);
  EXPECT_LT(kelvin, 288.0);
}

// Over a day of sun the pair and a sheet of the same layers are the same: top and bottom, front and back.
TEST_F(HeatWalls, APairIsASheetWithTwoFaces) {
  const std::string head = kDay + weather(285.0, 1.0, 700.0, 80.0, 270.0) + kSky;
  std::string sheet = kFoamPair;
  sheet = replaced(sheet, "\"pair\"", "\"sheet\"");
  const HeatOptions options{.tolerance_k = 0.05, .directions = 48, .rays = 4096};
  const Outcome pair = run(head + kFoamPair + kMesh + region("", "material = \"foam\""), box(0.01), options);
  const Outcome plain = run(head + sheet + kMesh + region("", "material = \"foam\""), plate(1.0), options);
  ASSERT_EQ(pair.front.size(), plain.front.size());
  for (std::size_t i = 0; i < pair.front.size(); ++i) {
    EXPECT_NEAR(pair.front[i][1], plain.front[i][0], 0.1) << i;
    EXPECT_NEAR(pair.front[i][0], plain.back[i][0], 0.1) << i;
  }
}

}  // namespace
}  // namespace apps::scene
