// SPDX-License-Identifier: Apache-2.0
// How often the stated 95 % intervals of measure_edge hold on the edges of tests/calib/edge_kinds.h.
//   bench_kinds [draws = 200] [seed = 1] [part of a kind's name]
// A column is a figure: percentage of the intervals that hold, median deviation / scatter, and where some are missing
// the percentage of the draws that state it. At the end: percentage refused, with a warning, and the words of more than
// one draw in twenty.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "tests/calib/edge_kinds.h"

int main(int argc, char** argv) {
  const int draws = argc > 1 ? std::atoi(argv[1]) : 200;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (draws < 2) return 2;
  std::printf("%-44s", "held %, mean error / sd, median sd x 1e4");
  for (const char* figure : made::kFigureNames) std::printf("| %-16s", figure);
  std::printf("| ref warn\n");
  for (const made::Kind& kind : made::edge_kinds(argc > 3 ? argv[3] : "")) {
    made::Coverage found = made::coverage_of(kind, draws, seed);
    std::printf("%-44s", kind.name.c_str());
    for (std::size_t k = 0; k < made::kFigures; ++k) {
      std::vector<double>& sd = found.sd[k];
      const auto middle = sd.begin() + static_cast<std::ptrdiff_t>(sd.size() / 2);
      std::nth_element(sd.begin(), middle, sd.end());
      std::printf("| %5.1f %+5.1f %4.0f", 100.0 * found.held[k] / std::max(1, found.stated[k]), found.bias[k],
                  sd.empty() ? NAN : 1e4 * *middle);
    }
    std::map<std::string, int> words;
    for (const std::string& word : found.words) ++words[word];
    std::printf("| %3.0f %3.0f", 100.0 * found.refused / draws, 100.0 * found.warned / draws);
    for (const auto& [word, count] : words)
      if (count > draws / 20) std::printf(" %d x %.60s;", count, word.c_str());
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
}
