// SPDX-License-Identifier: Apache-2.0
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "radiometry/atmosphere/derivatives.h"

// Derivatives of paths by range, humidity, visibility and temperature against central differences.

namespace {

using namespace radiometry::atmosphere;
using Jet = ceres::Jet<double, 4>;

const radiometry::Interval kBand{3.0, 12.0};

template <class S>
SpectralPath<S> horizontal(const S& range, const S& humidity, const S& visibility, const S& kelvin) {
  const Air<S> air{.profile = surface_air(S(101325.0), kelvin, humidity),
                   .haze = {.kind = HazeKind::rural, .visibility_m = visibility}};
  return spectral_path(air, Sight<S>(Horizontal<S>{0.0, range}), {.band = kBand});
}

template <class S>
SpectralPath<S> slant(const S& range, const S& humidity, const S& visibility, const S& kelvin) {
  const auto profile = with_scalar<S>(model_profile(ModelAtmosphere::mid_latitude_summer));
  const Air<S> air{.profile = with_surface(profile, kelvin, humidity),
                   .haze = {.kind = HazeKind::maritime, .visibility_m = visibility}};
  return spectral_path(air, Sight<S>(Between<S>{2300.0, 100.0, range}), {.band = kBand});
}

using Model = std::function<SpectralPath<double>(const std::array<double, 4>&)>;

void compare(const SpectralPath<Jet>& jets, const Model& model, const std::array<double, 4>& at) {
  const auto value = model(at);
  for (std::size_t i = 0; i < value.transmission.size(); ++i)
    ASSERT_NEAR(jets.transmission[i].a, value.transmission[i], 1e-14);
  for (std::size_t p = 0; p < 4; ++p) {
    const double h = 1e-5 * at[p];
    auto up = at, down = at;
    up[p] += h, down[p] -= h;
    const auto more = model(up), less = model(down);
    double most = 0.0, worst = 0.0, most_radiance = 0.0, worst_radiance = 0.0;
    for (std::size_t i = 0; i < value.transmission.size(); ++i) {
      const double slope = at[p] * jets.transmission[i].v[static_cast<int>(p)];
      most = std::max(most, std::abs(slope));
      worst = std::max(worst, std::abs(slope - at[p] * (more.transmission[i] - less.transmission[i]) / (2.0 * h)));
    }
    for (std::size_t i = 0; i < value.radiance.size(); ++i) {
      const double slope = at[p] * jets.radiance[i].v[static_cast<int>(p)];
      most_radiance = std::max(most_radiance, std::abs(slope));
      worst_radiance =
          std::max(worst_radiance, std::abs(slope - at[p] * (more.radiance[i] - less.radiance[i]) / (2.0 * h)));
    }
    EXPECT_GT(most, 1e-3) << p;
    EXPECT_LE(worst, 1e-7 + 1e-6 * most)
        << p;  // differences: 1e-10 of the third derivative, rounding of 1e-16 over 1e-5
    EXPECT_LE(worst_radiance, 1e-9 + 2e-6 * most_radiance) << p;
  }
}

TEST(AtmosphereDerivatives, HorizontalPath) {
  const std::array<double, 4> at{1700.0, 63.0, 12e3, 291.0};
  compare(
      horizontal(Jet(at[0], 0), Jet(at[1], 1), Jet(at[2], 2), Jet(at[3], 3)),
      [](const auto& x) { return horizontal(x[0], x[1], x[2], x[3]); }, at);
}

TEST(AtmosphereDerivatives, SlantPath) {
  const std::array<double, 4> at{5200.0, 63.0, 12e3, 291.0};
  compare(
      slant(Jet(at[0], 0), Jet(at[1], 1), Jet(at[2], 2), Jet(at[3], 3)),
      [](const auto& x) { return slant(x[0], x[1], x[2], x[3]); }, at);
}

template <class S>
SpectralPath<S> upward(const S& zenith, const S& humidity, const S& visibility, const S& kelvin) {
  const auto profile = with_scalar<S>(model_profile(ModelAtmosphere::us_standard_1976));
  const Air<S> air{.profile = with_surface(profile, kelvin, humidity),
                   .haze = {.kind = HazeKind::rural, .visibility_m = visibility}};
  return spectral_path(air, Sight<S>(ToSpace<S>{50.0, zenith}), {.band = kBand});
}

TEST(AtmosphereDerivatives, ByZenithAngle) {
  for (const double zenith : {0.3, 1.1, 1.45}) {
    const std::array<double, 4> at{zenith, 48.0, 20e3, 286.0};
    compare(
        upward(Jet(at[0], 0), Jet(at[1], 1), Jet(at[2], 2), Jet(at[3], 3)),
        [](const auto& x) { return upward(x[0], x[1], x[2], x[3]); }, at);
  }
}

// At range 0 the slope by range is that at 1 m, and nothing else matters.
TEST(AtmosphereDerivatives, AtRangeZero) {
  const auto zero = horizontal(Jet(0.0, 0), Jet(63.0, 1), Jet(12e3, 2), Jet(291.0, 3));
  const auto one = horizontal(Jet(1.0, 0), Jet(63.0, 1), Jet(12e3, 2), Jet(291.0, 3));
  const auto slanted = slant(Jet(2200.0001, 0), Jet(63.0, 1), Jet(12e3, 2), Jet(291.0, 3));
  for (std::size_t i = 0; i < zero.transmission.size(); ++i) {
    ASSERT_EQ(zero.transmission[i].a, 1.0);
    ASSERT_TRUE(std::isfinite(zero.transmission[i].v[0]) && std::isfinite(slanted.transmission[i].v[0]));
    ASSERT_NEAR(zero.transmission[i].v[0] * one.transmission[i].a, one.transmission[i].v[0],
                1e-6 * std::abs(one.transmission[i].v[0]) + 1e-12);
    for (int p = 1; p < 4; ++p) ASSERT_EQ(zero.transmission[i].v[p], 0.0);
  }
}

}  // namespace
