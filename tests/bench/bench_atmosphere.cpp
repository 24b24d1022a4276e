// SPDX-License-Identifier: Apache-2.0

// The built-in atmosphere on one thread: single spectral paths, tables of 64 ranges, the sky. Floors: the exponentials
// alone that each needs, one a wavenumber and layer for the transmission and one for Planck's law.

#include <array>
#include <cmath>
#include <cstdio>

#include "mtf/version.h"
#include "radiometry/atmosphere/range_table.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "tests/bench/interleave.h"

namespace {

using namespace radiometry::atmosphere;

double end_of(const SpectralPath<double>& path) { return path.transmission.back() + path.transmission.front(); }

/// As many exponentials, of numbers that differ.
double exponentials(std::size_t count) {
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += std::exp(-1e-3 * static_cast<double>(i % 4096));
  return sum;
}

}  // namespace

int main() {
  const Air<double> air{model_profile(ModelAtmosphere::mid_latitude_summer),
                        {HazeKind::rural, 23e3, Season::spring_summer}};
  const Sight<double> level = Horizontal<double>{0.0, 2000.0}, zenith = ToSpace<double>{0.0, 0.0},
                      down = AtAngle<double>{8000.0, 2.3, 10000.0};
  std::array<double, 64> ranges{};
  for (std::size_t i = 0; i < ranges.size(); ++i) ranges[i] = 10.0 * std::pow(1000.0, static_cast<double>(i) / 63.0);
  const SpectralOptions middle{.band = {3.0, 5.0}}, far{.band = {7.5, 13.5}},
      some{.band = {7.5, 13.5}, .components = false, .tolerance = 1e-3};

  double sum = 0.0;  // what is computed is used
  struct Case {
    const char* name;
    std::function<void()> work;
  };
  const std::vector<Case> cases{
      {"horizontal, 0.4 to 15.4 um", [&] { sum += end_of(spectral_path(air, level)); }},
      {"ground to space, 0.4 to 15.4 um", [&] { sum += end_of(spectral_path(air, zenith)); }},
      {"  floor: its exponentials", [&] { sum += exponentials(47 * (1646 + 571)); }},
      {"ground to space, 7.5 to 13.5 um", [&] { sum += end_of(spectral_path(air, zenith, far)); }},
      {"  the same within 1e-3", [&] { sum += end_of(spectral_path(air, zenith, some)); }},
      {"64 ranges, horizontal, 3 to 5 um",
       [&] { sum += path_table(air, level, ranges, middle).table.range_m().back(); }},
      {"  floor: its exponentials", [&] { sum += exponentials(64 * 2 * 268); }},
      {"64 ranges, slant, 3 to 5 um", [&] { sum += path_table(air, down, ranges, middle).table.range_m().back(); }},
      {"64 ranges, slant, 0.4 to 15.4 um", [&] { sum += path_table(air, down, ranges).table.range_m().back(); }},
      {"sky flux, 8 angles and 4", [&] { sum += sky_flux(air, 0.0).total_w_m2; }}};
  std::vector<std::function<void()>> work;
  for (const Case& one : cases) work.push_back(one.work);
  std::printf("mtfkit %s (%s); one thread\n%-36s %10s %10s\n", mtf::version, mtf::git_commit, "", "min ms",
              "median ms");
  const auto timings = bench::interleave(work, 25);
  for (std::size_t i = 0; i < cases.size(); ++i)
    std::printf("%-36s %10.3f %10.3f\n", cases[i].name, timings[i].min_ms, timings[i].median_ms);
  return std::isfinite(sum) ? 0 : 1;
}
