// SPDX-License-Identifier: Apache-2.0

// New values and standard errors put into the text of a sensor file, which otherwise stays as its author wrote it:
// comments, order, units of other numbers. Values are found by their positions in the text.

#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/config_text.h"

namespace mtf::io {
namespace {

using cfg::Edit;
using cfg::end_of_value;
using cfg::offset_of;

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

std::string splice_numbers(std::string_view text, std::span<const FitSpec> fits,
                           std::span<const std::optional<double>> values,
                           const std::function<std::string(const FitSpec& fit, double number, bool is_error)>& toml) {
  std::vector<Edit> edits;
  for (std::size_t i = 0; i < fits.size() && i < values.size(); ++i) {
    const FitSpec& fit = fits[i];
    if (!values[i] || fit.value_at.line == 0) continue;
    const std::size_t begin = offset_of(text, fit.value_at), end = end_of_value(text, begin);
    const std::string error = fit.stderr_value ? toml(fit, *fit.stderr_value, true) : "";
    const bool has_error = fit.stderr_at.line > 0;
    edits.push_back({begin, end, toml(fit, *values[i], false)});
    if (!has_error && !error.empty()) edits.back().text += ", stderr = " + error;
    if (!has_error) continue;
    const std::size_t old = offset_of(text, fit.stderr_at);
    edits.push_back({error.empty() ? begin_of_stderr(text, old) : old, end_of_value(text, old), error});
  }
  return cfg::edited(text, std::move(edits));
}

std::string splice_fits(const SensorConfig& config, std::span<const std::optional<double>> values) {
  return splice_numbers(config.text, config.fits, values, [](const FitSpec& fit, double number, bool) {
    return cfg::toml_scalar({number, fit.unit.empty() ? nullptr : find_unit(fit.unit)});
  });
}

}  // namespace mtf::io
