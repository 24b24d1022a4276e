// SPDX-License-Identifier: Apache-2.0
#pragma once

// The tables of notebooks-data/reference, and the checks that `mtf check` makes of them.

#include <stdexcept>

#include "apps/check/check.h"

namespace mtf::test {

using apps::check::number;
using apps::check::precise;
using apps::check::Row;

inline std::vector<Row> reference_table(const std::string& file) { return apps::check::Tables().rows(file); }

/// One check by component and name, against the built-in tables.
inline apps::check::CheckResult reference_check(std::string_view component, std::string_view name) {
  for (const apps::check::Check& check : apps::check::all_checks())
    if (check.component == component && check.name == name) return run(check, {});
  throw std::runtime_error("no check " + std::string(component) + " " + std::string(name));
}

}  // namespace mtf::test
