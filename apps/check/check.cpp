// SPDX-License-Identifier: Apache-2.0
#include "apps/check/check.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include "mtf/error.h"
#include "mtf/units.h"

namespace apps::check {
namespace {

std::vector<std::string> cells_of(std::string line) {
  if (line.ends_with('\r')) line.pop_back();
  std::vector<std::string> cells;
  std::istringstream stream(line + ",");  // a last empty cell is a cell
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

template <class T>
T parsed(const Row& row, std::string_view column, T (*parse)(const char*, char**)) {
  const std::string& text = row.at(column);
  char* end = nullptr;
  const T value = parse(text.c_str(), &end);
  if (text.empty() || *end != '\0')
    throw mtf::UsageError(row.where + ": '" + text + "' in column " + std::string(column) + " is not a number");
  return value;
}

}  // namespace

bool Tally::note(long double error, long double scale, long double allowed) {
  ++count_;
  if (!std::isfinite(error)) error = std::numeric_limits<long double>::infinity();
  worst_abs_ = std::max(worst_abs_, static_cast<double>(error));
  if (std::abs(scale) >= std::numeric_limits<double>::min())
    worst_rel_ = std::max(worst_rel_, static_cast<double>(error / std::abs(scale)));
  if (error <= allowed) return false;
  const long double excess = allowed > 0.0L ? error / allowed : std::numeric_limits<long double>::infinity();
  if (!failure_.empty() && !(excess > worst_excess_)) return false;
  worst_excess_ = excess;
  return true;
}

void Tally::compare(double value, long double exact, long double allowed, std::string_view where) {
  const long double error = std::abs(value - exact);
  if (note(error, exact, allowed))
    failure_ = std::string(where) + ": " + mtf::format_double(value) + " instead of " +
               mtf::format_double(static_cast<double>(exact)) + ", off by " +
               mtf::format_double(static_cast<double>(error)) + " where " +
               mtf::format_double(static_cast<double>(allowed)) + " is allowed";
}

void Tally::error(long double error, long double scale, long double allowed, std::string_view where) {
  if (note(error, scale, allowed))
    failure_ = std::string(where) + ": an error of " + mtf::format_double(static_cast<double>(error)) + " where " +
               mtf::format_double(static_cast<double>(allowed)) + " is allowed";
}

std::vector<Check> all_checks(const mtf::DeviceChoice& device) {
  if (device.device) return engine_checks(device);
  std::vector<Check> all;
  for (const auto family : {special_checks, pupil_checks, aberration_checks, turbulence_checks, motion_checks,
                            component_checks, radiometry_checks})
    for (Check& check : family()) all.push_back(std::move(check));
  for (Check& check : engine_checks()) all.push_back(std::move(check));
  return all;
}

CheckResult run(const Check& check, const Tables& tables) {
  Tally tally;
  check.run(tables, tally);
  return {check.component,
          check.name,
          check.promise,
          tally.count(),
          tally.worst_abs(),
          tally.worst_rel(),
          tally.failure().empty() && tally.count() > 0,
          tally.count() > 0 ? tally.failure() : "nothing was compared"};
}

const std::string& Row::at(std::string_view column) const {
  const auto cell = cells.find(column);
  if (cell == cells.end()) throw mtf::UsageError(where + ": no column " + std::string(column));
  return cell->second;
}

double number(const Row& row, std::string_view column) { return parsed<double>(row, column, std::strtod); }
long double precise(const Row& row, std::string_view column) { return parsed<long double>(row, column, std::strtold); }

std::vector<Row> parse_table(const std::string& name, std::string_view text) {
  std::istringstream in{std::string(text)};
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> header = cells_of(line);
  std::vector<Row> rows;
  for (int number = 2; std::getline(in, line); ++number) {
    const std::vector<std::string> values = cells_of(line);
    Row row{name + ":" + std::to_string(number), {}};
    if (values.size() != header.size())
      throw mtf::UsageError(row.where + ": " + std::to_string(values.size()) + " cells under " +
                            std::to_string(header.size()) + " columns");
    for (std::size_t i = 0; i < header.size(); ++i) row.cells[header[i]] = values[i];
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw mtf::UsageError(name + ": no rows below the header");
  return rows;
}

Tables::Tables(const std::string& folder) {
  std::vector<std::string_view> known;
  for (const BuiltInTable& table : built_in_tables()) known.push_back(table.name);
  std::error_code failed;
  std::filesystem::directory_iterator files(folder, failed);
  if (failed) throw mtf::UsageError(folder + ": " + failed.message() + "; give a folder of reference tables");
  for (const auto& file : files) {
    const std::string name = file.path().filename().string();
    if (!name.ends_with(".csv")) continue;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      const auto meant = mtf::nearest(name, known);
      throw mtf::UsageError(file.path().string() + ": no check reads a table of this name" +
                            (meant ? "; did you mean " + *meant + "?" : ""));
    }
    // Gradients and exponents are references of the test suite, not of these checks.
    if (name == "gradients.csv" || name == "kolmogorov.csv")
      throw mtf::UsageError(file.path().string() + ": no check reads this table; remove it from the folder");
    constexpr std::uintmax_t kMostBytes = std::uintmax_t{64} << 20;
    if (!file.is_regular_file(failed)) throw mtf::UsageError(file.path().string() + ": not an ordinary file");
    if (file.file_size(failed) > kMostBytes || failed)
      throw mtf::UsageError(file.path().string() + ": larger than 64 MiB, which no reference table is");
    std::ifstream in(file.path(), std::ios::binary);
    own_[name] = {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!in) throw mtf::RuntimeError(file.path().string() + ": cannot be read");
  }
  if (own_.empty()) throw mtf::UsageError(folder + ": no reference tables (.csv) in this folder");
}

std::vector<Row> Tables::rows(const std::string& name) const {
  if (const auto own = own_.find(name); own != own_.end()) return parse_table(name, own->second);
  for (const BuiltInTable& table : built_in_tables())
    if (table.name == name) return parse_table(name, table.text);
  throw mtf::RuntimeError(name + ": this build has no such reference table");
}

}  // namespace apps::check
