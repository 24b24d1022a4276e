// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "mtf/math/quadrature.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/constants.h"
#include "radiometry/light/spectral_signal.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

Camera<double> mwir_camera() {
  return {.f_number = 2.5,
          .obscuration = 0.3,
          .transmission = 0.85,
          .cold_transmission = 0.9,
          .optics_emissivity = 0.1,
          .obscuration_emissivity = 0.8,
          .stop_emissivity = 0.95};
}
Pixel<double> mwir_pixel() {
  return {.width_um = 15,
          .height_um = 14,
          .quantum_efficiency = 0.75,
          .integration_s = 0.01,
          .dark_e_s = 2e5,
          .full_well_e = 7e6};
}

/// Everything but the plain numbers of camera and pixel.
SpectralCamera mwir_curves() {
  return {.band = {3.0, 5.0},
          .optics = {make_spectrum("lens", {2.0, 4.0, 6.0}, {0.9, 0.95, 0.8}, 1.0)},
          .cold_filter = {make_spectrum("filter", {3.3, 3.5, 4.7, 4.9}, {0.0, 0.9, 0.88, 0.0}, 1.0)},
          .quantum_efficiency = {make_spectrum("qe", {1.0, 3.4, 4.6, 5.2}, {0.3, 0.9, 0.95, 0.0}, 1.0)}};
}

// In a cavity of one temperature, all surfaces black, the pixel receives what a blackbody sends over the hemisphere.
TEST(Signal, a_cavity_of_one_temperature_is_black) {
  Camera<double> camera = mwir_camera();
  camera.transmission = 1.0 - camera.optics_emissivity;  // Kirchhoff
  camera.cold_transmission = camera.obscuration_emissivity = camera.stop_emissivity = 1.0;
  Pixel<double> pixel = mwir_pixel();
  pixel.dark_e_s = 0.0;
  const double radiance = band_radiance(Flux::photons, 3.0, 5.0, 300.0);
  const double hemisphere = mtf::kPi * radiance * pixel.quantum_efficiency * pixel.area_m2() * pixel.integration_s;
  for (camera.cone = Cone::tangent; const double n : {2.5, 0.7, 2.5, 0.5, 1000.0}) {
    camera.f_number = n;
    const Signal<double> s = signal(camera, pixel, {radiance, 0.0, radiance, radiance});
    EXPECT_NEAR(s.total_e(), hemisphere, 1e-14 * hemisphere) << n;
    if (n == 0.7) camera.cone = Cone::sine;
  }
}

TEST(Signal, solid_angles) {
  for (const double n : {0.5, 1.0, 2.5, 1e6})
    for (const Cone cone : {Cone::tangent, Cone::sine}) {
      const Camera<double> camera{.f_number = n, .cone = cone};
      EXPECT_NEAR(cone_sr(camera) + around_cone_sr(camera), mtf::kPi, 1e-15);
      const double angle = cone == Cone::sine ? std::asin(0.5 / n) : std::atan(0.5 / n);
      // What falls on the pixel from within the cone: the integral of cos over its solid angle.
      const mtf::GaussRule rule = mtf::mean_rule(0.0, angle, 24);
      double projected = 0.0;
      for (std::size_t i = 0; i < rule.node.size(); ++i)
        projected += rule.weight[i] * angle * 2.0 * mtf::kPi * std::cos(rule.node[i]) * std::sin(rule.node[i]);
      EXPECT_NEAR(cone_sr(camera) / projected, 1.0, 1e-13) << n;
    }
  // Irradiance of an aplanatic lens: pi L (1 - eta^2)/(4 N^2).
  const Camera<double> aplanat{.f_number = 2.0, .obscuration = 0.3, .cone = Cone::sine};
  EXPECT_NEAR(irradiance(aplanat, 1.0), mtf::kPi * 0.91 / 16.0, 1e-16);
  const Camera<double> fast{.f_number = 0.4999, .cone = Cone::sine};
  for (const auto& of : {cone_sr<double>, around_cone_sr<double>})
    expect_refused({"optics.cone", "0.4999", "0.5 or above", "tangent"}, [&] { of(fast); });
}

