// SPDX-License-Identifier: Apache-2.0
// Planning with a band: how many values of an aberrated pupil it takes, and that its table is the average.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "mtf/components/turbulence.h"
#include "mtf/literals.h"
#include "tests/mtf/band_cases.h"

namespace mtf::test {
namespace {

std::int64_t values_of(const System<double>& system) {
  std::atomic<std::int64_t> values = 0;
  compile_band_case(system, [&](std::int64_t made) { values += made; });
  return values;
}

// Work, not time: bench_band has the time. The waves of one path difference change with the wavelength, and a table
// takes a few wavelengths; all else follows from one.
TEST(BandPlan, takes_few_times_the_values_of_one_wavelength) {
  for (const BandCase& c : kBandCases) {
    if (c.seidel[1] == 0.0) continue;  // radial ones are counted for a band only
    const std::int64_t one = values_of(band_case(c, false)), band = values_of(band_case(c, true));
    EXPECT_GT(one, 500) << c.name;
    EXPECT_LE(band, (c.reference_um > 0.0 ? 18 : 12) * one) << c.name;
  }
}

TEST(BandPlan, the_table_is_the_average_within_its_error) {
  const std::array stages{Stage::presample};
  for (const BandCase& c : kBandCases) {
    const System<double> system = band_case(c, true);
    const FactoredOtf sampler(system, stages, {},
                              {.fx_max = 83.0, .fy_max = 83.0, .table_share = 1e-6, .samples = 1 << 19});
    std::vector<double> fx, fy;
    for (int i = 0; i < 40; ++i) fx.push_back(83.0 * (i + 0.3) / 40.0);
    for (const double y : {0.0, 3.1, 17.0, 44.4}) fy.push_back(y);
    const FactoredOtf::Grid grid(sampler, fx, fy);
    std::vector<Complex<float>> row(fx.size());
    double worst = 0.0;
    for (std::size_t j = 0; j < fy.size(); ++j) {
      grid.complex_row(j, row);
      for (std::size_t i = 0; i < fx.size(); ++i) {
        const Complex<double> exact = system.otf({fx[i], fy[j]});
        worst = std::max(worst, std::hypot(row[i].re - exact.re, row[i].im - exact.im));
      }
    }
    EXPECT_LE(worst, sampler.error() + 3e-7) << c.name;
    EXPECT_LE(sampler.error(), 2e-5) << c.name;
  }
}

// Samples that are smaller by 1e6 along y put the corner far beyond all that turbulence passes along x.
TEST(BandPlan, a_narrow_otf_gets_the_wavelengths_that_it_needs) {
  using namespace literals;
  System<double> system;
  system.frame = {100.0, 18.0, 3.4e-5, 0.01, 0, 0};
  system.band = Band{0.4, 14.0};
  system.add(Stage::presample, Turbulence<double>{.fried_parameter_mm = 20_mm, .wavelength_reference_um = 4_um});
  const std::array stages{Stage::presample};
  const FactoredOtf sampler(system, stages, {}, {.fx_max = 28.0, .fy_max = 1.5e7, .table_share = 1e-6});
  std::vector<double> fx;
  for (int i = 0; i < 20; ++i) fx.push_back(28.0 * (i + 0.3) / 20.0);
  const std::vector<double> fy{0.0};
  const FactoredOtf::Grid grid(sampler, fx, fy);
  std::vector<Complex<float>> row(fx.size());
  grid.complex_row(0, row);
  for (std::size_t i = 0; i < fx.size(); ++i)
    EXPECT_NEAR(row[i].re, system.otf({fx[i], 0.0}).re, sampler.error() + 3e-7) << fx[i];
  EXPECT_LE(sampler.error(), 2e-6);
}

TEST(BandPlan, can_be_ended_by_whoever_hears_of_its_progress) {
  struct Stopped {};
  const System<double> system = band_case(kBandCases[0], true);
  EXPECT_THROW(compile_band_case(system, [](std::int64_t) { throw Stopped(); }), Stopped);
}

}  // namespace
}  // namespace mtf::test
