// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which channels of a file are read: one rule for every format.

#include <string>
#include <vector>

#include "mtf/io/image_io.h"

namespace mtf::io {

struct ChannelChoice {
  std::vector<std::size_t> indices;  ///< into FileInfo::channels; all in one part
  std::vector<std::string> names;    ///< "R","G","B" for a colour triple, else the full name
};

/// Part before the last '.' and the part after it.
std::string layer_of(const std::string& channel_name);
std::string base_of(const std::string& channel_name);

/// Applies `options` to the channels as `read_image` documents it. Deep channels have type "deep ..." and are refused
/// by name. Throws UsageError that lists what there is and how to choose.
ChannelChoice choose_channels(const std::string& path, const std::vector<ChannelInfo>& channels,
                              const ReadOptions& options);

}  // namespace mtf::io