// Photons against watts, through all curves, the path included.
TEST(Signal, photon_and_watt_routes_agree) {
  const SpectralCamera curves = mwir_curves();
  const Path path = absorbing_path(make_spectrum("tau", {2.0, 4.2, 4.3, 6.0}, {0.9, 0.7, 0.1, 0.8}), 285.0);
  const Surface surface{
      .temperature_k = 305.0, .emissivity = make_spectrum("paint", {3.0, 5.0}, {0.9, 0.8}), .surroundings_k = 270.0};
  const Camera<double> camera = mwir_camera();
  const Pixel<double> pixel = mwir_pixel();
  const BandRadiances<double> photons = band_radiances(curves, surface, path, {300.0, 80.0});

  const auto watts = [&](std::vector<Spectrum> factors, double temperature_k) {
    factors.push_back(curves.optics[0]);
    factors.push_back(curves.cold_filter[0]);
    factors.push_back(curves.quantum_efficiency[0]);
    factors.push_back(photons_per_joule(curves.band));
    return BandResponse(curves.band, factors).radiance(Flux::watts, temperature_k);
  };
  const double scene = watts({path.transmission, surface.emissivity}, 305.0) +
                       watts({path.transmission, complement(surface.emissivity)}, 270.0);
  const double air = watts({path.emissivity}, 285.0);
  EXPECT_NEAR(photons.scene, scene, 1e-13 * scene);
  EXPECT_NEAR(photons.path, air, 1e-13 * air);
  const Signal<double> s = signal(camera, pixel, photons);
  const double electrons = irradiance(camera, scene + air) * pixel.quantum_efficiency * pixel.area_m2() * 0.01;
  EXPECT_NEAR(s.scene_e + s.path_e, electrons, 1e-12 * electrons);
}

TEST(Signal, given_path_radiance_and_plain_numbers_equal_flat_curves) {
  SpectralCamera curves{
      .band = {8.0, 12.0}, .optics = {constant_spectrum("lens", 0.85)}, .cold_filter = {}, .quantum_efficiency = {}};
  const Surface black{.temperature_k = 300.0};
  const BandRadiances<double> r = band_radiances(curves, black, constant_path(0.7, 2.0), {290.0, 77.0});
  const double scene = 0.85 * 0.7 * band_radiance(Flux::photons, 8.0, 12.0, 300.0);
  EXPECT_NEAR(r.scene, scene, 1e-14 * scene);
  const double path = 0.85 * 2.0 * 0.5 * (144.0 - 64.0) / kPhotonEnergy_j_um;
  EXPECT_NEAR(r.path, path, 1e-14 * path);
  EXPECT_NEAR(r.optics, band_radiance(Flux::photons, 8.0, 12.0, 290.0), 1e-14 * r.optics);
  EXPECT_NEAR(r.stop, band_radiance(Flux::photons, 8.0, 12.0, 77.0), 1e-14 * r.stop);
  const double slope = 0.85 * 0.7 * band_derivative(Flux::photons, 8.0, 12.0, 300.0);
  EXPECT_NEAR(scene_derivative(curves, black, constant_path(0.7, 2.0)), slope, 1e-14 * slope);
}

// The stop shines on the detector past the filter: its electrons by the quantum efficiency in the band, or everywhere
// where the band does not cut it. References by mpmath, 30 digits: quad over the product of lines and Planck's law.
TEST(Signal, no_filter_stands_before_the_stop) {
  const SpectralCamera curves = mwir_curves();
  const Surface black{.temperature_k = 300.0};
  const BandRadiances<double> r = band_radiances(curves, black, Path{}, {.stop_k = 150.0});
  EXPECT_NEAR(r.stop / 838876680468690.53671, 1.0, 1e-14);
  EXPECT_EQ(r.optics, 0.0);
  const CameraEmission beyond{.stop_k = 150.0, .stop_band = StopBand::response};
  EXPECT_NEAR(band_radiances(curves, black, Path{}, beyond).stop / 1013234376740708.9599, 1.0, 1e-14);
  SpectralCamera numbers = curves;
  numbers.quantum_efficiency.clear();
  expect_refused({"optics.stop_band", "quantum_efficiency", "CSV"},
                 [&] { band_radiances(numbers, black, Path{}, beyond); });
  numbers.quantum_efficiency = {constant_spectrum("qe", 0.7)};
  expect_refused({"optics.stop_band"}, [&] { band_radiances(numbers, black, Path{}, beyond); });
}

