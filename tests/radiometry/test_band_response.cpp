// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "mtf/math/quadrature.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/constants.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

/// The integral by brute force: 64 panels of 32 nodes on every piece of the wavelength.
template <class F>
double slow_integral(const Interval& range, std::span<const Spectrum> curves, F f) {
  const std::vector<double> grid = union_grid(range, curves);
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < grid.size(); ++i)
    for (int panel = 0; panel < 64; ++panel) {
      const double step = (grid[i + 1] - grid[i]) / 64.0, lo = grid[i] + panel * step;
      const mtf::GaussRule rule = mtf::mean_rule(lo, lo + step, 32);
      for (std::size_t j = 0; j < rule.node.size(); ++j) {
        double value = f(rule.node[j]);
        for (const Spectrum& curve : curves) value *= evaluate(curve, rule.node[j]);
        sum += rule.weight[j] * step * value;
      }
    }
  return sum;
}

std::vector<Spectrum> camera_curves() {
  return {make_spectrum("qe", {3.0, 3.4, 4.6, 5.2}, {0.1, 0.7, 0.8, 0.0}, 1.0),
          make_spectrum("filter", {3.3, 3.5, 4.7, 4.9}, {0.0, 0.9, 0.88, 0.0}, 1.0), constant_spectrum("optics", 0.85)};
}

TEST(BandResponse, without_curves_it_is_the_series) {
  for (const auto& [lo, hi] : {std::pair{3.0, 5.0}, {8.0, 12.0}, {0.1, 1e6}, {10.0, 10.001}})
    for (const double t : {1.0, 4.2, 77.0, 300.0, 6000.0, 1e9})
      for (const Flux flux : {Flux::watts, Flux::photons}) {
        const BandResponse open({lo, hi}, {});
        const double exact = band_radiance(flux, lo, hi, t), slope = band_derivative(flux, lo, hi, t);
        EXPECT_NEAR(open.radiance(flux, t), exact, 4e-15 * exact) << lo << " " << t;
        EXPECT_NEAR(open.derivative(flux, t), slope, 4e-15 * slope) << lo << " " << t;
      }
}

TEST(BandResponse, weighted_radiance_equals_brute_force) {
  const std::vector<Spectrum> curves = camera_curves();
  const BandResponse response({3.0, 5.0}, curves);
  EXPECT_EQ(response.range().lo_um, 3.3);
  EXPECT_EQ(response.range().hi_um, 4.9);
  EXPECT_NEAR(response.integral(), slow_integral(response.range(), curves, [](double) { return 1.0; }), 1e-14);
  for (const double w : {3.3, 3.45, 4.0, 4.9})
    EXPECT_NEAR(response.value(w), evaluate(curves[0], w) * evaluate(curves[1], w) * 0.85, 1e-16);
  for (const Flux flux : {Flux::watts, Flux::photons})
    for (const double t : {20.0, 77.0, 300.0, 6000.0, 1e7}) {
      const double exact = slow_integral(response.range(), curves, [&](double w) { return planck(flux, w, t); });
      const double slope =
          slow_integral(response.range(), curves, [&](double w) { return planck_derivative(flux, w, t); });
      EXPECT_NEAR(response.radiance(flux, t), exact, 1.5e-14 * exact) << t;
      EXPECT_NEAR(response.derivative(flux, t), slope, 1.5e-14 * slope) << t;
    }
}

TEST(BandResponse, photons_are_watts_over_their_energy) {
  std::vector<Spectrum> curves = camera_curves();
  const BandResponse photons({3.0, 5.0}, curves);
  curves.push_back(make_spectrum("lambda / h c", {1.0, 20.0}, {1.0 / kPhotonEnergy_j_um, 20.0 / kPhotonEnergy_j_um}));
  const BandResponse watts({3.0, 5.0}, curves);
  for (const double t : {1.0, 30.0, 300.0, 6000.0, 1e9}) {
    const double rate = photons.radiance(Flux::photons, t);
    EXPECT_NEAR(watts.radiance(Flux::watts, t), rate, 1e-14 * rate) << t;
  }
}

TEST(BandResponse, cold_warm_and_extreme_temperatures_are_finite_and_rise) {
  const std::vector<Spectrum> curves = camera_curves();
  const BandResponse response({3.0, 5.0}, curves);
  EXPECT_EQ(response.radiance(Flux::watts, 0.0), 0.0);
  EXPECT_TRUE(std::isnan(response.radiance(Flux::watts, -1.0)));
  double last = 0.0;
  for (double t = 1.0; t < 1.1e9; t *= 1.05) {
    const double now = response.radiance(Flux::watts, t);
    ASSERT_TRUE(std::isfinite(now) && now >= last) << t;
    last = now;
  }
  EXPECT_TRUE(std::isinf(response.radiance(Flux::watts, 1e308)));
}

// A curve that is zero at long wavelengths must not end the sum there.
TEST(BandResponse, a_dark_end_hides_nothing) {
  const std::vector curve{make_spectrum("short", {3.0, 3.5, 3.6, 12.0}, {1.0, 1.0, 0.0, 0.0})};
  const BandResponse response({3.0, 12.0}, curve);
  for (const double t : {8.0, 20.0, 300.0}) {
    const double exact = slow_integral({3.0, 3.6}, curve, [&](double w) { return planck(Flux::watts, w, t); });
    EXPECT_GT(exact, 0.0);
    EXPECT_NEAR(response.radiance(Flux::watts, t), exact, 4e-14 * exact) << t;
  }
}

