// SPDX-License-Identifier: Apache-2.0
#include "apps/page/html.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "apps/terminal/text_table.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/units.h"

namespace apps {
namespace {

/// RFC 8259, section 6.
bool is_json_number(std::string_view text) {
  const auto digits = [&] {
    std::size_t count = 0;
    for (; !text.empty() && text.front() >= '0' && text.front() <= '9'; text.remove_prefix(1)) ++count;
    return count;
  };
  if (text.starts_with('-')) text.remove_prefix(1);
  const bool zero = text.starts_with('0');
  const std::size_t whole = digits();
  if (whole == 0 || (zero && whole > 1)) return false;
  if (text.starts_with('.')) {
    text.remove_prefix(1);
    if (digits() == 0) return false;
  }
  if (text.starts_with('e') || text.starts_with('E')) {
    text.remove_prefix(1);
    if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
    if (digits() == 0) return false;
  }
  return text.empty();
}

/// The template with every {{name}} replaced, once: names within the replacements stay as they are.
std::string filled(std::string_view page, const std::map<std::string_view, std::string_view>& parts) {
  std::string text;
  for (;;) {
    const std::size_t open = page.find("{{"), close = page.find("}}");
    if (open == std::string_view::npos || close == std::string_view::npos) return text + std::string(page);
    text += page.substr(0, open);
    text += parts.at(page.substr(open + 2, close - open - 2));
    page.remove_prefix(close + 2);
  }
}

}  // namespace

std::optional<double> cell_value(const std::string& cell) {
  const std::optional<double> value = mtf::io::cell_number(cell);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string five_digits(double value) {
  const double size = std::abs(value);
  if (size < 1e-4 || size >= 1e9) return significant(value, 5);
  std::string text = fixed(value, std::clamp(4 - static_cast<int>(std::floor(std::log10(size))), 0, 8));
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
  }
  return text;
}

std::string html(std::string_view text) {
  constexpr std::string_view special = "&<>\"'";
  constexpr std::array entities{"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  std::string out;
  for (const char c : one_line(text)) {
    const std::size_t at = special.find(c);
    out += at == std::string_view::npos ? std::string(1, c) : entities[at];
  }
  return out;
}

std::string html_lines(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\n\t"), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    out += html(line);
    if (end < text.size()) out += text[end];
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

std::string html_value(std::string_view cell) {
  if (cell.empty()) return "<span class=\"none\">&ndash;</span>";
  const std::optional<double> value = cell_value(std::string(cell));
  if (!value) return html(cell);
  const std::string exact = html(cell);
  return "<data value=\"" + exact + "\" title=\"" + exact + "\">" + five_digits(*value) + "</data>";
}

std::string html_value(double value) {
  return std::isfinite(value) ? html_value(mtf::format_double(value)) : html_value(std::string_view());
}

std::string html_quantity(std::string_view cell, std::string_view unit) {
  const std::optional<double> value = cell_value(std::string(cell));
  if (!value || unit.empty()) return html_value(cell);
  const std::string exact = html(cell);
  const bool km = unit == "m" && std::abs(*value) >= 1e3;
  return "<data value=\"" + exact + "\" title=\"" + exact + " " + html(unit) + "\">" +
         five_digits(km ? 1e-3 * *value : *value) + "</data>&nbsp;" + (km ? "km" : html(unit));
}

std::string json_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : one_line(text)) {
    if (c == '"' || c == '\\') out += '\\';
    if (c == '<')
      out += "\\u003c";  // "</script" and "<!--" end or change a script element
    else
      out += c;
  }
  return out + "\"";
}

std::string json_cell(std::string_view cell) {
  if (cell.empty()) return "null";
  return is_json_number(cell) ? std::string(cell) : json_text(cell);
}

std::string json_number(double value) { return std::isfinite(value) ? mtf::format_double(value) : "null"; }

HtmlTable::HtmlTable(std::string_view caption, const std::vector<std::string>& header, std::vector<std::size_t> right)
    : right_(std::move(right)) {
  html_ = "<div class=\"table\" role=\"region\" tabindex=\"0\" aria-label=\"" + apps::html(caption) +
          "\"><table><caption>" + apps::html(caption) + "</caption><thead><tr>";
  for (std::size_t i = 0; i < header.size(); ++i)
    html_ += std::string("<th scope=\"col\"") + (is_right(i) ? " class=\"number\"" : "") + ">" + header[i] + "</th>";
  html_ += "</tr></thead><tbody>\n";
}

bool HtmlTable::is_right(std::size_t column) const { return std::ranges::find(right_, column) != right_.end(); }

void HtmlTable::add(const std::vector<std::string>& cells) {
  html_ += "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string style = is_right(i) ? " class=\"number\"" : "";
    html_ += i == 0 ? "<th scope=\"row\"" + style + ">" + cells[i] + "</th>" : "<td" + style + ">" + cells[i] + "</td>";
  }
  html_ += "</tr>\n";
}

std::string html_section(std::string_view id, std::string_view heading, std::string_view lead,
                         const std::string& body) {
  return "<section id=\"" + std::string(id) + "\"><h2>" + std::string(heading) + "</h2>\n" +
         (lead.empty() ? "" : "<p class=\"lead\">" + std::string(lead) + "</p>\n") + body + "</section>\n";
}

std::string html_chart(std::string_view id, const std::string& svg, std::string_view controls) {
  return "<figure class=\"chart\" id=\"" + std::string(id) + "\"><div class=\"controls\">" + std::string(controls) +
         "</div><div class=\"view\">" + svg + "</div></figure>\n";
}

std::string html_page(std::string_view title, std::string_view about, const std::vector<HtmlPart>& parts,
                      std::string_view scripts, std::string_view tail) {
  // Styles are in the page and in its charts; nothing is loaded from elsewhere.
  const std::string policy =
      "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; script-src " +
      std::string(scripts);
  std::string sections, links;
  for (const HtmlPart& part : parts) {
    if (part.body.empty()) continue;
    sections += part.body;
    if (part.words.empty()) continue;
    links += "<a href=\"#" + part.id + "\">" + part.words + "</a>\n";
  }
  const ReportFiles& files = report_files();
  return filled(files.page, {{"title", title},
                             {"policy", policy},
                             {"style", files.style},
                             {"about", about},
                             {"links", links},
                             {"sections", sections},
                             {"tail", tail}});
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      return k < bytes.size() ? std::uint32_t{static_cast<unsigned char>(bytes[k])} : 0U;
    };
    const std::uint32_t word = at(i) << 16 | at(i + 1) << 8 | at(i + 2);
    text += alphabet[word >> 18];
    text += alphabet[word >> 12 & 63];
    text += i + 1 < bytes.size() ? alphabet[word >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? alphabet[word & 63] : '=';
  }
  return text;
}

}  // namespace apps
