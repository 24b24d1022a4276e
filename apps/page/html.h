// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pieces of HTML. Everything that comes from a file goes through html() or html_lines().

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace apps {

/// Text on one line for content and quoted attributes: & < > " ' as entities, control characters and broken UTF-8
/// replaced.
std::string html(std::string_view text);

/// The same with its lines and tabs.
std::string html_lines(std::string_view text);

/// A cell of a table as a finite number, whatever the locale.
std::optional<double> cell_value(const std::string& cell);

/// Five digits, without an exponent where that is readable.
std::string five_digits(double value);

/// A number to five digits, with the cell as it was for programs and on hovering; other cells as they are, empty ones
/// as a dash.
std::string html_value(std::string_view cell);
std::string html_value(double value);
/// The same with its unit, lengths from a kilometre on in km.
std::string html_quantity(std::string_view cell, std::string_view unit);

/// `text` for a JSON string within a script element, with quotes; no sequence in it ends the element.
std::string json_text(std::string_view text);
/// A finite number of a cell as it stands, where JSON allows that spelling; null when empty; else a string.
std::string json_cell(std::string_view cell);
/// 17 digits where needed, null when not finite.
std::string json_number(double value);

class HtmlTable {
 public:
  /// `right`: columns of numbers, by index. The caption is for those who hear the page.
  HtmlTable(std::string_view caption, const std::vector<std::string>& header, std::vector<std::size_t> right = {});
  /// Cells are HTML already. The first is the row's header.
  void add(const std::vector<std::string>& cells);
  std::string html() const { return html_ + "</tbody></table></div>\n"; }

 private:
  bool is_right(std::size_t column) const;
  std::vector<std::size_t> right_;
  std::string html_;
};

/// "<section id=... >" with its heading, up to "</section>"; `lead` is a sentence below the heading.
std::string html_section(std::string_view id, std::string_view heading, std::string_view lead, const std::string& body);

/// A place for a chart: the static one, which the script replaces by one to interact with.
std::string html_chart(std::string_view id, const std::string& svg, std::string_view controls = {});

struct HtmlPart {
  std::string id, words;  ///< of the link to it; "" for none
  std::string body;       ///< html_section(); left out where it is empty
};

/// The whole page, which needs nothing else: its policy allows the scripts of these hashes in `tail` ("'none'") and
/// nothing from elsewhere. Title and about are HTML.
std::string html_page(std::string_view title, std::string_view about, const std::vector<HtmlPart>& parts,
                      std::string_view scripts = "'none'", std::string_view tail = {});

/// Base 64 with padding (RFC 4648, section 4).
std::string base64(std::string_view bytes);

/// The text files of apps/report and of its npm packages, built into the command.
struct ReportFiles {
  std::string_view page;     ///< HTML with {{names}} of what is put in
  std::string_view style;    ///< CSS
  std::string_view script;   ///< ours
  std::string_view library;  ///< Vega, Vega-Lite and Vega-Embed; empty in a build without node, npm or network
  std::string_view notices;  ///< their licences
};

const ReportFiles& report_files();

}  // namespace apps
