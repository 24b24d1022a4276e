// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names in the OpenEXR files of a command line, for completion. Words that are no such file, and files that cannot be
// read, have none; only headers are read.

#include <string>
#include <vector>

namespace apps {

std::vector<std::string> channels_on(const std::vector<std::string>& line);
std::vector<std::string> layers_on(const std::vector<std::string>& line);
std::vector<std::string> parts_on(const std::vector<std::string>& line);

}  // namespace apps
