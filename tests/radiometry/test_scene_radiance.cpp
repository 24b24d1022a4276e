// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/light/constants.h"
#include "radiometry/light/scene_radiance.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

using mtf::Image;
using test::flat;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

SpectralCamera camera() {
  return {.band = {3.0, 5.0},
          .optics = {constant_spectrum("optics", 0.85)},
          .cold_filter = {make_spectrum("filter", {3.3, 3.5, 4.7, 4.9}, {0.0, 0.9, 0.88, 0.0}, 1.0)},
          .quantum_efficiency = {make_spectrum("qe", {3.0, 3.4, 4.6, 5.2}, {0.1, 0.7, 0.8, 0.0}, 1.0)}};
}

SceneBand open_band() { return {{3.0, 5.0}, {}}; }

Image of(std::initializer_list<float> values) {
  Image image(static_cast<std::int64_t>(values.size()), 1);
  std::copy(values.begin(), values.end(), image.data());
  return image;
}

void expect_close(double value, double exact, double relative) {
  EXPECT_NEAR(value, exact, relative * std::abs(exact));
}

TEST(SceneRadiance, a_surface_as_the_camera_equation_has_it) {
  const Spectrum emissivity = make_spectrum("paint", {2.0, 4.0, 6.0}, {0.7, 0.9, 0.95}, 1.0);
  const Path path = absorbing_path(make_spectrum("tau", {3.0, 4.0, 5.0}, {0.8, 0.6, 0.7}), 285.0);
  const SpectralCamera mwir = camera();
  Image plane = of({250.0F, 300.0F, 1200.0F});
  radiance_of_temperature(plane.view(), scene_band(mwir, path), {.emissivity = emissivity, .surroundings_k = 290.0});
  for (const auto& [x, t] : {std::pair{0, 250.0}, {1, 300.0}, {2, 1200.0}}) {
    const Surface surface{t, emissivity, 290.0};
    expect_close(static_cast<double>(plane.at(x, 0)), band_radiances(mwir, surface, path, {}).scene, 1.7e-7);
  }
  EXPECT_EQ(weighted_path_radiance(mwir, path), band_radiances(mwir, Surface{}, path, {}).path);
}

TEST(SceneRadiance, emissivity_plane_as_a_grey_curve) {
  Image curve = of({300.0F, 310.0F, 0.0F}), plane = curve.clone();
  const Image emissivity = of({0.6F, 1.0F, 0.0F});
  radiance_of_temperature(plane.view(), scene_band(camera()), {.plane = emissivity.view(), .surroundings_k = 280.0});
  for (const std::int64_t x : {0, 1, 2}) {
    Image one = of({curve.at(x, 0)});
    const SurfaceFinish grey{.emissivity = constant_spectrum("grey", static_cast<double>(emissivity.at(x, 0))),
                             .surroundings_k = 280.0};
    radiance_of_temperature(one.view(), scene_band(camera()), grey);
    expect_close(static_cast<double>(plane.at(x, 0)), static_cast<double>(one.at(0, 0)), 2e-7);
  }
}

TEST(SceneRadiance, one_kelvin_beside_6000_and_beyond) {
  Image plane = of({0.0F, 1.0F, 300.0F, 6000.0F, 1e9F, std::nanf(""), kInfinity});
  radiance_of_temperature(plane.view(), open_band());
  EXPECT_EQ(plane.at(0, 0), 0.0F);
  EXPECT_EQ(plane.at(1, 0), 0.0F);
  for (const auto& [x, t] : {std::pair{2, 300.0}, {3, 6000.0}, {4, 1e9}})
    expect_close(static_cast<double>(plane.at(x, 0)), band_radiance(Flux::photons, 3.0, 5.0, t), 1.7e-7);
  EXPECT_TRUE(std::isnan(plane.at(5, 0)));
  EXPECT_EQ(plane.at(6, 0), kInfinity);
  Image cold = flat(3, 2, 0.0F);
  radiance_of_temperature(cold.view(), open_band(), {.surroundings_k = 300.0});
  for (const float value : test::samples(cold)) EXPECT_EQ(value, 0.0F);
}

TEST(SceneRadiance, pieces_of_a_plane_give_the_bits_of_all_of_it) {
  const Spectrum emissivity = make_spectrum("paint", {2.0, 4.0, 6.0}, {0.7, 0.9, 0.95}, 1.0);
  Image whole(40, 1);
  for (std::int64_t x = 0; x < 40; ++x) whole.at(x, 0) = 250.0F + 1.7F * static_cast<float>(x);
  const TemperatureRadiance light(scene_band(camera()), emissivity, 290.0, 250.0, static_cast<double>(whole.at(39, 0)));
  Image pieces = whole.clone();
  for (std::int64_t x = 0; x < 40; x += 8) light.apply({pieces.data() + x, 8, 1, 40});
  radiance_of_temperature(whole.view(), scene_band(camera()), {.emissivity = emissivity, .surroundings_k = 290.0});
  for (std::int64_t x = 0; x < 40; ++x) EXPECT_EQ(pieces.at(x, 0), whole.at(x, 0)) << x;
  Image below = of({-3.0F, kInfinity});
  light.apply(below.view());
  Image zero = of({0.0F});
  light.apply(zero.view());
  EXPECT_EQ(below.at(0, 0), zero.at(0, 0));
  EXPECT_EQ(below.at(1, 0), kInfinity);
  expect_refused({"surroundings"}, [&] { TemperatureRadiance(scene_band(camera()), emissivity, -1.0, 250.0, 300.0); });
}

