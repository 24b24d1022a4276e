// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files of the page, written into the command when it is built (EmbedFiles.cmake).

#include <string>

#include "apps/live/server.h"

namespace apps::live {

/// The file of that path, "/" for the page; null for any other. The list is all there is: no path reaches the disk.
const PageFile* find_page_file(const std::string& path);

}  // namespace apps::live
