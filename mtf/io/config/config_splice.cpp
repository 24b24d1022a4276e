// SPDX-License-Identifier: Apache-2.0

// New values and standard errors put into the text of a sensor file, which otherwise stays as its author wrote it:
// comments, order, units of other numbers. Values are found by their positions in the text.

#include <algorithm>

#include "mtf/io/config/config_reader.h"

namespace mtf::io {
namespace {

struct Edit {
  std::size_t begin = 0, end = 0;
  std::string text;
};

/// Byte of a position; columns count characters, not bytes.
std::size_t offset_of(std::string_view text, Position position) {
  std::size_t at = 0;
  for (int line = 1; line < position.line; ++line) {
    at = text.find('\n', at);
    if (at == std::string_view::npos) return text.size();
    ++at;
  }
  const auto inside = [&](std::size_t i) { return i < text.size() && (static_cast<unsigned char>(text[i]) >> 6) == 2; };
  for (int column = 1; column < position.column && at < text.size(); ++column) do
      ++at;
    while (inside(at));
  return at;
}

/// Where the string or number at `begin` ends.
std::size_t end_of_value(std::string_view text, std::size_t begin) {
  if (begin >= text.size()) return begin;
  const char quote = text[begin];
  if (quote != '"' && quote != '\'') return std::min(text.find_first_of(" \t\r\n,}]#", begin), text.size());
  std::size_t at = begin + 1;
  while (at < text.size() && text[at] != quote) at += quote == '"' && text[at] == '\\' ? 2 : 1;
  return std::min(at + 1, text.size());
}

/// Begin of `, stderr = ` before its value; the value itself where something else comes before it.
std::size_t begin_of_stderr(std::string_view text, std::size_t value) {
  std::string_view before = text.substr(0, value);
  const auto take = [&](std::string_view word) {
    while (!before.empty() && (before.back() == ' ' || before.back() == '\t')) before.remove_suffix(1);
    if (!before.ends_with(word)) return false;
    before.remove_suffix(word.size());
    return true;
  };
  return take("=") && take("stderr") && take(",") ? before.size() : value;
}

}  // namespace

std::string splice_fits(const SensorConfig& config, std::span<const std::optional<double>> values) {
  std::vector<Edit> edits;
  for (std::size_t i = 0; i < config.fits.size() && i < values.size(); ++i) {
    const FitSpec& fit = config.fits[i];
    if (!values[i] || fit.value_at.line == 0) continue;
    const Unit* unit = fit.unit.empty() ? nullptr : find_unit(fit.unit);
    const std::size_t begin = offset_of(config.text, fit.value_at), end = end_of_value(config.text, begin);
    const std::string error = fit.stderr_value ? cfg::toml_scalar({*fit.stderr_value, unit}) : "";
    const bool has_error = fit.stderr_at.line > 0;
    edits.push_back({begin, end, cfg::toml_scalar({*values[i], unit})});
    if (!has_error && !error.empty()) edits.back().text += ", stderr = " + error;
    if (!has_error) continue;
    const std::size_t old = offset_of(config.text, fit.stderr_at);
    edits.push_back({error.empty() ? begin_of_stderr(config.text, old) : old, end_of_value(config.text, old), error});
  }
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
  std::string text;
  std::size_t at = 0;
  for (const Edit& edit : edits) {
    if (edit.begin < at) continue;
    text.append(config.text, at, edit.begin - at);
    text += edit.text;
    at = edit.end;
  }
  return text.append(config.text, at);
}

}  // namespace mtf::io
