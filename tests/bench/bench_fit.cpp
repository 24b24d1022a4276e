// SPDX-License-Identifier: Apache-2.0
// Scatter of fitted parameters against the Cramer-Rao bound, and how often the stated intervals hold the truth.
//   bench_fit [DRAWS] [PART OF A CASE'S NAME]
#include <cstdio>
#include <string>

#include "tests/calib/fit_study.h"

int main(int argc, char** argv) {
  const int draws = argc > 1 ? std::atoi(argv[1]) : 2000;
  const std::string chosen = argc > 2 ? argv[2] : "";
  if (draws < 2) {
    std::fprintf(stderr, "usage: bench_fit [DRAWS >= 2] [PART OF A CASE'S NAME]\n");
    return 2;
  }
  std::printf("%d draws; sd / bound of parameter and MTF50, share of intervals that hold the truth\n", draws);
  std::printf("%-22s %8s %8s %6s | %8s %8s %6s | %5s %5s %5s %5s | %8s %5s %5s %6s\n", "case", "bias %", "sd %",
              "/bound", "bias50 %", "sd50 %", "/bound", "68", "95", "68m", "95m", "rms dMTF", "fail", "wrong", "ms");
  for (const fit_study::Case& one : fit_study::cases()) {
    if (one.name.find(chosen) == std::string::npos) continue;
    const fit_study::Outcome o = fit_study::run(one, draws, 20261121);
    std::printf("%-22s %+8.3f %8.3f %6.3f | %+8.3f %8.3f %6.3f | %5.1f %5.1f %5.1f %5.1f | %8.5f %5d %5d %6.2f\n",
                one.name.c_str(), 100 * o.bias, 100 * o.sd, o.sd / o.bound, 100 * o.bias_mtf50, 100 * o.sd_mtf50,
                o.sd_mtf50 / o.bound_mtf50, 100 * o.cover68, 100 * o.cover95, 100 * o.cover68_mtf50,
                100 * o.cover95_mtf50, o.rms_mtf, o.failed, o.flagged_wrong, o.ms);
    std::fflush(stdout);
  }
  return 0;
}
