// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace apps {

/// Runs gnuplot on `script` (without the user's settings) and returns what it writes to its standard output: the
/// figure, when the script sets no output. Nothing when gnuplot is not installed. Throws RuntimeError with gnuplot's
/// last words when it fails or takes longer than a minute.
std::optional<std::string> run_gnuplot(const std::string& script);

}  // namespace apps
