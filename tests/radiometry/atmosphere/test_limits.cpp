// SPDX-License-Identifier: Apache-2.0

// What holds of every path: bounds, monotony, energy, geometry against a sphere, tables against single paths.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "mtf/error.h"
#include "mtf/math/quadrature.h"
#include "mtf/units.h"
#include "radiometry/atmosphere/range_table.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "radiometry/light/blackbody.h"
#include "tests/expect_error.h"
#include "tests/radiometry/atmosphere/atmosphere_data.h"

namespace {

using namespace atmosphere_tests;
using Paths = std::vector<SpectralPath<double>>;

const double kDegree = std::acos(-1.0) / 180.0;

Sight<double> level(double altitude_m, double range_m) { return Horizontal<double>{altitude_m, range_m}; }

void expect_falls(const SpectralPath<double>& less, const SpectralPath<double>& more, const std::string& what,
                  double from_um = 0.0) {
  for (std::size_t i = 0; i < less.transmission.size(); ++i) {
    if (1e4 / less.wavenumber_cm[i] <= from_um) continue;
    ASSERT_LE(more.transmission[i], less.transmission[i] + 1e-15)
        << what << " at " << less.wavenumber_cm[i] << " cm^-1";
  }
}

void expect_bounded(const SpectralPath<double>& path, double warmest_k) {
  for (std::size_t i = 0; i < path.transmission.size(); ++i) {
    ASSERT_TRUE(path.transmission[i] >= 0.0 && path.transmission[i] <= 1.0) << path.wavenumber_cm[i];
    if (i >= path.radiance.size()) continue;
    const double um = 1e4 / path.wavenumber_cm[i];
    const double black = radiometry::planck(radiometry::Flux::watts, um, warmest_k) * um * um * 1e-4;
    ASSERT_TRUE(path.radiance[i] >= 0.0 && path.radiance[i] <= black * (1.0 + 1e-9)) << path.wavenumber_cm[i];
  }
}

TEST(AtmosphereLimits, RandomHorizontalPaths) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int refused = 0;
  for (int draw = 0; draw < 120; ++draw) {
    const double altitude = 100e3 * unit(random) * unit(random), kelvin = 183.15 + 150.0 * unit(random);
    const double humidity = std::pow(10.0, -6.0 + 8.0 * unit(random));
    const double pressure = 101325.0 * std::exp(-altitude / 7500.0);
    const auto kind = static_cast<HazeKind>(random() % 7);
    const double visibility = std::pow(10.0, 2.0 + 3.5 * unit(random)), range = 1e6 * std::pow(unit(random), 4.0);
    const double rain = draw % 5 == 0 ? 100.0 * unit(random) : 0.0;
    Air<double> air;
    try {
      air = {surface_air(pressure, kelvin, humidity), {kind, visibility, static_cast<Season>(random() % 2)}, rain};
    } catch (const mtf::UsageError& error) {  // vapour at low pressure; 300 ... 1100 Pa above 2 C reads as hPa
      ++refused;
      ASSERT_TRUE(1e-2 * humidity * saturation_per_cm3(kelvin) > 0.5 * air_per_cm3(pressure, kelvin) ||
                  pressure < 1100.0)
          << error.what();
      continue;
    }
    const auto path = spectral_path(air, level(altitude, range));
    expect_bounded(path, kelvin);
    expect_falls(path, spectral_path(air, level(altitude, 1.1 * range)), "range");
    for (const double tau : spectral_path(air, level(altitude, 0.0)).transmission) ASSERT_EQ(tau, 1.0);
    for (std::size_t gas = 0; gas < kGases; ++gas) {
      if (gas == 0 && rain > 0.0) continue;
      Air<double> more = air;
      more.profile.levels[0].ppm[gas] *= 1.05;
      expect_falls(path, spectral_path(more, level(altitude, range)), "gas " + std::to_string(gas),
                   gas == 0 ? 0.55 : 0.0);
    }
    Air<double> hazier = air;
    hazier.haze.visibility_m *= 0.9;
    expect_falls(path, spectral_path(hazier, level(altitude, range)), "visibility");
    if (rain > 0.0) {
      Air<double> wetter = air;
      wetter.rain_mm_h *= 1.1;
      expect_falls(path, spectral_path(wetter, level(altitude, range)), "rain");
    }
  }
  EXPECT_LT(refused, 40);
}