TEST(ElectronNodes, constant_rate_gives_gauss_and_legendre) {
  const mtf::WavelengthNodes nodes = BandResponse({3.4, 4.8}, {}).electron_nodes(9, {});
  const mtf::WavelengthNodes legendre = mtf::wavelength_nodes({3.4, 4.8}, 9);
  ASSERT_EQ(nodes.wavelength_um.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(nodes.wavelength_um[i], legendre.wavelength_um[i], 1e-13);
    EXPECT_NEAR(nodes.weight[i], legendre.weight[i], 1e-13);
  }
}

TEST(ElectronNodes, means_over_electrons_are_exact_for_polynomials) {
  const std::vector<Spectrum> curves = camera_curves();
  const BandResponse response({3.0, 5.0}, curves);
  for (const double t : {40.0, 300.0, 6000.0}) {
    const auto rate = [&](double w) { return planck(Flux::photons, w, t); };
    const double total = slow_integral(response.range(), curves, rate);
    for (const int n : {1, 2, 5, 17, 64}) {
      const mtf::WavelengthNodes nodes = response.electron_nodes(n, t);
      ASSERT_EQ(nodes.weight.size(), static_cast<std::size_t>(n));
      for (const int degree : {0, 1, 2 * n - 1}) {
        const auto power = [&](double w) { return std::pow((w - 4.1) / 0.8, degree); };
        const double exact =
            slow_integral(response.range(), curves, [&](double w) { return rate(w) * power(w); }) / total;
        double mean = 0.0;
        for (std::size_t i = 0; i < nodes.weight.size(); ++i) {
          EXPECT_GT(nodes.weight[i], 0.0);
          EXPECT_TRUE(i == 0 || nodes.wavelength_um[i] > nodes.wavelength_um[i - 1]);
          mean += nodes.weight[i] * power(nodes.wavelength_um[i]);
        }
        EXPECT_NEAR(mean, exact, 2e-13) << t << " " << n << " " << degree;
      }
    }
  }
}

// Many samples, and the coldest source: the rate falls by e^-1000 over the band.
TEST(ElectronNodes, dense_curves_and_cold_sources) {
  std::vector<double> w, v;
  for (int i = 0; i <= 1400; ++i) w.push_back(8.0 + i * 4e-3), v.push_back(0.5 + 0.4 * std::sin(0.37 * i));
  const std::vector curves{make_spectrum("filter", w, v)};
  const BandResponse response({8.0, 12.0}, curves);
  for (const double t : {1.0, 77.0, 300.0}) {
    const mtf::WavelengthNodes nodes = response.electron_nodes(12, t);
    double sum = 0.0;
    for (const double weight : nodes.weight) sum += weight;
    EXPECT_NEAR(sum, 1.0, 1e-13);
    EXPECT_GE(nodes.wavelength_um.front(), 8.0);
    EXPECT_LE(nodes.wavelength_um.back(), 12.0);
  }
  EXPECT_GT(response.electron_nodes(12, 1.0).wavelength_um.front(), 10.0);
}

TEST(BandResponse, the_ends_of_what_is_allowed_come_back) {
  for (const Interval& band : {Interval{1e-6, 1e12}, {1e-6, 1.0001e-6}, {1e11, 1e12}})
    for (const double t : {1e-300, 1e-3, 300.0, 1e70, 1e300}) {
      const double radiance = BandResponse(band, {}).radiance(Flux::photons, t);
      EXPECT_TRUE(radiance >= 0.0) << band.lo_um << " " << t;
      // Weights that sum to 1, or the refusal where all rates are below the smallest double.
      try {
        const mtf::WavelengthNodes nodes = BandResponse(band, {}).electron_nodes(3, t);
        EXPECT_NEAR(std::accumulate(nodes.weight.begin(), nodes.weight.end(), 0.0), 1.0, 1e-13)
            << band.lo_um << " " << t;
      } catch (const mtf::UsageError&) {
        EXPECT_TRUE(t < 1e-200 || t > 1e200 || band.hi_um < 1.0) << band.lo_um << " " << t;
      }
    }
}

TEST(ElectronNodes, refusals) {
  const std::vector dark{constant_spectrum("shutter", 0.0)};
  expect_refused({"8 um to 12 um", "no electrons"}, [&] { BandResponse({8, 12}, dark).electron_nodes(5, 300.0); });
  expect_refused({"0 wavelengths", "256"}, [&] { BandResponse({8, 12}, {}).electron_nodes(0, 300.0); });
  expect_refused({"-3"}, [&] { BandResponse({8, 12}, {}).electron_nodes(4, -3.0); });
  expect_refused({"a source of 1e-310 K", "8 um to 12 um"}, [&] {
    BandResponse({8, 12}, {}).electron_nodes(4, 1e-310);
  });
  const std::vector<Spectrum> many(9, constant_spectrum("c", 1.0));
  expect_refused({"9 curves"}, [&] { BandResponse({8, 12}, many); });
}

}  // namespace
}  // namespace radiometry
