// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/light/blackbody.h"
#include "radiometry/performance/sensitivity.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

struct Example {
  double lo, hi, f_number, pitch, fill, efficiency, time;
  double electrons, per_k, netd_mk, electrons_10;  // the last to eight digits
};
constexpr Example kMwir{3, 5, 2.5, 15, 0.95, 0.75, 0.01, 6.89e6, 2.47e5, 10.6, 6887506.7};
constexpr Example kLwir{8, 12, 2.0, 24, 0.9, 0.65, 200e-6, 2.05e7, 3.31e5, 13.7, 20493919.0};

Budget<double> budget_of(const Example& e, const NoiseTerms<double>& noise) {
  const Camera<double> camera{.f_number = e.f_number, .transmission = 0.85};
  const Pixel<double> pixel{.width_um = e.pitch * e.fill,
                            .height_um = e.pitch,
                            .quantum_efficiency = e.efficiency,
                            .integration_s = e.time,
                            .full_well_e = 3e7};
  const Signal<double> s = signal(camera, pixel, {.scene = band_radiance(Flux::photons, e.lo, e.hi, 300.0)});
  return make_budget(pixel, s, noise,
                     electrons_per_radiance(camera, pixel) * band_derivative(Flux::photons, e.lo, e.hi, 300.0));
}

/// Equal to three significant digits.
void expect_digits(double value, double printed) {
  const double unit = std::pow(10.0, std::floor(std::log10(printed)) - 2.0);
  EXPECT_EQ(std::round(value / unit), std::round(printed / unit));
}

TEST(Budget, two_cameras_to_the_digits_given) {
  for (const Example& e : {kMwir, kLwir}) {
    const Budget<double> b = budget_of(e, {});
    EXPECT_NEAR(b.signal.total_e(), e.electrons_10, 5e-8 * e.electrons_10);
    expect_digits(b.signal.total_e(), e.electrons);
    expect_digits(b.signal_per_k, e.per_k);
    EXPECT_EQ(std::round(1e4 * b.shot_netd_k) / 10.0, e.netd_mk);
    EXPECT_EQ(b.netd_k, b.shot_netd_k);  // no other noise
  }
}

TEST(Budget, terms_add_in_squares) {
  const NoiseTerms<double> noise{
      .read_e = 300, .reset_e = 200, .other_e = 100, .step_e = 1200, .prnu = 1e-3, .dsnu_e = 500};
  const Budget<double> b = budget_of(kMwir, noise);
  const double n = b.signal.total_e();
  EXPECT_NEAR(b.quantisation_e, 1200 / std::sqrt(12.0), 1e-12);
  EXPECT_NEAR(b.temporal_e, std::sqrt(n + 300 * 300 + 200 * 200 + 100 * 100 + 1200.0 * 1200 / 12), 1e-9);
  EXPECT_NEAR(b.floor_e, std::sqrt(300.0 * 300 + 200 * 200 + 100 * 100 + 1200.0 * 1200 / 12), 1e-12);
  EXPECT_NEAR(b.spatial_e, std::hypot(1e-3 * n, 500.0), 1e-9);
  EXPECT_NEAR(b.netd_k, b.temporal_e / b.signal_per_k, 1e-18);
  EXPECT_NEAR(b.snr, n / b.temporal_e, 1e-9);
  EXPECT_NEAR(b.dynamic_range, 3e7 / b.floor_e, 1e-6);
  double netd = 0.0, temporal = 0.0;
  for (const BudgetRow& row : rows(b)) {
    EXPECT_TRUE(std::isfinite(row.value)) << row.name;
    if (row.name == "netd") netd = row.value;
    if (row.name == "temporal") temporal = row.value;
  }
  EXPECT_EQ(netd, 1e3 * b.netd_k);
  EXPECT_EQ(temporal, b.temporal_e);
}

// D* of the noise that the photons make gives the NETD of the electrons: two routes to one number.
TEST(Budget, netd_by_dstar_equals_netd_by_electrons) {
  const Example e = kLwir;
  const Budget<double> b = budget_of(e, {.read_e = 400.0});
  const Camera<double> camera{.f_number = e.f_number, .transmission = 0.85};
  const Pixel<double> pixel{
      .width_um = e.pitch * e.fill, .height_um = e.pitch, .quantum_efficiency = e.efficiency, .integration_s = e.time};
  // D*(lambda) is linear in lambda: its integral with dL/dT is that of the photons.
  const double per_um = dstar_jones(pixel, b.temporal_e, 1.0);
  const double weighted = per_um * kPhotonEnergy_j_um * band_derivative(Flux::photons, e.lo, e.hi, 300.0);
  EXPECT_NEAR(netd_from_dstar_k(camera, pixel, weighted), b.netd_k, 1e-14 * b.netd_k * 10);
  // By the cone of an aplanat, F/2: 1/16 in place of 1/17.
  Camera<double> aplanat = camera;
  aplanat.cone = Cone::sine;
  EXPECT_NEAR(netd_from_dstar_k(aplanat, pixel, weighted) / b.netd_k, 16.0 / 17.0, 1e-13);
  // Background-limited D* at the peak of an ideal LWIR detector, of the order known from textbooks (1e10 ... 1e11).
  EXPECT_GT(dstar_jones(pixel, b.temporal_e, 12.0), 1e10);
  EXPECT_LT(dstar_jones(pixel, b.temporal_e, 12.0), 1e12);
}

TEST(Budget, noise_equivalent_irradiance_gives_a_signal_of_the_noise) {
  const Budget<double> b = budget_of(kMwir, {.read_e = 1000.0});
  const double area_m2 = kMwir.pitch * kMwir.fill * kMwir.pitch * 1e-12;
  EXPECT_NEAR(b.nei_ph * kMwir.efficiency * area_m2 * kMwir.time, b.temporal_e, 1e-12 * b.temporal_e);
}

TEST(Budget, reset_noise) { EXPECT_NEAR(reset_noise_e(1e-12, 77.0), 203.5, 0.1); }

TEST(Budget, nothing_at_all_is_zero_noise) {
  const Pixel<double> pixel{.width_um = 1, .height_um = 1, .integration_s = 1e-9, .full_well_e = 1};
  const Budget<double> b = make_budget(pixel, Signal<double>{}, NoiseTerms<double>{}, 1.0);
  EXPECT_EQ(b.temporal_e, 0.0);
  EXPECT_EQ(b.netd_k, 0.0);
  EXPECT_TRUE(std::isinf(b.dynamic_range));
}

TEST(Budget, refused_terms) {
  expect_refused({"noise.read = -1 e-", "noise.prnu = 2"},
                 [] { require_valid("noise", NoiseTerms<double>{.read_e = -1.0, .prnu = 2.0}); });
}

}  // namespace
}  // namespace radiometry