TEST(AtmosphereLimits, RandomSlantPaths) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int made = 0;
  for (int draw = 0; draw < 150; ++draw) {
    const auto model = static_cast<ModelAtmosphere>(random() % 6);
    Air<double> air{model_profile(model),
                    {static_cast<HazeKind>(random() % 7), std::pow(10.0, 2.5 + 3.0 * unit(random)), season_of(model)},
                    draw % 7 == 0 ? 20.0 * unit(random) : 0.0};
    const double altitude = 30e3 * unit(random) * unit(random), zenith = 180.0 * kDegree * unit(random);
    const double range = 1e6 * std::pow(unit(random), 3.0);
    try {
      const std::array ranges{0.3 * range, 0.31 * range, 0.7 * range, range};
      const auto paths = spectral_paths(air, Sight<double>(AtAngle<double>{altitude, zenith, 0.0}), ranges);
      ++made;
      for (std::size_t i = 0; i < paths.size(); ++i) {
        expect_bounded(paths[i], 305.0);
        if (i > 0) expect_falls(paths[i - 1], paths[i], "range");
        const auto alone = spectral_path(air, Sight<double>(AtAngle<double>{altitude, zenith, ranges[i]}));
        for (std::size_t k = 0; k < alone.transmission.size(); ++k)
          ASSERT_NEAR(alone.transmission[k], paths[i].transmission[k], 1e-12);
        for (std::size_t k = 0; k < alone.radiance.size(); ++k)
          ASSERT_NEAR(alone.radiance[k], paths[i].radiance[k], 1e-13);
        ASSERT_NEAR(alone.sight.object_altitude_m, paths[i].sight.object_altitude_m, 1e-3);
      }
    } catch (const mtf::UsageError& error) {
      ASSERT_NE(std::string(error.what()).find("meets the ground"), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(made, 60);
}

TEST(AtmosphereLimits, IsothermalPathsEmitWhatTheyAbsorb) {
  for (const double kelvin : {220.0, 300.0}) {
    Air<double> air{model_profile(ModelAtmosphere::us_standard_1976), {HazeKind::rural, 10e3}};
    for (Level<double>& one : air.profile.levels) {
      one.temperature_k = kelvin;
      one[Gas::water] = std::min(one[Gas::water], 0.9 * water_ppm(one.pressure_pa, kelvin, 100.0));
    }
    for (const Sight<double>& sight : {level(0, 3e3), Sight<double>(ToSpace<double>{0.0, 80.0 * kDegree}),
                                       Sight<double>(ToAltitude<double>{12e3, 140.0 * kDegree, 0.0})}) {
      const auto path = spectral_path(air, sight);
      for (std::size_t i = 0; i < path.radiance.size(); ++i) {
        const double um = 1e4 / path.wavenumber_cm[i];
        const double black = radiometry::planck(radiometry::Flux::watts, um, kelvin) * um * um * 1e-4;
        ASSERT_NEAR(path.radiance[i] / black, 1.0 - path.transmission[i], 1e-11);
      }
    }
  }
}

TEST(AtmosphereLimits, ComponentsMultiplyToTheTotal) {
  const Air<double> air{model_profile(ModelAtmosphere::tropical), {HazeKind::maritime, 15e3}, 1.0};
  const auto path =
      spectral_path(air, Sight<double>(ToAltitude<double>{5e3, 120.0 * kDegree, 0.0}), {.components = true});
  for (std::size_t i = 0; i < path.transmission.size(); ++i) {
    double product = 1.0;
    for (const auto& component : path.component) product *= component[i];
    ASSERT_NEAR(product, path.transmission[i], 1e-12);
  }
}

// Without air to bend it, light goes straight past a sphere; with it, the horizon is farther: by 6 to 9 % in the lower
// air.
TEST(AtmosphereSight, NumbersAgreeWithEachOther) {
  const Air<double> air{model_profile(ModelAtmosphere::us_standard_1976)};
  for (const auto& [from, to, range] : {std::array{1000.0, 0.0, 3000.0},
                                        {2.0, 30.0, 20000.0},
                                        {10000.0, 10000.0, 300000.0},
                                        {0.0, 8000.0, 8000.0},
                                        {50.0, 50.0, 1000.0}}) {
    const auto between = sight_numbers(air, Sight<double>(Between<double>{from, to, range}));
    EXPECT_NEAR(between.object_altitude_m, to, 1e-5);
    const auto again = sight_numbers(air, Sight<double>(AtAngle<double>{from, between.zenith_rad, range}));
    EXPECT_NEAR(again.object_altitude_m, to, 1e-3);
    // Straight lines: cos = ((R + z2)^2 - (R + z1)^2 - r^2) / (2 r (R + z1)); refraction lifts by less than a sixth of
    // the sphere's fall.
    const double r1 = kEarthRadius_m + from,
                 straight = std::acos(std::clamp(
                     ((to - from) * (2 * kEarthRadius_m + to + from) - range * range) / (2 * range * r1), -1.0, 1.0));
    EXPECT_LE(between.zenith_rad, straight + 1e-6);  // the angle near 0 has half of the digits of its cosine
    EXPECT_NEAR(between.zenith_rad, straight, range / kEarthRadius_m / 8.0 + 1e-6);
  }
  const double geometric = std::sqrt(2.0 * kEarthRadius_m * 100.0 + 1e4);
  const double horizon = horizon_range_m(air, 100.0, 0.0);
  EXPECT_GT(horizon, 1.05 * geometric);
  EXPECT_LT(horizon, 1.12 * geometric);
  EXPECT_NO_THROW(sight_numbers(air, Sight<double>(Between<double>{100.0, 0.0, 0.999 * horizon})));
  EXPECT_THROW(sight_numbers(air, Sight<double>(Between<double>{100.0, 0.0, 1.2 * horizon})), mtf::UsageError);
}

TEST(AtmosphereTable, IsWhatSinglePathsAre) {
  const Air<double> air{model_profile(ModelAtmosphere::mid_latitude_summer), {HazeKind::rural, 23e3}};
  const SpectralOptions options{.band = {3.4, 4.8}};
  for (const Sight<double>& sight : {level(10.0, 0.0), Sight<double>(AtAngle<double>{3000.0, 110.0 * kDegree, 0.0}),
                                     Sight<double>(Between<double>{1500.0, 0.0, 0.0})}) {
    const std::array ranges{1600.0, 2500.0, 7000.0};
    const auto result = path_table(air, sight, ranges, options);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const auto one = radiometry::atmosphere::path_of(spectral_path(air,
                                                                     std::visit(
                                                                         [&](auto s) {
                                                                           if constexpr (requires { s.range_m; })
                                                                             s.range_m = ranges[i];
                                                                           return Sight<double>(s);
                                                                         },
                                                                         sight),
                                                                     options),
                                                       "one");
      ASSERT_EQ(result.table.wavelength_um(), one.transmission.wavelength_um);
      for (std::size_t k = 0; k < one.transmission.value.size(); ++k) {
        ASSERT_NEAR(result.table.transmission()[i][k], one.transmission.value[k], 1e-12);
        ASSERT_NEAR(result.table.radiance()[i][k], one.radiance.value[k], 1e-11);
      }
    }
  }
}

TEST(AtmosphereTable, RangesKeepTheirTolerance) {
  const Air<double> air{model_profile(ModelAtmosphere::us_standard_1976), {HazeKind::rural, 23e3}};
  const auto found = ranges_for(air, level(0.0, 0.0), 10.0, 10e3, 1e-3, {8.0, 12.0});
  EXPECT_LE(found.error, 1e-3);
  EXPECT_LT(found.ranges_m.size(), 80u);
  const auto table = path_table(air, level(0.0, 0.0), found.ranges_m, {.band = {8.0, 12.0}}).table;
  double worst = 0.0;
  for (double range = 11.0; range < 10e3; range *= 1.037) {
    const auto exact =
        radiometry::atmosphere::path_of(spectral_path(air, level(0.0, range), {.band = {8.0, 12.0}}), "one");
    const auto at = table.at(range);
    for (std::size_t k = 0; k < exact.transmission.value.size(); ++k)
      worst = std::max(worst, std::abs(at.transmission.value[k] - exact.transmission.value[k]));
  }
  EXPECT_LE(worst, 1e-3);
}

TEST(AtmosphereTable, WhatIsLeftOutKeepsItsBound) {
  const Air<double> air{model_profile(ModelAtmosphere::mid_latitude_summer), {HazeKind::rural, 23e3}};
  const Sight<double> sight = ToSpace<double>{0.0, 0.5};
  const SpectralOptions all{.band = {8.0, 12.0}}, some{.band = {8.0, 12.0}, .components = false, .tolerance = 1e-3};
  const auto exact = spectral_path(air, sight, all), quick = spectral_path(air, sight, some);
  ASSERT_FALSE(quick.left_out.empty());
  double sum = 0.0, worst = 0.0;
  for (const LeftOut& one : quick.left_out) sum += one.bound;
  EXPECT_LE(sum, 1e-3);
  for (std::size_t i = 0; i < exact.transmission.size(); ++i) {
    ASSERT_GE(quick.transmission[i], exact.transmission[i] - 1e-15);
    worst = std::max(worst, quick.transmission[i] - exact.transmission[i]);
  }
  EXPECT_LE(worst, sum);
  EXPECT_TRUE(exact.left_out.empty());
}

TEST(AtmosphereSky, FluxOfModelAtmospheres) {
  for (const ModelAtmosphere model : {ModelAtmosphere::tropical, ModelAtmosphere::mid_latitude_summer,
                                      ModelAtmosphere::mid_latitude_winter, ModelAtmosphere::us_standard_1976}) {
    const Air<double> air{model_profile(model)};
    const auto flux = sky_flux(air, 0.0);
    const Level<double>& ground = air.profile.levels.front();
    const double hpa = 1e-8 * ground[Gas::water] * ground.pressure_pa,
                 sigma_t4 = 5.670374e-8 * std::pow(ground.temperature_k, 4);
    const double brutsaert = 1.24 * std::pow(hpa / ground.temperature_k, 1.0 / 7.0) * sigma_t4;
    std::printf("%s: %.1f W/m2 (Brutsaert %.1f), %.1f below 650, quadrature %.2f\n", air.profile.source.c_str(),
                flux.total_w_m2, brutsaert, flux.below_650_w_m2, flux.quadrature_error_w_m2);
    EXPECT_NEAR(flux.total_w_m2, brutsaert, 25.0);  // the formula is good to 10 ... 30 W/m2
    EXPECT_LT(flux.total_w_m2, sigma_t4);
    EXPECT_LT(flux.quadrature_error_w_m2, 1.0);
  }
}

TEST(AtmosphereSky, CloudsFillWhatIsMissing) {
  EXPECT_EQ(cloud_cover(300.0, 320.0, 280.0), 0.0);
  EXPECT_EQ(cloud_cover(400.0, 300.0, 280.0), 1.0);
  const double covered = 5.670374419184429e-8 * std::pow(280.0, 4), n = cloud_cover(320.0, 300.0, 280.0);
  EXPECT_NEAR((1.0 - n) * 300.0 + n * covered, 320.0, 1e-9);
}

// The flux of a cloudy sky by its own formula, and by the integral of its radiance over the hemisphere; an overcast sky
// is a blackbody at every wavenumber.
TEST(AtmosphereSky, CloudsInABand) {
  const Air<double> air{model_profile(ModelAtmosphere::mid_latitude_summer)};
  const Clouds some{.cover = 0.4, .temperature_k = 281.0}, all{.cover = 1.0, .temperature_k = 281.0};
  const SkyFlux clear = sky_flux(air, 0.0), cloudy = under_clouds(clear, some);
  EXPECT_NEAR(cloud_cover(cloudy.total_w_m2, clear.total_w_m2, 281.0), 0.4, 1e-12);
  double sum = 0.0, far = 0.0;
  const mtf::GaussRule rule = mtf::mean_rule(0.0, 1.0, 8);
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const SkyRadiance sky = under_clouds(sky_radiance(air, 0.0, std::acos(rule.node[i])), some);
    sum += 2.0 * mtf::kPi * rule.weight[i] * rule.node[i] * sky.whole;
    far += 2.0 * mtf::kPi * rule.weight[i] * rule.node[i] * sky.below_650;
  }
  // sigma T^4 holds what lies above 3500 cm^-1, 1e-4 of it, and the trapezia of the radiance err as much.
  EXPECT_NEAR(sum, cloudy.total_w_m2, 3e-4 * cloudy.total_w_m2);
  EXPECT_NEAR(far, cloudy.below_650_w_m2, 1e-4 * far);
  const SkyRadiance black = under_clouds(sky_radiance(air, 0.0, 0.3), all);
  for (std::size_t i = 0; i < black.radiance.size(); i += 50) {
    const double nu = black.wavenumber_cm[i], um = 1e4 / nu;
    const double planck = radiometry::planck(radiometry::Flux::watts, um, 281.0) * um * um * 1e-4;
    EXPECT_NEAR(black.radiance[i], planck, 1e-12 * planck) << nu;
  }
  EXPECT_EQ(under_clouds(sky_radiance(air, 0.0, 0.3), {}).whole, sky_radiance(air, 0.0, 0.3).whole);
  EXPECT_THROW(under_clouds(clear, {.cover = 1.2, .temperature_k = 280.0}), mtf::UsageError);
  EXPECT_THROW(under_clouds(clear, {.cover = 0.2, .temperature_k = 8.0}), mtf::UsageError);
}

