// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cfloat>
#include <cmath>
#include <limits>

#include "radiometry/light/blackbody.h"
#include "radiometry/light/constants.h"
#include "tests/mtf/reference_table.h"

namespace radiometry {
namespace {

using mtf::test::number;
using mtf::test::precise;
using mtf::test::reference_table;
using mtf::test::Row;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::array kFluxes{Flux::watts, Flux::photons};

Flux flux_of(const Row& row) { return row.at("flux") == "watts" ? Flux::watts : Flux::photons; }

/// Within `relative`, or `absolute`: below the normal doubles two of the smallest.
void expect_close(double value, const Row& row, const char* column, double relative,
                  double absolute = 2 * DBL_TRUE_MIN) {
  const long double exact = precise(row, column);
  const long double allowed = std::max(relative * std::abs(exact), static_cast<long double>(absolute));
  EXPECT_LE(std::abs(value - exact), allowed) << row.where << " " << column << ": " << value << " " << exact;
}

// Every digit counts: an x rounded to double would alone cost 1e-13 at x = 700.
TEST(Blackbody, planck_against_50_digits) {
  int underflows = 0;
  for (const Row& row : reference_table("planck.csv")) {
    const double w = number(row, "wavelength_um_hex"), t = number(row, "temperature_k_hex");
    expect_close(planck(flux_of(row), w, t), row, "radiance", 1e-15);
    expect_close(planck_derivative(flux_of(row), w, t), row, "derivative", 1.5e-15);
    expect_close(log_planck(flux_of(row), w, t), row, "log_radiance", 1e-15, 2e-15);
    underflows += planck(flux_of(row), w, t) == 0.0;
  }
  EXPECT_GT(underflows, 10);
}

TEST(Blackbody, bands_against_50_digits) {
  for (const Row& row : reference_table("planck_bands.csv")) {
    const double lo = number(row, "lo_um_hex"), hi = number(row, "hi_um_hex"), t = number(row, "temperature_k_hex");
    expect_close(band_radiance(flux_of(row), lo, hi, t), row, "radiance", 2e-15);
    expect_close(band_derivative(flux_of(row), lo, hi, t), row, "derivative", 2e-15);
    expect_close(log_band_radiance(flux_of(row), lo, hi, t), row, "log_radiance", 1e-15, 2e-15);
  }
}

struct Golden {
  double t, lo, hi, w, ph, w_k, ph_k;
};
constexpr std::array kGolden{Golden{77, 8, 12, 7.7595658263e-5, 4.3728214871e15, 1.6893286189e-5, 9.4792226169e14},
                             Golden{250, 8, 14, 2.2292289689e1, 1.2467186100e21, 4.7595035523e-1, 2.6007726208e19},
                             Golden{300, 3, 5, 1.8659562082, 4.1831091268e19, 6.7698344153e-2, 1.5017177246e18},
                             Golden{300, 8, 12, 3.8500423933e1, 1.9359617993e21, 6.2970434672e-1, 3.1264007171e19},
                             Golden{300, 8, 14, 5.4933461377e1, 3.0088386952e21, 8.3782128953e-1, 4.4827218654e19},
                             Golden{300, 7.5, 13.5, 5.5491611368e1, 2.9153419579e21, 8.8248863285e-1, 4.5186801420e19},
                             Golden{500, 3, 5, 1.6752777840e2, 3.5262479503e21, 2.3501169501, 4.8599072718e19},
                             Golden{1000, 3, 5, 6.5067339788e3, 1.2775849333e23, 2.5138094311e1, 4.8425773385e20}};

TEST(Blackbody, ten_digits_of_the_common_bands) {
  for (const Golden& g : kGolden) {
    EXPECT_NEAR(band_radiance(Flux::watts, g.lo, g.hi, g.t), g.w, 6e-11 * g.w) << g.t << " " << g.lo;
    EXPECT_NEAR(band_radiance(Flux::photons, g.lo, g.hi, g.t), g.ph, 6e-11 * g.ph) << g.t << " " << g.lo;
    EXPECT_NEAR(band_derivative(Flux::watts, g.lo, g.hi, g.t), g.w_k, 6e-11 * g.w_k) << g.t << " " << g.lo;
    EXPECT_NEAR(band_derivative(Flux::photons, g.lo, g.hi, g.t), g.ph_k, 6e-11 * g.ph_k) << g.t << " " << g.lo;
  }
}

TEST(Blackbody, all_wavelengths_give_stefan_and_boltzmann) {
  for (const double t : {1.0, 300.0, 6000.0, 1e9}) {
    const double exact = kStefanBoltzmann_w_m2_k4 / mtf::kPi * t * t * t * t;
    EXPECT_NEAR(band_radiance(Flux::watts, 0.0, kInf, t), exact, 2e-15 * exact);
    EXPECT_NEAR(band_derivative(Flux::watts, 0.0, kInf, t), 4.0 * exact / t, 8e-15 * exact / t);
    const double parts = band_radiance(Flux::watts, 0.0, 4e3 / t, t) + band_radiance(Flux::watts, 4e3 / t, kInf, t);
    EXPECT_NEAR(parts, exact, 2e-15 * exact);
  }
}

TEST(Blackbody, a_photon_carries_its_energy) {
  for (const double w : {0.1, 3.7, 10.0, 1e3, 1e6})
    for (const double t : {4.0, 300.0, 1e4, 1e9}) {
      const double watts = planck(Flux::watts, w, t);
      EXPECT_NEAR(planck(Flux::photons, w, t) * kPhotonEnergy_j_um / w, watts, 1e-15 * watts) << w << " " << t;
    }
}

TEST(Blackbody, brightness_temperature_is_the_inverse) {
  for (const Flux flux : kFluxes)
    for (const double w : {0.1, 1.0, 4.0, 10.0, 300.0, 1e6})
      for (const double t : {1.0, 77.0, 300.0, 6000.0, 1e9}) {
        const double radiance = planck(flux, w, t);
        if (radiance < DBL_MIN) continue;
        EXPECT_NEAR(brightness_temperature(flux, w, radiance), t, 2e-15 * t) << w;
        if (band_radiance(flux, w, 1.5 * w, t) < DBL_MIN) continue;
        EXPECT_NEAR(band_temperature(flux, w, 1.5 * w, band_radiance(flux, w, 1.5 * w, t)), t, 4e-15 * t) << w;
      }
  // Down to the smallest double: there the ratio of the formula overflows.
  EXPECT_NEAR(log_planck(Flux::watts, 0.1, brightness_temperature(Flux::watts, 0.1, 5e-324)), std::log(5e-324), 1e-11);
}

TEST(Blackbody, limits_and_refusals) {
  for (const Flux flux : kFluxes) {
    EXPECT_EQ(planck(flux, 10.0, 0.0), 0.0);
    EXPECT_EQ(planck_derivative(flux, 10.0, 0.0), 0.0);
    EXPECT_EQ(log_planck(flux, 10.0, 0.0), -kInf);
    EXPECT_EQ(band_radiance(flux, 8.0, 12.0, 0.0), 0.0);
    EXPECT_EQ(band_radiance(flux, 8.0, 8.0, 300.0), 0.0);
    EXPECT_EQ(brightness_temperature(flux, 10.0, 0.0), 0.0);
    EXPECT_EQ(band_temperature(flux, 8.0, 12.0, 0.0), 0.0);
    for (const double bad : {-1.0, std::nan(""), -kInf}) {
      EXPECT_TRUE(std::isnan(planck(flux, 10.0, bad)));
      EXPECT_TRUE(std::isnan(planck(flux, bad, 300.0)));
      EXPECT_TRUE(std::isnan(planck_derivative(flux, 10.0, bad)));
      EXPECT_TRUE(std::isnan(band_radiance(flux, 8.0, 12.0, bad)));
      EXPECT_TRUE(std::isnan(band_radiance(flux, bad, 12.0, 300.0)));
      EXPECT_TRUE(std::isnan(log_band_radiance(flux, 8.0, bad, 300.0)));
      EXPECT_TRUE(std::isnan(brightness_temperature(flux, 10.0, bad)));
      EXPECT_TRUE(std::isnan(band_temperature(flux, 8.0, 12.0, bad)));
    }
    EXPECT_TRUE(std::isnan(band_radiance(flux, 12.0, 8.0, 300.0)));
  }
}

TEST(Blackbody, hotter_is_never_darker) {
  for (const Flux flux : kFluxes)
    for (const double w : {0.1, 0.5, 10.0, 1e6}) {
      double last = 0.0, last_band = 0.0;
      for (double t = 1.0; t < 1.1e9; t *= 1.013) {
        const double now = planck(flux, w, t), band = band_radiance(flux, w, 1.2 * w, t);
        ASSERT_TRUE(std::isfinite(now) && std::isfinite(band));
        ASSERT_GE(now, last) << w << " " << t;
        ASSERT_GE(band, last_band) << w << " " << t;
        last = now, last_band = band;
      }
    }
}

TEST(Blackbody, slopes_equal_differences) {
  for (const Flux flux : kFluxes)
    for (const double t : {150.0, 300.0, 5000.0})
      for (const double w : {4.0, 12.0, 900.0}) {
        const double h = 1e-5;
        const auto by = [&](auto f, double dw, double dt) {
          return (f(w * (1.0 + dw), t * (1.0 + dt)) - f(w * (1.0 - dw), t * (1.0 - dt))) / (2.0 * h);
        };
        const auto check = [&](auto f, const SpectralSlopes& s) {
          EXPECT_NEAR(s.by_wavelength * w, by(f, h, 0.0), 1e-7 * std::abs(s.value) * (1.0 + 1e4 / (w * t)));
          EXPECT_NEAR(s.by_temperature * t, by(f, 0.0, h), 1e-7 * std::abs(s.value) * (1.0 + 1e4 / (w * t)));
        };
        check([&](double a, double b) { return planck(flux, a, b); }, planck_slopes(flux, w, t));
        check([&](double a, double b) { return planck_derivative(flux, a, b); }, planck_derivative_slopes(flux, w, t));
        check([&](double a, double b) { return log_planck(flux, a, b); }, log_planck_slopes(flux, w, t));

        const double hi = 1.3 * w;
        const BandSlopes band = band_radiance_slopes(flux, w, hi, t), steep = band_derivative_slopes(flux, w, hi, t);
        EXPECT_EQ(band.by_temperature, steep.value);
        EXPECT_EQ(band.by_lo, -planck(flux, w, t));
        EXPECT_EQ(band.by_hi, planck(flux, hi, t));
        EXPECT_NEAR(steep.by_temperature * t,
                    (band_derivative(flux, w, hi, t * (1 + h)) - band_derivative(flux, w, hi, t * (1 - h))) / (2 * h),
                    1e-6 * steep.value);
        EXPECT_EQ(steep.by_lo, -planck_derivative(flux, w, t));
        EXPECT_EQ(steep.by_hi, planck_derivative(flux, hi, t));
      }
}

}  // namespace
}  // namespace radiometry
