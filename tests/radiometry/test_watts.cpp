// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "radiometry/light/constants.h"
#include "radiometry/light/path_planes.h"
#include "radiometry/light/scene_radiance.h"

// The light of a thermal detector against that of a photon detector. An absorptance proportional to the wavelength,
// lambda/14 um, takes h c/14 um of every photon, whatever its wavelength: watts and photons are the same then but for
// that factor.

namespace radiometry {
namespace {

constexpr double kLongest_um = 14.0, kJoules = kPhotonEnergy_j_um / kLongest_um;

SpectralCamera camera(Flux flux) {
  SpectralCamera camera;
  camera.band = {8.0, kLongest_um};
  camera.flux = flux;
  camera.optics = {make_spectrum("optics", {7.0, 10.0, 15.0}, {0.4, 0.9, 0.6})};
  camera.cold_filter = {make_spectrum("window", {7.5, 9.0, 14.5}, {0.9, 0.95, 0.8})};
  if (flux == Flux::watts)
    camera.quantum_efficiency = {make_spectrum("absorptance", {4.0, kLongest_um}, {4.0 / kLongest_um, 1.0})};
  return camera;
}

Path hazy() {
  Path path = absorbing_path(make_spectrum("air", {7.0, 15.0}, {0.8, 0.5}), 285.0);
  path.radiance = make_spectrum("scattered", {7.0, 15.0}, {0.1, 0.3});
  return path;
}

void expect_same(double watts, double photons, double relative = 1e-12) {
  EXPECT_GT(photons, 0.0);
  EXPECT_NEAR(watts, kJoules * photons, relative * kJoules * photons);
}

TEST(Watts, agree_with_photons_through_scene_path_and_camera) {
  const SpectralCamera watts = camera(Flux::watts), photons = camera(Flux::photons);
  const Surface grey{300.0, make_spectrum("paint", {7.0, 15.0}, {0.7, 0.95}), 280.0};
  const CameraEmission emission{.optics_k = 293.0, .stop_k = 296.0};
  const BandRadiances<double> w = band_radiances(watts, grey, hazy(), emission);
  const BandRadiances<double> q = band_radiances(photons, grey, hazy(), emission);
  expect_same(w.scene, q.scene);
  expect_same(w.path, q.path);
  expect_same(w.optics, q.optics);
  expect_same(w.stop, q.stop);
  expect_same(scene_derivative(watts, grey, hazy()), scene_derivative(photons, grey, hazy()));
  for (const double warmer_k : {1e-4, 20.0})
    expect_same(scene_difference(watts, grey, hazy(), warmer_k), scene_difference(photons, grey, hazy(), warmer_k));
}

TEST(Watts, agree_with_photons_in_planes) {
  const SceneBand watts = scene_band(camera(Flux::watts), hazy()), photons = scene_band(camera(Flux::photons), hazy());
  mtf::Image in_watts(3, 1), in_photons(3, 1);
  for (std::int64_t x = 0; x < 3; ++x) in_watts.at(x, 0) = in_photons.at(x, 0) = 280.0F + 30.0F * static_cast<float>(x);
  radiance_of_temperature(in_watts.view(), watts);
  radiance_of_temperature(in_photons.view(), photons);
  for (std::int64_t x = 0; x < 3; ++x)
    expect_same(static_cast<double>(in_watts.at(x, 0)), static_cast<double>(in_photons.at(x, 0)), 4e-7);
  for (const Flux given : {Flux::watts, Flux::photons})
    expect_same(light_per_radiance(given, watts, 300.0), light_per_radiance(given, photons, 300.0));
  const std::vector<double> channels{8.0, 9.5, 12.0, 14.0};
  const ChannelWeights w = channel_weights(watts, channels), q = channel_weights(photons, channels);
  for (std::size_t i = 0; i < channels.size(); ++i) expect_same(w.weight[i], q.weight[i]);
  const PathTable table("table", {100.0, 1000.0}, {8.0, 14.0}, {{0.9, 0.8}, {0.5, 0.3}}, {{0.1, 0.1}, {0.4, 0.5}});
  const RangeTable ranges_w(scene_band(camera(Flux::watts)), table, 300.0);
  const RangeTable ranges_q(scene_band(camera(Flux::photons)), table, 300.0);
  EXPECT_NEAR(ranges_w.transmission(700.0), ranges_q.transmission(700.0), 1e-12);
  expect_same(ranges_w.radiance(700.0), ranges_q.radiance(700.0));
}

TEST(Watts, of_an_even_spectrum_are_even_in_watts) {
  const SceneBand open{{8.0, 14.0}, {}, Flux::watts};
  EXPECT_NEAR(light_per_radiance(Flux::watts, open, {}), 1.0, 1e-15);
  // One watt per um has lambda/(h c) photons per um, in the mean those of 11 um.
  EXPECT_NEAR(light_per_radiance(Flux::photons, open, {}), kPhotonEnergy_j_um / 11.0, 1e-15 * kPhotonEnergy_j_um);
}

TEST(Watts, weigh_the_wavelengths_of_the_otf) {
  const SceneBand watts = scene_band(camera(Flux::watts)), photons = scene_band(camera(Flux::photons));
  const BandResponse w(watts.band, watts.curves), q(photons.band, photons.curves);
  const mtf::WavelengthNodes by_w = w.electron_nodes(5, 300.0, Flux::watts), by_q = q.electron_nodes(5, 300.0);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(by_w.wavelength_um[i], by_q.wavelength_um[i], 1e-11);
    EXPECT_NEAR(by_w.weight[i], by_q.weight[i], 1e-11);
  }
  EXPECT_NEAR(w.electron_rate(300.0, Flux::watts).density(10.0), q.electron_rate(300.0).density(10.0), 1e-12);
}

}  // namespace
}  // namespace radiometry
