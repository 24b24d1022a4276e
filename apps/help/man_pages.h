// SPDX-License-Identifier: Apache-2.0
#pragma once

// Manual pages (roff, section 1) of the command and all below it, from the descriptions that --help shows.

#include <string>
#include <string_view>

#include "apps/command_line.h"

namespace apps {

/// Of every command.
inline constexpr std::string_view kExitCodes =
    "0 ok, 1 run time or files, 2 usage or config, 3 a check failed, 130 interrupted.";

/// Writes mtf.1, mtf-curve.1, mtf-config-init.1 and so on into the folder. Their date is SOURCE_DATE_EPOCH where the
/// environment has it, else today. Throws RuntimeError.
void write_man_pages(const Command& root, const std::string& folder);

}  // namespace apps