Path mwir_path() { return absorbing_path(make_spectrum("tau", {2.0, 4.2, 4.3, 6.0}, {0.9, 0.7, 0.1, 0.8}), 285.0); }
Surface painted() {
  return {
      .temperature_k = 305.0, .emissivity = make_spectrum("paint", {3.0, 5.0}, {0.9, 0.8}), .surroundings_k = 270.0};
}

// By mpmath as above: the scene's photons with and without the quantum efficiency.
TEST(Signal, mean_quantum_efficiency_over_the_photons_of_the_scene) {
  SpectralCamera curves = mwir_curves();
  EXPECT_NEAR(mean_quantum_efficiency(curves, painted(), mwir_path()), 0.89125574483244912157, 1e-14);
  curves.quantum_efficiency = {make_spectrum("flat", {1.0, 3.7, 6.0}, {0.7, 0.7, 0.7}, 1.0)};
  EXPECT_NEAR(mean_quantum_efficiency(curves, painted(), mwir_path()), 0.7, 1e-15);
  curves.quantum_efficiency.clear();
  EXPECT_EQ(mean_quantum_efficiency(curves, painted(), mwir_path()), 1.0);
  EXPECT_TRUE(std::isnan(mean_quantum_efficiency(mwir_curves(), {.temperature_k = 0.0}, mwir_path())));
}

// By mpmath as above, from a difference that would be lost in doubles to one of twice the temperature.
TEST(Signal, a_warmer_surface_sends_the_difference) {
  const std::pair<double, double> references[] = {{1e-6, 309324480144.58918757},
                                                  {0.25, 77633821146376805.674},
                                                  {4.0, 1317186876521044657.3},
                                                  {300.0, 2.7367864367453184089e+21}};
  for (const auto& [warmer_k, photons] : references)
    EXPECT_NEAR(scene_difference(mwir_curves(), painted(), mwir_path(), warmer_k) / photons, 1.0, 1e-12) << warmer_k;
}

TEST(Signal, well_fill_and_the_time_that_fills_it) {
  const Signal<double> s = signal(mwir_camera(), mwir_pixel(), {4e19, 0.0, 1e19, 1e10});
  Pixel<double> longer = mwir_pixel();
  longer.integration_s = integration_for_fill(s, mwir_pixel(), 0.8);
  EXPECT_NEAR(well_fill(signal(mwir_camera(), longer, {4e19, 0.0, 1e19, 1e10}), longer), 0.8, 1e-15);
}

TEST(Signal, extremes_are_finite_and_monotone) {
  double last = 0.0;
  for (double radiance = 1e-12; radiance < 2e32; radiance *= 10.0)
    for (const double time : {1e-9, 1e3}) {
      Pixel<double> pixel = mwir_pixel();
      pixel.integration_s = time;
      const double now = signal(mwir_camera(), pixel, {radiance, 0.0, 0.0, 0.0}).scene_e;
      ASSERT_TRUE(std::isfinite(now) && now > 0.0);
      if (time == 1e3) {
        EXPECT_GT(now, last);
        last = now;
      }
    }
}

TEST(Signal, fields_are_checked_all_at_once) {
  require_valid("camera", mwir_camera());
  require_valid("detector", mwir_pixel());
  Camera<double> camera = mwir_camera();
  camera.f_number = 0.0;
  camera.transmission = 1.5;
  expect_refused({"camera.f_number = 0", "camera.transmission = 1.5", "0 to 1"},
                 [&] { require_valid("camera", camera); });
  Pixel<double> pixel = mwir_pixel();
  pixel.width_um = 0.0;
  pixel.integration_s = std::nan("");
  pixel.quantum_efficiency = 1.2;
  expect_refused({"detector.width = 0 um", "above 0", "integration_time = nan s", "quantum_efficiency = 1.2"},
                 [&] { require_valid("detector", pixel); });
  const Surface cold{.temperature_k = -5.0};
  expect_refused({"surface of -5 K"}, [&] { band_radiances(mwir_curves(), cold, Path{}, {}); });
  SpectralCamera apart = mwir_curves();
  apart.band = {8.0, 12.0};
  const Surface warm{.temperature_k = 300.0};
  expect_refused({"3.3 um to 4.9 um", "8 um to 12 um"}, [&] {
    apart.optics.clear();
    band_radiances(apart, warm, Path{}, {});
  });
}

}  // namespace
}  // namespace radiometry
