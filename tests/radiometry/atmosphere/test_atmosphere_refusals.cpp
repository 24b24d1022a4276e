// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "radiometry/atmosphere/range_table.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "tests/expect_error.h"

namespace {

using namespace radiometry::atmosphere;

const Air<double> kAir{model_profile(ModelAtmosphere::us_standard_1976)};
const double kDegree = std::acos(-1.0) / 180.0;

TEST(AtmosphereRefusals, Air) {
  expect_refused({"relative humidity of 100.5 %"}, [] { surface_air(101325.0, 290.0, 100.5); });
  expect_refused({"degrees Celsius"}, [] { surface_air(101325.0, 20.0, 50.0); });
  expect_refused({"hectopascals"}, [] { surface_air(1013.25, 290.0, 50.0); });
  expect_refused({"less humidity"}, [] { surface_air(20000.0, 333.15, 100.0); });
  expect_refused({"pressure"}, [] { surface_air(std::nan(""), 290.0, 50.0); });
  expect_refused({"CO2"}, [] { model_profile(ModelAtmosphere::tropical, -1.0); });
  expect_refused({"degrees Celsius"}, [] { with_surface(model_profile(ModelAtmosphere::tropical), 25.0, 50.0); });
  const auto spoiled = [](const std::function<void(Profile<double>&)>& spoil) {
    Profile<double> profile = model_profile(ModelAtmosphere::us_standard_1976);
    spoil(profile);
    require_valid(profile);
  };
  expect_refused({"level 5 at 3000", "rise"}, [&] { spoiled([](auto& p) { std::swap(p.levels[3], p.levels[4]); }); });
  expect_refused({"are these hectopascals?"}, [&] {
    spoiled([](auto& p) {
      for (auto& l : p.levels) l.pressure_pa *= 0.01;
    });
  });
  expect_refused({"288.15 K"}, [&] { spoiled([](auto& p) { p.levels[2].temperature_k = 15.0; }); });
  expect_refused({"of saturation"}, [&] { spoiled([](auto& p) { p.levels[2][Gas::water] = 5e4; }); });
  expect_refused({"mixing ratio"}, [&] { spoiled([](auto& p) { p.levels[20][Gas::oxygen] = -1.0; }); });
  expect_refused({"all of the air"}, [&] {
    spoiled([](auto& p) {
      p.levels[20][Gas::oxygen] = 999999.0;
      p.levels[20][Gas::ozone] = 10.0;
    });
  });
  expect_refused({"without levels"}, [&] { spoiled([](auto& p) { p.levels.clear(); }); });
  expect_refused({"metres, not kilometres"}, [] {
    Air<double> air = kAir;
    air.haze = {HazeKind::rural, 23.0 - 20.0};
    require_valid(air);
  });
  expect_refused({"rain"}, [] {
    Air<double> air = kAir;
    air.rain_mm_h = -1.0;
    require_valid(air);
  });
}

TEST(AtmosphereRefusals, LinesOfSight) {
  const auto numbers = [](const Sight<double>& sight) { return [sight] { sight_numbers(kAir, sight); }; };
  expect_refused({"below the ground"}, numbers(Between<double>{-5.0, 100.0, 500.0}));
  expect_refused({"above the air"}, numbers(AtAngle<double>{2e5, 1.0, 500.0}));
  expect_refused({"beyond the horizon"}, numbers(Between<double>{2.0, 2.0, 40000.0}));
  expect_refused({"1000 m apart"}, numbers(Between<double>{1000.0, 0.0, 900.0}));
  expect_refused({"the ground after 1001"}, numbers(AtAngle<double>{1000.0, 180.0 * kDegree, 2000.0}));
  expect_refused({"meets the ground"}, numbers(ToSpace<double>{1000.0, 100.0 * kDegree}));
  expect_refused({"never gets to 0 m"}, numbers(ToAltitude<double>{10e3, 91.0 * kDegree, 0.0}));
  expect_refused({"range of -1 m"}, numbers(Horizontal<double>{0.0, -1.0}));
  expect_refused({"range"}, numbers(Horizontal<double>{0.0, std::nan("")}));
  expect_refused({"quarter of the way"}, numbers(Horizontal<double>{0.0, 1e9}));
  expect_refused({"zenith angle of 4 rad"}, numbers(ToSpace<double>{0.0, 4.0}));
  expect_refused({"one level"}, [] {
    sight_numbers(Air<double>{surface_air(101325.0, 290.0, 50.0)}, Sight<double>(ToSpace<double>{0.0, 0.0}));
  });
}

TEST(AtmosphereRefusals, BandsAndTables) {
  const Sight<double> sight = Horizontal<double>{0.0, 1000.0};
  expect_refused({"0.4 um", "15.38 um"}, [&] { spectral_path(kAir, sight, {.band = {8.0, 16.0}}); });
  expect_refused({"has to rise"}, [&] { spectral_path(kAir, sight, {.band = {5.0, 5.0}}); });
  expect_refused({"tolerance"}, [&] { spectral_path(kAir, sight, {.tolerance = 2.0}); });
  expect_refused({"no ranges"}, [&] { path_table(kAir, sight, {}); });
  expect_refused({"ranges have to rise"}, [&] { path_table(kAir, sight, std::array{10.0, 10.0}); });
  expect_refused({"ends after 1000 m"}, [&] {
    path_table(kAir, Sight<double>(ToAltitude<double>{1e3, 180.0 * kDegree, 0.0}), std::array{2000.0});
  });
  expect_refused({"rise"}, [&] { ranges_for(kAir, sight, 10.0, 1.0, 1e-3, {8.0, 12.0}); });
  expect_refused({"angles"}, [&] { sky_flux(kAir, 0.0, 1); });
}

}  // namespace
