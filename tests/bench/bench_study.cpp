// SPDX-License-Identifier: Apache-2.0
// Designs a second of one core: twelve components, all metrics but range models, by tolerance; monochromatic optics and
// a band. Processor time, in rounds of 2000 designs (200 below 1e-5); the error is the largest reported.
//   bench_study [ROUNDS]
#include <algorithm>
#include <cstdio>

#include "apps/study/design/evaluator.h"
#include "tests/apps/study/satellite.h"
#include "tests/apps/study/study_files.h"

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 9;
  if (rounds < 1) {
    std::fprintf(stderr, "usage: bench_study [ROUNDS >= 1]\n");
    return 2;
  }
  std::printf("%-14s %9s %12s %12s %14s %14s %12s\n", "optics", "tolerance", "us min", "us median", "1/s best",
              "1/s median", "error");
  for (const bool monochromatic : {true, false})
    for (const char* tolerance : {"1e-2", "1e-4", "1e-6", "1e-9"}) {
      const study_test::Folder folder;
      folder.write("satellite.toml", study_test::satellite(monochromatic));
      folder.write("study.toml", study_test::satellite_study(65536, tolerance));
      study::Evaluator evaluator(study::load_study(folder / "study.toml"));
      std::vector<double> row(study::columns_of(*study::load_study(folder / "study.toml")).size());
      const int designs = std::atof(tolerance) < 1e-5 || !monochromatic ? 200 : 2000;
      std::vector<double> us;
      double error = 0.0;
      evaluator.evaluate(0, row);
      for (int round = 0; round < rounds; ++round) {
        const std::clock_t start = std::clock();
        for (int i = 0; i < designs; ++i) {
          evaluator.evaluate(round * designs + i, row);
          error = std::max(error, row.back());
        }
        us.push_back(1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / designs);
      }
      std::sort(us.begin(), us.end());
      const double median = us[us.size() / 2];
      std::printf("%-14s %9s %12.1f %12.1f %14.0f %14.0f %12.1e\n", monochromatic ? "monochromatic" : "band", tolerance,
                  us.front(), median, 1e6 / us.front(), 1e6 / median, error);
      std::fflush(stdout);
    }
  return 0;
}