TEST(SceneRadiance, same_for_any_threads) {
  Image plane(257, 100);
  for (std::int64_t i = 0; i < plane.size(); ++i) plane.data()[i] = 200.0F + 0.01F * static_cast<float>(i);
  Image other = plane.clone();
  radiance_of_temperature(plane.view(), scene_band(camera()));
  radiance_of_temperature(other.view(), scene_band(camera()), {}, {.threads = 2});
  for (std::int64_t i = 0; i < plane.size(); ++i) ASSERT_EQ(plane.data()[i], other.data()[i]);
}

TEST(SceneRadiance, watts_and_photons_agree) {
  // The same blackbody scene as temperature, as band radiance in watts and in photons, and as spectral channels.
  const SceneBand scene = scene_band(camera());
  const BandResponse response(scene.band, scene.curves);
  for (const double t : {200.0, 300.0, 1000.0, 5800.0}) {
    const double exact = response.radiance(Flux::photons, t);
    for (const Flux flux : {Flux::watts, Flux::photons})
      expect_close(light_per_radiance(flux, scene, t) * band_radiance(flux, 3.0, 5.0, t), exact, 1e-12);
  }
  // Constant in photons: n photons per um are n h c / lambda watts per um.
  const double watts = kPhotonEnergy_j_um * std::log(5.0 / 3.0), photons = 2.0;
  expect_close(light_per_radiance(Flux::watts, scene, {}) * watts,
               light_per_radiance(Flux::photons, scene, {}) * photons, 1e-12);
  expect_close(light_per_radiance(Flux::photons, scene, {}) * photons, response.integral(), 1e-12);
  expect_close(light_per_radiance(Flux::photons, open_band(), {}), 1.0, 1e-15);
  const SceneBand narrow{{4.0, 4.0 + 1e-9}, {}};
  expect_close(light_per_radiance(Flux::watts, narrow, {}), 4.0 / kPhotonEnergy_j_um, 1e-9);
}

TEST(SceneRadiance, shape_of_a_source_matters) {
  const SceneBand scene = scene_band(camera());
  EXPECT_GT(
      std::abs(light_per_radiance(Flux::watts, scene, 250.0) / light_per_radiance(Flux::watts, scene, 6000.0) - 1.0),
      0.05);
  expect_refused({"source_temperature of 1 K", "3 um to 5 um"}, [&] { light_per_radiance(Flux::watts, scene, 1.0); });
  expect_refused({"-4 K"}, [&] { light_per_radiance(Flux::watts, scene, -4.0); });
  expect_refused({"nan K"}, [&] { light_per_radiance(Flux::watts, scene, std::nan("")); });
}

TEST(SceneRadiance, spectral_channels_are_lines_between_them) {
  const SceneBand scene = scene_band(camera());
  const std::vector<double> wavelength{2.5, 3.4, 3.9, 4.2, 4.8, 5.5}, value{1.0, 2.0, 0.5, 3.0, 1.0, 0.0};
  const ChannelWeights weights = channel_weights(scene, wavelength);
  EXPECT_EQ(weights.used.lo_um, 3.3);
  EXPECT_EQ(weights.used.hi_um, 4.9);
  double sum = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) sum += weights.weight[i] * value[i];
  std::vector<Spectrum> curves = scene.curves;
  curves.push_back(make_spectrum("scene", wavelength, value));
  curves.push_back(photons_per_joule(scene.band));
  expect_close(sum, BandResponse(scene.band, curves).integral(), 1e-13);
}

TEST(SceneRadiance, dense_channels_of_a_blackbody_give_its_radiance) {
  const SceneBand scene = scene_band(camera());
  std::vector<double> wavelength;
  for (int i = 0; i <= 400; ++i) wavelength.push_back(3.0 + 0.005 * i);
  const std::vector<double> weight = channel_weights(scene, wavelength).weight;
  double sum = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * planck(Flux::watts, wavelength[i], 300.0);
  expect_close(sum, BandResponse(scene.band, scene.curves).radiance(Flux::photons, 300.0), 1e-5);
}

