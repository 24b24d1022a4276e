// SPDX-License-Identifier: Apache-2.0
#pragma once

// Wording of what is wrong with a command line, and of errors in general.

#include <string>
#include <vector>

namespace apps {

/// `command` is what was recognised ("mtf config"), `remaining` the words that were not, `options` and `commands` what
/// is possible there; `otherwise` is used when every word was recognised.
std::string usage_complaint(const std::string& command, const std::vector<std::string>& remaining,
                            const std::vector<std::string>& options, const std::vector<std::string>& commands,
                            const std::string& otherwise);

/// An error as it is shown: "mtf: error: ..." on one line, or the file:line:col lines of a sensor file as they are.
/// Control characters of the arguments do not break lines.
std::string error_lines(std::string message, const std::vector<std::string>& arguments);

}  // namespace apps
