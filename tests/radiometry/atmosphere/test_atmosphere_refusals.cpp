// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "mtf/error.h"
#include "radiometry/atmosphere/range_table.h"
#include "radiometry/atmosphere/sky_radiance.h"

namespace {

using namespace radiometry::atmosphere;

void refused(const std::function<void()>& call, const std::string& words) {
  try {
    call();
    ADD_FAILURE() << "taken, expected: " << words;
  } catch (const mtf::UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

const Air<double> kAir{model_profile(ModelAtmosphere::us_standard_1976)};
const double kDegree = std::acos(-1.0) / 180.0;

TEST(AtmosphereRefusals, Air) {
  refused([] { surface_air(101325.0, 290.0, 100.5); }, "relative humidity of 100.5 %");
  refused([] { surface_air(101325.0, 20.0, 50.0); }, "degrees Celsius");
  refused([] { surface_air(1013.25, 290.0, 50.0); }, "hectopascals");
  refused([] { surface_air(20000.0, 333.15, 100.0); }, "less humidity");
  refused([] { surface_air(std::nan(""), 290.0, 50.0); }, "pressure");
  refused([] { model_profile(ModelAtmosphere::tropical, -1.0); }, "CO2");
  refused([] { with_surface(model_profile(ModelAtmosphere::tropical), 25.0, 50.0); }, "degrees Celsius");
  const auto spoiled = [](const std::function<void(Profile<double>&)>& spoil) {
    Profile<double> profile = model_profile(ModelAtmosphere::us_standard_1976);
    spoil(profile);
    require_valid(profile);
  };
  refused([&] { spoiled([](auto& p) { std::swap(p.levels[3], p.levels[4]); }); },
          "level 5 at 3000 m: altitudes have to rise");
  refused(
      [&] {
        spoiled([](auto& p) {
          for (auto& l : p.levels) l.pressure_pa *= 0.01;
        });
      },
      "are these hectopascals?");
  refused([&] { spoiled([](auto& p) { p.levels[2].temperature_k = 15.0; }); }, "288.15 K");
  refused([&] { spoiled([](auto& p) { p.levels[2][Gas::water] = 5e4; }); }, "of saturation");
  refused([&] { spoiled([](auto& p) { p.levels[20][Gas::oxygen] = -1.0; }); }, "mixing ratio");
  refused(
      [&] {
        spoiled([](auto& p) {
          p.levels[20][Gas::oxygen] = 999999.0;
          p.levels[20][Gas::ozone] = 10.0;
        });
      },
      "more than all of the air");
  refused([&] { spoiled([](auto& p) { p.levels.clear(); }); }, "without levels");
  refused(
      [] {
        Air<double> air = kAir;
        air.haze = {HazeKind::rural, 23.0 - 20.0};
        require_valid(air);
      },
      "metres, not kilometres");
  refused(
      [] {
        Air<double> air = kAir;
        air.rain_mm_h = -1.0;
        require_valid(air);
      },
      "rain");
}

TEST(AtmosphereRefusals, LinesOfSight) {
  const auto numbers = [](const Sight<double>& sight) { return [sight] { sight_numbers(kAir, sight); }; };
  refused(numbers(Between<double>{-5.0, 100.0, 500.0}), "below the ground");
  refused(numbers(AtAngle<double>{2e5, 1.0, 500.0}), "above the air");
  refused(numbers(Between<double>{2.0, 2.0, 40000.0}), "beyond the horizon");
  refused(numbers(Between<double>{1000.0, 0.0, 900.0}), "1000 m apart");
  refused(numbers(AtAngle<double>{1000.0, 180.0 * kDegree, 2000.0}), "meets the ground after 1001 m");
  refused(numbers(ToSpace<double>{1000.0, 100.0 * kDegree}), "meets the ground");
  refused(numbers(ToAltitude<double>{10e3, 91.0 * kDegree, 0.0}), "never gets to 0 m");
  refused(numbers(Horizontal<double>{0.0, -1.0}), "range of -1 m");
  refused(numbers(Horizontal<double>{0.0, std::nan("")}), "range");
  refused(numbers(Horizontal<double>{0.0, 1e9}), "a quarter of the way around the earth");
  refused(numbers(ToSpace<double>{0.0, 4.0}), "zenith angle of 4 rad");
  refused(
      [] {
        sight_numbers(Air<double>{surface_air(101325.0, 290.0, 50.0)}, Sight<double>(ToSpace<double>{0.0, 0.0}));
      },
      "one level");
}

TEST(AtmosphereRefusals, BandsAndTables) {
  const Sight<double> sight = Horizontal<double>{0.0, 1000.0};
  refused([&] { spectral_path(kAir, sight, {.band = {8.0, 16.0}}); }, "the model goes from 0.4 um to 15.38 um");
  refused([&] { spectral_path(kAir, sight, {.band = {5.0, 5.0}}); }, "has to rise");
  refused([&] { spectral_path(kAir, sight, {.tolerance = 2.0}); }, "tolerance");
  refused([&] { path_table(kAir, sight, {}); }, "no ranges");
  refused([&] { path_table(kAir, sight, std::array{10.0, 10.0}); }, "ranges have to rise");
  refused(
      [&] {
        path_table(kAir, Sight<double>(ToAltitude<double>{1e3, 180.0 * kDegree, 0.0}), std::array{2000.0});
      },
      "ends after 1000 m");
  refused([&] { ranges_for(kAir, sight, 10.0, 1.0, 1e-3, {8.0, 12.0}); }, "rise");
  refused([&] { sky_flux(kAir, 0.0, 1); }, "angles");
}

}  // namespace
