// SPDX-License-Identifier: Apache-2.0
#pragma once

// designs.csv of a sweep: read once in pieces, checked against sweep.json, thinned out where it is too large for a
// page.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/report/report_sweep.h"

namespace apps {

/// The rows that a report holds, with every cell as the file has it.
struct DesignTable {
  std::vector<std::int64_t> design;             ///< number of each row, rising
  std::vector<std::vector<std::string>> cells;  ///< by row, then by column of the sweep; "" for none
  std::int64_t every = 1;         ///< beside the Pareto front and the named designs one of so many is here
  std::int64_t pareto_every = 1;  ///< and of the front, too
  std::string sha256;             ///< of the file

  bool whole() const { return every == 1; }
  /// Row of a design.
  std::optional<std::size_t> row(std::int64_t design) const;
};

/// What a page may hold.
struct TableLimits {
  std::int64_t rows = 20000;
  std::int64_t bytes = 500'000;  ///< of the rows as the file has them
};

/// Reads DIR/designs.csv. All rows where they fit the limits; else the best, chosen and nearest designs, the Pareto
/// front (where it takes more than half of the room, every pareto_every-th of it) and of all others one in `every`,
/// drawn by a fixed hash of its number. Throws UsageError "file:line: ..." where it does not fit sweep.json,
/// RuntimeError when it cannot be read.
DesignTable read_designs(const Sweep& sweep, const TableLimits& limits = {});

/// A cell as a finite number, whatever the locale.
std::optional<double> cell_value(const std::string& cell);

}  // namespace apps
