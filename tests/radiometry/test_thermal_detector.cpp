// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "radiometry/light/blackbody.h"
#include "radiometry/performance/thermal_detector.h"
#include "tests/expect_error.h"

// References: mpmath with 40 digits from the constants of CODATA 2018, unless a test says otherwise.

namespace radiometry {
namespace {

void expect_close(double value, double reference, double relative) {
  EXPECT_NEAR(value, reference, relative * std::abs(reference));
}

ThermalBody<double> body() { return {.heat_capacity_j_k = 3e-10, .conductance_w_k = 3e-8, .temperature_k = 300}; }
BolometerReadout<double> readout() {
  return {.resistance_ohm = 1e5,
          .tcr_per_k = -0.02,
          .bias_v = 2.0,
          .corner_hz = 1e3,
          .lowest_hz = 0.01,
          .readout_v = 10e-6,
          .bandwidth_hz = 8e3};
}
constexpr double kArea_m2 = 17e-6 * 17e-6;

TEST(ThermalDetector, the_limit_of_radiation) {
  expect_close(radiation_limit_jones(1.0, 300.0, 300.0), 18125473564.722186, 1e-14);
  expect_close(radiation_limit_jones(0.8, 300.0, 290.0), 16883382140.489752, 1e-14);
}

/// By another route: the temperature fluctuation of the conductance of radiation, as D* of incident power.
TEST(ThermalDetector, the_limit_of_radiation_is_the_fluctuation_of_its_conductance) {
  const double emissivity = 0.7;
  ThermalBody<double> pixel = body();
  pixel.conductance_w_k = radiation_conductance_w_k(emissivity, kArea_m2, 300.0);
  const double bandwidth_hz = 2.0;  // D* is that of one hertz
  const double nep_w = std::sqrt(fluctuation_density_w2_hz(pixel) * bandwidth_hz);
  expect_close(dstar_from_nep_jones(nep_w, kArea_m2, bandwidth_hz, emissivity),
               radiation_limit_jones(emissivity, 300.0, 300.0), 1e-14);
}

/// (1 + 4 N^2) sqrt(df) / (tau sqrt(A) D* 4 sigma T^3) = 1.4513 mK at F/1, 17 um, 30 Hz, all wavelengths.
TEST(ThermalDetector, netd_of_the_ideal_detector) {
  const Camera<double> camera{.f_number = 1.0};
  const double per_k = band_derivative(Flux::watts, 0.0, mtf::kInfinity, 300.0);
  const double nep_w = nep_from_dstar_w(radiation_limit_jones(1.0, 300.0, 300.0), kArea_m2, 30.0, 1.0);
  expect_close(netd_from_nep_k(nep_w, absorbed_per_k(camera, kArea_m2, 1.0, per_k)), 1.4512988662006941e-3, 1e-13);
}

TEST(ThermalDetector, one_cone_on_both_sides) {
  // The sine cone has 5/4 of the light of the tangent one at F/1. A specification that is turned into a power and back
  // with the same cone keeps its NETD, one that changes the cone is 25 % off.
  const Camera<double> tangent{.f_number = 1.0}, sine{.f_number = 1.0, .cone = Cone::sine};
  const double per_k = band_derivative(Flux::watts, 8.0, 14.0, 300.0);
  const auto watts = [&](const Camera<double>& camera) { return absorbed_per_k(camera, kArea_m2, 0.8, per_k); };
  expect_close(watts(sine), 1.25 * watts(tangent), 1e-14);
  for (const auto& camera : {tangent, sine})
    expect_close(netd_from_nep_k(nep_from_netd_w(0.05, watts(camera)), watts(camera)), 0.05, 1e-15);
}

TEST(ThermalDetector, terms_of_a_bolometer) {
  expect_close(body().time_constant_s(), 10e-3, 1e-15);
  expect_close(bolometer_responsivity_v_w(body(), readout()), 4e6 / 3.0, 1e-14);  // 2 V x 0.02/K / 3e-8 W/K
  const ThermalNoise<double> noise = bolometer_noise(body(), readout());
  expect_close(noise.fluctuation_w, 1.9287297034143677e-12, 1e-13);
  expect_close(noise.johnson_w, 2.7304769912965756e-12, 1e-13);
  expect_close(noise.flicker_w, 3.5591072395856483e-12, 1e-13);
  expect_close(noise.readout_w, 7.5e-12, 1e-14);
  expect_close(
      noise.total_w(),
      std::hypot(std::hypot(noise.fluctuation_w, noise.johnson_w), std::hypot(noise.flicker_w, noise.readout_w)),
      1e-15);
}

TEST(ThermalDetector, the_fluctuation_follows_the_time_constant) {
  const auto shape = [](double x) { return 4e-2 * fluctuation_bandwidth_hz(1e-2, 0.5 / (x * 1e-2)); };
  for (const auto& [x, reference] :
       {std::pair{1e-6, 0.99999966666675}, std::pair{0.1, 0.96748360719191463}, std::pair{0.49, 0.85486375830417384},
        std::pair{0.51, 0.84963920655337134}, std::pair{3.0, 0.45550823741508088}, std::pair{1e4, 0.00019998}})
    expect_close(shape(x), reference, 1e-13);
  // A fast readout sees the whole variance of the temperature, k T^2/C.
  const ThermalBody<double> pixel = body();
  const double variance_k2 = fluctuation_density_w2_hz(pixel) *
                             fluctuation_bandwidth_hz(pixel.time_constant_s(), 1e15) /
                             (pixel.conductance_w_k * pixel.conductance_w_k);
  expect_close(variance_k2, kBoltzmann_j_k * 300.0 * 300.0 / pixel.heat_capacity_j_k, 1e-12);
  expect_close(fluctuation_bandwidth_hz(1e-2, 1e-6), 1e-6, 1e-7);  // a slow one its own bandwidth
}

TEST(ThermalDetector, figures_turn_into_each_other) {
  const double nep_w = nep_from_dstar_w(1e9, kArea_m2, 40.0, 0.8);
  // sqrt(A df) = 17e-4 cm x sqrt(40 Hz) = 0.010751744 cm Hz^1/2: 1.0751744e-11 W incident, 0.8 of it absorbed.
  expect_close(nep_w, 0.8 * 1.0751744e-11, 1e-7);
  expect_close(dstar_from_nep_jones(nep_w, kArea_m2, 40.0, 0.8), 1e9, 1e-14);
  expect_close(in_bandwidth(3.0, 30.0, 120.0), 6.0, 1e-15);
}

/// Cameras worked by hand: dL/dT from 8 to 14 um at 300 K is 0.83782128952792565 W m^-2 sr^-1 K^-1, and
/// NEP = NETD pi/(1 + 4 N^2) dL/dT p^2 with all of the light absorbed. VOx, 12 um: FLIR Boson Thermal Imaging Core,
/// data sheet ("as low as <40" mK, f/1.0). VOx, 12 um and 17 um: FLIR Lepton Engineering Datasheet 500-0659-00-09 Rev
/// 203 (8 to 14 um, f/1.1, below 50 mK). No data sheet of an a-Si camera could be had: its figures are those of the
/// class, 17 um and 50 mK at F/1. They state no transmission: 1 is taken; and of the Boson no band: 8 to 14 um is
/// taken.
TEST(ThermalDetector, published_cameras_by_hand) {
  struct Published {
    double pitch_um, f_number, netd_mk, nep_pw;
  };
  const double per_k = band_derivative(Flux::watts, 8.0, 14.0, 300.0);
  expect_close(per_k, 0.83782128952792565, 1e-13);
  for (const Published& p : {Published{12, 1.0, 40, 3.03217137584877}, Published{12, 1.1, 50, 3.24504642107},
                             Published{17, 1.1, 50, 6.51262788673}, Published{17, 1.0, 50, 7.6067493717}}) {
    const double area_m2 = p.pitch_um * p.pitch_um * 1e-12;
    const double watts_per_k = absorbed_per_k(Camera<double>{.f_number = p.f_number}, area_m2, 1.0, per_k);
    const double nep_w = nep_from_netd_w(1e-3 * p.netd_mk, watts_per_k);
    expect_close(1e12 * nep_w, p.nep_pw, 1e-11);
    EXPECT_EQ(std::round(1e3 * netd_from_nep_k(nep_w, watts_per_k)), p.netd_mk);
    // No camera beats radiation: at 30 Hz its D* stays below the limit.
    EXPECT_LT(dstar_from_nep_jones(nep_w, area_m2, 30.0, 1.0), radiation_limit_jones(1.0, 300.0, 300.0));
  }
}

/// FLIR support, "What is the sensitivity of Tau cameras in Watts per m^2?": 50 mK at f/1.0, 300 K, unit
/// emissivity, 7.5 to 13.5 um, is 0.14 W/m^2. That is the exitance of the scene, of which the cone at f/1.0 takes 1/(1
/// + 4).
TEST(ThermalDetector, a_published_netd_as_watts_per_square_metre) {
  const double per_k = band_derivative(Flux::watts, 7.5, 13.5, 300.0);
  expect_close(per_k, 0.88248863285299242, 1e-13);
  const double on_pixel = nep_from_netd_w(0.05, absorbed_per_k(Camera<double>{.f_number = 1.0}, 1.0, 1.0, per_k));
  EXPECT_EQ(std::round(100.0 * on_pixel * (1.0 + 4.0)), 14.0);
}

TEST(ThermalDetector, what_cannot_be_is_refused) {
  const auto check = [](ThermalBody<double> pixel, BolometerReadout<double> electronics) {
    require_bolometer("detector", pixel, electronics, 0.8, kArea_m2);
  };
  check(body(), readout());
  ThermalBody<double> pixel = body();
  pixel.conductance_w_k = 0.0;
  expect_refused({"detector.conductance: 0 W/K", "for example 1e-8"}, [&] { check(pixel, readout()); });
  // 4 x 0.8 x 5.670374e-8 x 2.89e-10 x 2.7e7 = 1.4158717e-9 W/K
  pixel.conductance_w_k = 1.415e-9;
  expect_refused({"detector.conductance: 1.415e-09 W/K is below the 1.42e-09 W/K", "smaller area"},
                 [&] { check(pixel, readout()); });
  pixel.conductance_w_k = 1.416e-9;
  check(pixel, readout());
  pixel.heat_capacity_j_k = 0.0;
  expect_refused({"detector.heat_capacity = 0 J/K"}, [&] { check(pixel, readout()); });
  BolometerReadout<double> electronics = readout();
  electronics.tcr_per_k = 0.0;
  expect_refused({"detector.tcr: 0", "-0.02"}, [&] { check(body(), electronics); });
  for (const double lowest_hz : {0.0, 8e3}) {
    electronics = readout();
    electronics.lowest_hz = lowest_hz;
    expect_refused({"detector.lowest_frequency", "bandwidth of 8000 Hz"}, [&] { check(body(), electronics); });
  }
  electronics.corner_hz = 0.0;  // no 1/f noise, no range needed
  check(body(), electronics);
}

}  // namespace
}  // namespace radiometry
