// SPDX-License-Identifier: Apache-2.0
#pragma once

// An instant as an option gives it.

#include <optional>
#include <string>

#include "apps/text/words.h"
#include "mtf/error.h"
#include "radiometry/heat/weather/instant.h"

namespace apps {

/// UTC, s; nothing for "". Throws mtf::UsageError that names the option.
inline std::optional<double> instant_of(const std::string& option, const std::string& text) {
  if (text.empty()) return std::nullopt;
  radiometry::heat::InstantError error;
  const auto instant = radiometry::heat::parse_instant(text, error);
  if (!instant) throw mtf::UsageError(option + ": " + one_line(text) + ": " + error.text);
  return instant;
}

}  // namespace apps