TEST(SceneRadiance, many_channels_and_samples_take_no_longer_than_both) {
  std::vector<double> wavelength, ones;
  for (int i = 0; i <= 30000; ++i) {
    wavelength.push_back(2.9 + 8e-5 * i);
    ones.push_back(0.5 + 0.25 * (i % 2));
  }
  const SceneBand scene{{3.0, 5.0}, {make_spectrum("qe", wavelength, ones)}};
  const std::vector<double> weight = shape_weights(scene, wavelength, {}).weight;
  double sum = 0.0;
  for (const double w : weight) sum += w;
  expect_close(sum, BandResponse(scene.band, scene.curves).integral(), 1e-11);
}

TEST(SceneRadiance, one_channel_is_a_constant_over_the_band) {
  const double wavelength = 4.0;
  const ChannelWeights weights = channel_weights(open_band(), {&wavelength, 1});
  expect_close(weights.weight.at(0), (25.0 - 9.0) / 2.0 / kPhotonEnergy_j_um, 1e-14);  // integral of lambda / hc
  EXPECT_EQ(weights.used.lo_um, 3.0);
}

TEST(SceneRadiance, channels_are_summed) {
  const Image a = of({1.0F, 2.0F, std::nanf("")}), b = of({0.5F, kInfinity, 1.0F});
  Image out(3, 1);
  const std::vector<mtf::ImageView<const float>> channels{a.view(), b.view()};
  const std::vector<double> weight{2.0, 4.0};
  radiance_of_channels(channels, weight, out.view());
  EXPECT_EQ(out.at(0, 0), 4.0F);
  EXPECT_EQ(out.at(1, 0), kInfinity);
  EXPECT_TRUE(std::isnan(out.at(2, 0)));
  expect_refused({"2 spectral planes", "1 weights"}, [&] {
    radiance_of_channels(channels, {weight.data(), 1}, out.view());
  });
  Image small(2, 1);
  expect_refused({"3 x 1", "2 x 1"}, [&] { radiance_of_channels(channels, weight, small.view()); });
}

TEST(SceneRadiance, below_zero_is_refused_or_taken_as_zero) {
  Image plane = of({1.0F, -2.0F, std::nanf(""), -kInfinity, -0.0F});
  const auto untouched = [&] { EXPECT_EQ(plane.at(0, 0), 1.0F); };
  expect_refused({"radiance", "2 pixels below 0", "column 1, row 0", "-2"},
                 [&] { radiance_of_band(plane.view(), 3.0); });
  untouched();
  expect_refused({"temperature", "2 pixels below 0 K", "column 1"},
                 [&] { radiance_of_temperature(plane.view(), open_band()); });
  untouched();
  Image out(5, 1);
  const std::vector<mtf::ImageView<const float>> channels{plane.view()};
  const double one = 1.0;
  expect_refused({"spectral radiance", "2 pixels"}, [&] { radiance_of_channels(channels, {&one, 1}, out.view()); });
  const PlaneOptions clamp{.negative = Negative::clamp};
  radiance_of_channels(channels, {&one, 1}, out.view(), clamp);
  radiance_of_band(plane.view(), 3.0, clamp);
  EXPECT_EQ(plane.at(0, 0), 3.0F);
  for (const std::int64_t x : {1, 3}) {
    EXPECT_EQ(plane.at(x, 0), 0.0F);
    EXPECT_EQ(out.at(x, 0), 0.0F);
  }
  EXPECT_TRUE(std::isnan(plane.at(2, 0)));
  Image cold = of({-3.0F, 300.0F});
  radiance_of_temperature(cold.view(), open_band(), {}, clamp);
  EXPECT_EQ(cold.at(0, 0), 0.0F);
}

TEST(SceneRadiance, refusals) {
  Image plane = of({300.0F, 300.0F});
  const Image bad = of({0.5F, 1.5F}), other = of({1.0F}), nan = of({std::nanf(""), 1.0F});
  const auto with = [&](const Image& emissivity) {
    return [&] { radiance_of_temperature(plane.view(), open_band(), {.plane = emissivity.view()}); };
  };
  expect_refused({"emissivity", "1 pixel outside 0 to 1", "column 1", "1.5"}, with(bad));
  expect_refused({"emissivity", "1 x 1", "2 x 1"}, with(other));
  expect_refused({"emissivity", "column 0", "nan"}, with(nan));
  expect_refused({"surroundings of -1 K"},
                 [&] { radiance_of_temperature(plane.view(), open_band(), {.surroundings_k = -1.0}); });
  expect_refused({"paint", "above 1"}, [&] {
    radiance_of_temperature(plane.view(), open_band(), {.emissivity = Spectrum{"paint", {1.0}, {1.5}}});
  });
  expect_refused({"6 um to 8 um", "3 um to 5 um"}, [] { channel_weights(open_band(), std::vector{6.0, 7.0, 8.0}); });
  expect_refused({"spectral channels", "increase"}, [] { channel_weights(open_band(), std::vector{4.0, 3.0}); });
  EXPECT_EQ(plane.at(0, 0), 300.0F);
}

}  // namespace
}  // namespace radiometry
