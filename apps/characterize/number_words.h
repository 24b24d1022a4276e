// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace apps {

/// What a number of a camera, calib::Finding, is: a sentence, with a unit where it has one. "" for a name that has
/// none.
std::string_view number_words(std::string_view name);

}  // namespace apps
