// SPDX-License-Identifier: Apache-2.0
#pragma once

// The JSON body of a request.

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/live/edits.h"
#include "apps/text/json.h"
#include "mtf/error.h"

namespace apps::live {

/// A body, its values checked as they are asked for.
struct RequestBody {
  Json json;

  std::int64_t whole(const char* key, std::int64_t least, std::int64_t most, std::int64_t otherwise) const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return otherwise;
    const double value = found->is_number_integer() ? found->get<double>() : std::nan("");
    if (!(value >= static_cast<double>(least) && value <= static_cast<double>(most)))
      throw mtf::UsageError(std::string(key) + ": a whole number from " + std::to_string(least) + " to " +
                            std::to_string(most) + " belongs here");
    return found->get<std::int64_t>();
  }
  std::optional<double> number(const char* key) const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return std::nullopt;
    if (!found->is_number()) throw mtf::UsageError(std::string(key) + ": a number belongs here");
    return found->get<double>();
  }
  std::string text(const char* key, const std::string& otherwise = "") const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return otherwise;
    if (!found->is_string() || found->get<std::string>().size() > 100)
      throw mtf::UsageError(std::string(key) + ": a short text belongs here");
    return found->get<std::string>();
  }
  bool flag(const char* key) const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return false;
    if (!found->is_boolean()) throw mtf::UsageError(std::string(key) + ": true or false belongs here");
    return found->get<bool>();
  }
  std::vector<Edit> edits(const char* key) const {
    const Json* found = json.find(key);
    return found ? read_edits(*found) : std::vector<Edit>();
  }
  std::int64_t generation() const { return whole("generation", 0, std::int64_t{1} << 53, 0); }
  std::optional<double> tolerance() const {
    const auto asked = number("tolerance");
    if (asked && !(*asked > 0.0 && *asked < 1.0)) throw mtf::UsageError("--tolerance: is outside (0, 1)");
    return asked;
  }
};

}  // namespace apps::live
