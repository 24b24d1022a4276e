// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON as it is written and printed.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace apps {

/// The text with a new line at its end, indented by `indent`, on one line where that is -1. JSON is UTF-8 and names of
/// files are any bytes: those that are no UTF-8 become U+FFFD. Every JSON goes through here, as a name that ended the
/// writer would take the results of hours with it.
std::string json_document(const nlohmann::json& json, int indent = 2);
std::string json_document(const nlohmann::ordered_json& json, int indent = 2);

}  // namespace apps
