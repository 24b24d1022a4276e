// SPDX-License-Identifier: Apache-2.0
#pragma once

// What there is to know of an image file before it is simulated.

#include <optional>
#include <string>
#include <vector>

#include "apps/options.h"
#include "mtf/engines/statistics.h"
#include "mtf/io/image_io.h"

namespace apps {

struct ChannelFacts {
  mtf::io::ChannelInfo channel;
  std::optional<mtf::Statistics> statistics;  ///< nothing for channels that are not read
  std::optional<double> min, max, mean, std;  ///< of the finite pixels, nothing when there is none
};

struct ImageFacts {
  std::string path;
  mtf::io::FileInfo info;
  std::vector<ChannelFacts> channels;  ///< those that were asked for, in the file's order
  std::string values;                  ///< what a value means: stated in the file, or what is assumed
  std::vector<std::string> remarks;
  std::string next;  ///< command to run next, "" when nothing in the file can be read
};

/// Reads the header and, one plane at a time, the pixels. Statistics are left out, with a remark, where they would take
/// minutes. Throws as read_info and read_image.
ImageFacts image_facts(const InfoOptions& options);

}  // namespace apps
