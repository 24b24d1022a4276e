// SPDX-License-Identifier: Apache-2.0
#pragma once

// The frames of a stack through the estimators, one after the other: memory is that of a few planes for any number.

#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>

#include "apps/characterize/stacks_file.h"
#include "calib/characterize/characterize.h"
#include "mtf/io/image_io.h"

namespace apps {

/// What all stacks share.
struct FrameSource {
  int bits = 16;
  int threads = 1;
  std::unordered_map<std::uint64_t, std::string> seen{};  ///< hashes of frames, and where they were
  std::uint32_t used = 0;                                 ///< bits that occur in any value
  std::vector<std::string> warnings{};
  std::function<void()> progress{};  ///< after each file
};

/// What a file holds, by its header.
struct FrameShape {
  std::int64_t frames = 1, width = 0, height = 0;
  std::string type;  ///< "uint16"
};
using StackShapes = std::vector<FrameShape>;  ///< of the files of a stack

std::string words_of(const FrameShape& shape);
/// Throws UsageError for a picture that is no raw frame: JPEG, behind a stated curve, of several planes.
void require_frame(const std::string& path, const mtf::io::ImageFile& picture);
/// Of each stack. Throws UsageError for files that hold no frames, behind a stated curve, and JPEG, for frames of other
/// sizes or types, single ones, and a type that does not hold the bits; RuntimeError where a file cannot be read.
std::vector<StackShapes> shapes_of(const StacksFile& file, int bits, int threads);

/// Throws UsageError with file and remedy for frames of several planes, of another size than the first, with NaN, with
/// values beyond the bits or in larger steps than stated, bytes in the other order, and for a frame that was there
/// before; RuntimeError where a file cannot be read.
calib::Stack read_stack(const StackEntry& entry, const StackShapes& shapes, const StacksFile& file,
                        FrameSource& source);

/// The same frames once more: the values of the pixels of `series`, whose places are given.
void read_series(const StackEntry& entry, const StackShapes& shapes, const StacksFile& file, int threads,
                 calib::PixelSeries& series);

}  // namespace apps
