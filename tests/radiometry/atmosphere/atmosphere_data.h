// SPDX-License-Identifier: Apache-2.0
#pragma once

// The shared tables of transmittances (their README says what they are), and air as their runs had it.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "radiometry/atmosphere/spectral_path.h"

namespace atmosphere_tests {

using namespace radiometry::atmosphere;

/// Empty without the shared data.
inline std::string shared_table(const std::string& name) {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const std::filesystem::path shared =
      chosen != nullptr ? std::filesystem::path(chosen) : std::filesystem::path(MTFKIT_SOURCE_DIR) / "../shared";
  const auto file = shared / "data/atmosphere" / name;
  return std::filesystem::exists(file) ? file.string() : "";
}

struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> rows;

  std::size_t column(const std::string& name) const {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == name) return i;
    throw std::runtime_error("no column " + name);
  }
  /// NaN for an empty cell.
  double number(std::size_t row, std::size_t column) const {
    const std::string& text = rows[row][column];
    return text.empty() ? std::nan("") : std::stod(text);
  }
};

inline Table read_table(const std::string& path) {
  std::ifstream file(path);
  Table table;
  std::string line;
  while (std::getline(file, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<std::string> cells;
    std::string cell;
    std::istringstream in(line);
    while (std::getline(in, cell, ',')) cells.push_back(cell);
    if (!line.empty() && line.back() == ',') cells.emplace_back();
    if (table.names.empty())
      table.names = cells;
    else
      table.rows.push_back(cells);
  }
  return table;
}

/// Air of one level that holds nothing but what is set.
inline Air<double> one_level(double pressure_hpa, double temperature_k) {
  Level<double> level;
  level.altitude_m = 20000.0;  // dry air is no condition up there
  level.pressure_pa = 100.0 * pressure_hpa;
  level.temperature_k = temperature_k;
  return {.profile = {"one level", {level}}};
}

inline SpectralPath<double> along(const Air<double>& air, double range_km) {
  return spectral_path(air, Sight<double>(Horizontal<double>{.altitude_m = 20000.0, .range_m = 1e3 * range_km}),
                       {.components = true});
}

inline const std::vector<double>& of(const SpectralPath<double>& path, Component component) {
  return path.component[static_cast<std::size_t>(component)];
}

/// The sample of a wavenumber.
inline std::size_t index_of(const SpectralPath<double>& path, double wavenumber_cm) {
  const auto found = std::lower_bound(path.wavenumber_cm.begin(), path.wavenumber_cm.end(), wavenumber_cm - 1e-6);
  return static_cast<std::size_t>(found - path.wavenumber_cm.begin());
}

}  // namespace atmosphere_tests
