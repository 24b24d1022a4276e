// SPDX-License-Identifier: Apache-2.0
#pragma once

// Text that lens programs export. The same listing comes in UTF-8, Latin-1 or UTF-16 of either byte order, with or
// without a byte order mark, with LF or CRLF, and with a decimal comma where the machine that wrote it has one. The
// readers of listings see lines of UTF-8, words and numbers.

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mtf::io {

struct DesignText {
  std::string source;              ///< what messages call it
  std::string encoding;            ///< "UTF-8", "UTF-16" or "Latin-1"
  std::vector<std::string> lines;  ///< without their ends
  bool decimal_comma = false;      ///< a number is written 0,5
  std::size_t first_line = 1;      ///< number of lines[0] in the file

  std::optional<std::string> order{};  ///< of Zernike terms, "noll" or "fringe", where a title says it
  /// "lens.txt:12: "
  std::string where(std::size_t line) const {
    return source + ":" + std::to_string(std::max<std::size_t>(line + first_line, 1)) + ": ";
  }
  /// The first line from `from` on that has the words, in any case; lines.size() for none.
  std::size_t find(std::string_view words, std::size_t from = 0) const;
  bool has(std::string_view words) const { return find(words) < lines.size(); }
};

/// A file of at most 64 MiB. Throws RuntimeError where it cannot be read, UsageError where it is no text: binary,
/// encrypted, or a picture.
DesignText read_design_text(const std::string& path);
DesignText design_text(std::string_view bytes, const std::string& source);

/// Words of a line, which end at blanks, brackets and : = | ;, without points and commas at their ends.
std::vector<std::string> design_words(std::string_view line);

/// "0.5", "0,5", ".974", "1.2345E-004".
std::optional<double> design_number(std::string_view word);

/// The first length of a line, "Data spacing is 0.288 µm.", in um.
std::optional<double> design_length_um(std::string_view line);

/// All numbers of a row; empty for a line that starts with a word. Throws UsageError with `where` for a row whose first
/// cell is a number and one of whose other cells is not a finite number.
std::vector<double> design_row(std::string_view line, const std::string& where);

/// The numbers of a line that has nothing else, else none.
std::vector<double> only_numbers(std::string line, bool decimal_comma);

/// A place in the field of view, "(0.0000, 7.0000) deg"; a number alone lies along y.
struct DesignField {
  double x = 0.0, y = 0.0;
  std::string unit{};

  std::string text() const;
};
std::optional<DesignField> design_field(std::string_view line);

/// How listings are read where they do not say it themselves, or say it wrongly.
struct DesignReading {
  std::optional<std::string> order{};  ///< of Zernike terms: "noll" or "fringe"
  bool y_up = true;                    ///< +y of the listing points up in the image, as lens programs have it
  double sign = 1.0;                   ///< of the wavefront
};

/// What a reader understood, to be shown: how it read the listing, and what may be wrong.
struct DesignRemarks {
  std::vector<std::string> notes{}, warnings{};
};

}  // namespace mtf::io