// What is absorbed and what is scattered make the extinction: of the optical depths, wavenumber by wavenumber, and of
// the mean over a band by quadrature of them.
TEST(AtmosphereHaze, LosesAbsorptionAloneWhereScatteredLightStays) {
  for (const HazeKind kind : {HazeKind::rural, HazeKind::urban, HazeKind::maritime, HazeKind::radiation_fog}) {
    Air<double> air{.profile = model_profile(ModelAtmosphere::mid_latitude_summer),
                    .haze = {.kind = kind, .visibility_m = 4e3}};
    const Sight<double> sight = Between<double>{400.0, 0.0, 900.0};
    const SpectralOptions options{.band = {3.0, 12.0}, .components = true};
    const auto whole = spectral_path(air, sight, options);
    air.haze.loss = AerosolLoss::absorption;
    const auto absorbed = spectral_path(air, sight, options);
    const auto aerosol = static_cast<std::size_t>(Component::aerosol);
    double sum = 0.0, width = 0.0, before = 0.0;
    for (std::size_t i = 0; i < whole.transmission.size(); ++i) {
      ASSERT_LE(whole.component[aerosol][i], absorbed.component[aerosol][i] * (1.0 + 1e-12));
      const double depth = std::log(absorbed.component[aerosol][i] / whole.component[aerosol][i]);
      if (i > 0) {
        const double step = 1e4 / whole.wavenumber_cm[i - 1] - 1e4 / whole.wavenumber_cm[i];
        sum += 0.5 * step * (depth + before);
        width += step;
      }
      before = depth;
    }
    EXPECT_NEAR(scattering_depth(air, sight, options.band), sum / width, 1e-9 * sum / width);
    EXPECT_GT(sum, 0.0);
  }
  const Air<double> clear{model_profile(ModelAtmosphere::mid_latitude_summer)};
  EXPECT_EQ(scattering_depth(clear, Horizontal<double>{0.0, 1000.0}, {3.0, 5.0}), 0.0);
}

