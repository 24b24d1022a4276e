// SPDX-License-Identifier: Apache-2.0
#pragma once

// What float32, of 24 bits, takes from numbers of more: the rms change of the values of a plane as a share of their
// standard deviation, so that a constant many times as large as the contrast is noticed. Every reader of wider numbers
// counts them here while they are read.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "mtf/error.h"
#include "mtf/words.h"

namespace mtf::io {

/// Values that are refused, of a file that is sound otherwise.
class RoundingError : public RuntimeError {
 public:
  using RuntimeError::RuntimeError;
};

class Rounding {
 public:
  void add(double exact, float rounded) {
    const double error = exact - static_cast<double>(rounded);
    if (!std::isfinite(error)) {
      beyond_ += std::isfinite(exact) ? 1 : 0;
      return;
    }
    if (count_++ == 0) first_ = exact;
    const double d = exact - first_;
    sum_ += d;
    squares_ += d * d;
    errors_ += error * error;
  }

  /// Adds to `notes` what a user has to know. Throws RoundingError above a hundredth. `channel`: "" of a file without.
  void note(const std::string& path, const std::string& channel, std::vector<std::string>& notes) const {
    const auto count = static_cast<double>(std::max<std::int64_t>(count_, 1));
    const double mean = first_ + sum_ / count, rms = std::sqrt(errors_ / count);
    const double std = std::sqrt(std::max(0.0, squares_ / count - sum_ / count * (sum_ / count)));
    constexpr double flat = 1e-13;  // of the mean: such values differ by rounding of their own
    constexpr double noted = 1e-5;  // a tenth of the tolerance that is usual in a run
    constexpr double most = 0.01;
    const double share = std > flat * std::abs(mean) ? rms / std : 0.0;
    const std::string what = channel.empty() ? one_line(path) : "channel " + channel;
    const std::string words = what + ": float32 changes its values by " + significant(100.0 * share, 2) +
                              " % (rms) of their standard deviation " + significant(std, 3) + ", for their mean is " +
                              significant(mean, 6) + "; subtract a constant of about that from the numbers of the file";
    if (share > most) throw RoundingError("cannot read " + (channel.empty() ? "" : path + ", ") + words);
    if (share > noted) notes.push_back(words);
    if (beyond_ > 0)
      notes.push_back(what + ": " + plural(beyond_, "value") + " beyond the 3.4e38 of float32 read as infinity");
  }

 private:
  std::int64_t count_ = 0, beyond_ = 0;
  double first_ = 0.0, sum_ = 0.0, squares_ = 0.0, errors_ = 0.0;
};

}  // namespace mtf::io
