// SPDX-License-Identifier: Apache-2.0
#pragma once

// Components and tables of the sensor file in words: apps/sensor/sensor_kinds.h as text and as Markdown.

#include <string>
#include <string_view>

#include "apps/sensor/sensor_kinds.h"

namespace apps {

/// The component of that kind ("" = every one): what it is, the lists it may stand in, its physics, and each parameter
/// with its range, whether it is needed, and an example. Or the table of the chain of that name, with its keys; or
/// `study`, `conditions`, `metrics` and each metric. Throws as require_kind.
std::string describe_kinds(const std::string& kind);

/// All that describe_kinds takes.
std::vector<std::string> names_of_kinds();
/// Throws UsageError for a name that is none of these, with what was meant.
void require_kind(const std::string& kind);

/// The same as Markdown, one section a kind; for every kind with an introduction and a table of contents: the whole of
/// mtf/components/README.md.
std::string kinds_markdown(const std::string& kind);

/// "[0, 1)", or the words of a choice: "x | y".
std::string range_of(const Parameter& parameter);
std::string_view presence_of(const Parameter& parameter);

}  // namespace apps
