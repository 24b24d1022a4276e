// SPDX-License-Identifier: Apache-2.0

// Planning with a band against planning at its middle: aberrated pupils, 1024 x 1024 samples, tolerance 1e-4, one
// thread. Output: a table; minimum and median of interleaved runs in s, their ratio by the minimum, and whether a band
// takes at most 12 times its own wavelength or 1 s, whichever is more, and never above 3 s (the exit code is 1 when a
// row does not).

#include <algorithm>
#include <cstdio>

#include "mtf/version.h"
#include "tests/bench/interleave.h"
#include "tests/mtf/band_cases.h"

int main() {
  using namespace mtf;  // NOLINT: a benchmark program
  std::printf("%s\n%-34s %9s %9s %9s %9s %7s\n", std::string(git_commit).c_str(), "case", "one min", "median",
              "band min", "median", "ratio");
  bool good = true;
  for (const test::BandCase& c : test::kBandCases) {
    const System<double> one = test::band_case(c, false), band = test::band_case(c, true);
    const auto times =
        bench::interleave({[&] { test::compile_band_case(one); }, [&] { test::compile_band_case(band); }}, 5);
    const double limit = std::min(3.0, std::max(1.0, 12.0 * 1e-3 * times[0].min_ms));
    const bool kept = 1e-3 * times[1].min_ms <= limit;
    good = good && kept;
    std::printf("%-34s %9.3f %9.3f %9.3f %9.3f %7.1f %s\n", c.name, 1e-3 * times[0].min_ms, 1e-3 * times[0].median_ms,
                1e-3 * times[1].min_ms, 1e-3 * times[1].median_ms, times[1].min_ms / times[0].min_ms,
                kept ? "" : "too long");
  }
  return good ? 0 : 1;
}
