// SPDX-License-Identifier: Apache-2.0
#pragma once

// How long the stages of frames took: least, median and most over the frames.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace apps::scene {

/// Times of a stage over the frames.
class StageTimes {
 public:
  void add(const std::string& name, double ms) {
    const auto found = std::find_if(stages_.begin(), stages_.end(), [&](const auto& one) { return one.first == name; });
    if (found == stages_.end())
      stages_.push_back({name, {ms}});
    else
      found->second.push_back(ms);
  }
  struct Row {
    std::string name;
    double least, median, most;
  };
  /// A stage that not all of `frames` had took no time in the others.
  std::vector<Row> rows(std::size_t frames) const {
    std::vector<Row> out;
    for (const auto& [name, ms] : stages_) {
      std::vector<double> sorted = ms;
      sorted.resize(std::max(frames, ms.size()), 0.0);
      std::sort(sorted.begin(), sorted.end());
      out.push_back({name, sorted.front(), sorted[sorted.size() / 2], sorted.back()});
    }
    return out;
  }

 private:
  std::vector<std::pair<std::string, std::vector<double>>> stages_;
};

}  // namespace apps::scene
