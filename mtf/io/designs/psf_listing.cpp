// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/designs/psf_listing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/error.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

std::vector<double> numbers_in(std::string_view line) {
  std::vector<double> numbers;
  for (const std::string& word : design_words(line))
    if (const auto value = design_number(word)) numbers.push_back(*value);
  return numbers;
}

/// The number of the line that begins with `words`; where it is not, the remedy.
std::size_t line_of(const DesignText& text, std::string_view words) {
  const std::size_t line = text.find(words);
  if (line == text.lines.size())
    throw UsageError(text.source + ": no line \"" + std::string(words) + " ...\"; save the whole text of the analysis");
  return line;
}

/// Two whole numbers from 1 to `most` in a line.
std::array<std::size_t, 2> pair_in(const DesignText& text, std::size_t line, double most) {
  const std::vector<double> numbers = numbers_in(text.lines[line]);
  const auto good = [&](double n) { return n >= 1.0 && n <= most && n == std::floor(n); };
  if (numbers.size() != 2 || !good(numbers[0]) || !good(numbers[1]))
    throw UsageError(text.where(line) + "two whole numbers from 1 to " + format_double(most) + " belong here; \"" +
                     printable(text.lines[line], 80) + "\"");
  return {static_cast<std::size_t>(numbers[0]), static_cast<std::size_t>(numbers[1])};
}

}  // namespace

bool is_psf_listing(const DesignText& text) { return text.has("PSF Data") && text.has("Data spacing is"); }

PsfListing read_psf_listing(const DesignText& text, const DesignReading& reading) {
  PsfListing psf;
  std::vector<std::string>& notes = psf.remarks.notes;
  const bool huygens = text.has("Huygens PSF");
  const std::size_t spacing_at = line_of(text, "Data spacing is"), size_at = line_of(text, "Image grid size");
  const auto [columns, rows] = pair_in(text, size_at, 16384.0);
  std::size_t bytes = 0;
  for (const std::string& line : text.lines) bytes += line.size() + 1;
  if (static_cast<std::size_t>(rows * columns) > bytes / 2 + 1)
    throw UsageError(text.where(size_at) + "the listing is too short for that grid; save the whole text");
  const std::size_t centre_at = line_of(text, "Center point is");
  auto [row, column] = pair_in(text, centre_at, static_cast<double>(std::max(rows, columns)));
  if (huygens) std::swap(row, column), row = rows + 1 - row;
  if (row < 1 || row > rows || column > columns)
    throw UsageError(text.where(centre_at) + "the centre lies outside of the grid");

  const auto spacing = design_length_um(text.lines[spacing_at]);
  if (!spacing || !(*spacing > 0.0))
    throw UsageError(text.where(spacing_at) +
                     "the spacing or its unit is missing; a line says Data spacing is 0.288 µm.");
  psf.step_um = *spacing;
  if (const std::size_t area_at = text.find("Data area is"); area_at < text.lines.size()) {
    const std::vector<double> area = numbers_in(text.lines[area_at]);
    const double samples = static_cast<double>(columns), shown = numbers_in(text.lines[spacing_at])[0];
    const double step = area.empty() ? 0.0 : area[0] / samples * (*spacing / shown);
    if (std::abs(step - *spacing) < 0.01 * *spacing) psf.step_um = step;
  }
  const std::string above = spacing_at > 0 ? text.lines[spacing_at - 1] : "";  // 0.5500 µm at 0.0000, 7.0000 (deg).
  if (const std::size_t at = above.find(" at "); at != std::string::npos) {
    psf.place = design_field(above.substr(at));
    notes.push_back(text.source + ": diffraction is in it, of " + printable(trimmed(above.substr(0, at)), 80) +
                    " and no other [band]");
    if (psf.place && reading.y_up) psf.place->y = 0.0 - psf.place->y;
  }

  const std::size_t below = row - 1, right = column - 1;  // of the centre, from the first row and column
  const std::size_t half_y = std::max(below, rows - row), half_x = std::max(right, columns - column);
  std::size_t read = 0;
  for (std::size_t i = size_at + 1; i < text.lines.size(); ++i) {
    const std::vector<double> values = design_row(text.lines[i], text.where(i));
    if (values.empty()) continue;
    if (values.size() != columns || read == rows)
      throw UsageError(text.where(i) + "row " + std::to_string(read + 1) + " has " + std::to_string(values.size()) +
                       " values; the listing says " + std::to_string(rows) + " rows of " + std::to_string(columns));
    if (psf.samples.empty()) psf.samples.assign(2 * half_y + 1, std::vector<double>(2 * half_x + 1, 0.0));
    std::ranges::copy(values,
                      psf.samples[read++ + half_y - below].begin() + static_cast<std::ptrdiff_t>(half_x - right));
  }
  if (read != rows)
    throw UsageError(text.source + ": " + std::to_string(read) + " rows, and the listing says " + std::to_string(rows) +
                     "; save the whole text of the analysis");
  if (!reading.y_up) std::ranges::reverse(psf.samples);

  double sum = 0.0, x = 0.0, y = 0.0;
  for (std::size_t j = 0; j < psf.samples.size(); ++j)
    for (std::size_t i = 0; i < psf.samples[j].size(); ++i) {
      sum += psf.samples[j][i];
      x += psf.samples[j][i] * psf.step_um * (static_cast<double>(i) - static_cast<double>(half_x));
      y += psf.samples[j][i] * psf.step_um * (static_cast<double>(j) - static_cast<double>(half_y));
    }
  if (!(sum > 0.0)) throw UsageError(text.source + ": the samples sum to " + format_double(sum) + "; they are no PSF");
  x /= sum, y /= sum;
  notes.push_back(text.source + ": step " + significant(psf.step_um, 5) + " um; row " + std::to_string(row) +
                  ", column " + std::to_string(column) + " from the upper left is the chief ray and the origin; the " +
                  (reading.y_up ? "first row is the top of the image" : "last row is the top of the image") +
                  "; the centroid lies at (" + three_digits(x) + ", " + three_digits(y) + ") um, y down");
  if (const std::size_t at = text.find("Centroid offset"); at < text.lines.size() && reading.y_up) {
    const std::vector<double> stated = numbers_in(text.lines[at]);
    const double unit_um = text.find("Millimeters", at) == at ? 1e3 : 0.0;
    if (stated.size() == 2 && unit_um > 0.0 &&
        std::hypot(stated[0] * unit_um - x, -stated[1] * unit_um - y) > 0.5 * psf.step_um)
      psf.remarks.warnings.push_back(
          text.where(at) +
          "the stated centroid is not that of the samples, by more than half "
          "a step: light lies beyond the grid, or the centre is not where it is taken to be");
  }
  return psf;
}

}  // namespace mtf::io
