// SPDX-License-Identifier: Apache-2.0
#include "apps/text/json_document.h"

#include <nlohmann/json.hpp>

namespace apps {
namespace {

template <class Json>
std::string text_of(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string json_document(const nlohmann::json& json, int indent) { return text_of(json, indent); }
std::string json_document(const nlohmann::ordered_json& json, int indent) { return text_of(json, indent); }

}  // namespace apps
