// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbered files: "frame.%04d.exr" is frame.0001.exr, frame.0002.exr, ... as printf would write them.

#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "apps/simulate/simulate_options.h"

namespace apps {

class FrameNames {
 public:
  /// Nothing when the name holds no conversion (%d, %4d, %04d); then it is the name of one file, whatever else is in
  /// it. In a numbered name %% is a percent sign. Throws UsageError for a second conversion, one in a folder's name,
  /// and absurd widths.
  static std::optional<FrameNames> parse(const std::string& path);

  const std::string& pattern() const { return pattern_; }
  std::string name(std::int64_t frame) const;
  /// The frame that a path in any spelling of the folder stands for, or nothing.
  std::optional<std::int64_t> frame_of(const std::string& path) const;

  /// Whether a path stands for one of these frames, which rise.
  bool is_among(const std::vector<std::int64_t>& frames, const std::string& path) const;
  /// Names of those of these frames, which rise, that are links, in their order.
  std::vector<std::string> links(const std::vector<std::int64_t>& frames) const;

  /// Frames to work on, in rising order: those of the range, or without one all that are in the folder. Throws
  /// RuntimeError naming the first frame that is missing: one of the range, or one between two that are there (their
  /// numbers go up by the smallest step between neighbours).
  std::vector<std::int64_t> find(const std::optional<FrameRange>& range) const;

 private:
  /// In no order.
  std::vector<std::int64_t> numbers_in_folder(std::error_code& error) const;
  std::vector<std::int64_t> in_folder() const;

  std::string pattern_, folder_;  ///< folder with its final slash, "" for the current one
  std::string before_, after_;    ///< of the number, in the name of the file
  int width_ = 0;
  char fill_ = ' ';
};

/// The frames of a range, in order. Throws UsageError for a range that FrameRange does not allow, and for more than ten
/// million frames.
std::vector<std::int64_t> frames_of(const FrameRange& range);

}  // namespace apps