// A level where a line ends divides its last layer, no more: humid haze has the humidity of the way.
TEST(AtmosphereLimits, ALineEndsWithinALayerAsAtALevel) {
  for (const HazeKind kind : {HazeKind::rural, HazeKind::urban, HazeKind::maritime})
    for (const ModelAtmosphere model : {ModelAtmosphere::tropical, ModelAtmosphere::mid_latitude_summer})
      for (const double top_m : {300.0, 500.0, 1500.0}) {
        const Air<double> air{.profile = model_profile(model), .haze = {.kind = kind, .visibility_m = 5e3}};
        Air<double> divided = air;
        auto& levels = divided.profile.levels;
        levels.insert(std::ranges::find_if(levels, [&](const auto& level) { return level.altitude_m > top_m; }),
                      level_at(air.profile, top_m));
        const Sight<double> sight = Between<double>{0.0, top_m, 3000.0};
        const auto whole = spectral_path(air, sight), parts = spectral_path(divided, sight);
        for (std::size_t i = 0; i < whole.transmission.size(); ++i)
          ASSERT_NEAR(whole.transmission[i], parts.transmission[i], 1.3e-3) << top_m << " " << whole.wavenumber_cm[i];
      }
}

TEST(AtmosphereLimits, LinesAndFogBeyondTheirKindAreSaid) {
  const Air<double> air{model_profile(ModelAtmosphere::us_standard_1976)};
  const auto of_line = [&](double altitude_m, double range_m) {
    return limits_of(air, {8.0, 12.0}, Horizontal<double>{altitude_m, range_m});
  };
  ASSERT_EQ(of_line(0.0, 500e3).size(), 1U);
  expect_says(of_line(0.0, 500e3)[0], {"at 0 m", "farther than 0 km", "500 km"});
  EXPECT_TRUE(of_line(0.0, 50e3).empty());
  EXPECT_TRUE(of_line(10e3, 500e3).empty());
  EXPECT_FALSE(of_line(10e3, 1000e3).empty());
  // At 1 km haze takes what it does at the sea, at 2 km and more hardly anything: kept as the models have it, and said.
  const Air<double> hazy{.profile = air.profile, .haze = {.kind = HazeKind::rural, .visibility_m = 5e3}};
  for (const double altitude_m : {0.0, 1000.0, 2317.0}) {
    const auto said = limits_of(hazy, {8.0, 12.0}, Horizontal<double>{altitude_m, 5e3});
    EXPECT_EQ(says(said, "haze thins above 1 km; at 2317 m"), altitude_m > 2000.0) << altitude_m;
    EXPECT_EQ(said.empty(), altitude_m < 2000.0) << altitude_m;
  }
  EXPECT_TRUE(limits_of(hazy, {8.0, 12.0}, Between<double>{10e3, 0.0, 20e3}).empty());
  const auto of_fog = [&](double visibility_m) {
    return limits_of({.profile = air.profile, .haze = {.kind = HazeKind::radiation_fog, .visibility_m = visibility_m}},
                     {8.0, 12.0});
  };
  EXPECT_EQ(of_fog(500.0).size() + 1, of_fog(100e3).size());
  expect_says(of_fog(100e3).back(), {"100 km", "haze"});
}

TEST(AtmosphereLimits, AirBeyondWhatWasFittedIsSaid) {
  const auto said = [](const Air<double>& air, const std::string& part) {
    for (const std::string& text : limits_of(air, {8.0, 12.0}))
      if (text.find(part) != std::string::npos) return true;
    return false;
  };
  EXPECT_TRUE(limits_of(Air<double>{model_profile(ModelAtmosphere::us_standard_1976)}, {8.0, 12.0}).empty());
  EXPECT_TRUE(said({surface_air(101325.0, 333.0, 10.0)}, "333 K at 0 m is warmer"));
  EXPECT_TRUE(said({surface_air(101325.0, 190.0, 10.0)}, "190 K at 0 m is colder"));
  EXPECT_TRUE(said({surface_air(101325.0, 315.0, 95.0)}, "g/m3 of vapour"));
  EXPECT_TRUE(said({.profile = surface_air(101325.0, 290.0, 99.5), .haze = {.kind = HazeKind::rural}}, "above 99 %"));
  EXPECT_FALSE(said({surface_air(101325.0, 290.0, 99.5)}, "above 99 %"));
}

}  // namespace
