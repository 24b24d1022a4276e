// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/encoding.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::size_t kMaxOecfBytes = std::size_t{64} << 20;
constexpr double kMinGamma = 0.1, kMaxGamma = 10.0;
constexpr std::string_view kKnown =
    "linear, srgb, gamma (2.2), gamma:1.8 or the path of a table (columns: stored value, linear value)";

double srgb_to_linear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double linear_to_srgb(double l) { return l <= 0.04045 / 12.92 ? 12.92 * l : 1.055 * std::pow(l, 1.0 / 2.4) - 0.055; }

double power(double v, double exponent) { return std::copysign(std::pow(std::abs(v), exponent), v); }

/// y at `at` by straight lines through points of rising x; NaN outside.
double between(const std::vector<double>& x, const std::vector<double>& y, double at) {
  if (!(at >= x.front() && at <= x.back())) return std::numeric_limits<double>::quiet_NaN();
  const auto next = std::ranges::upper_bound(x, at);
  if (next == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(next - x.begin());
  return std::lerp(y[i - 1], y[i], (at - x[i - 1]) / (x[i] - x[i - 1]));
}

/// A stored value that decodes to `linear`: the end of a constant part where there is one, the nearest end outside.
double encode(const Encoding& encoding, double linear, double full_scale) {
  if (encoding.kind == Encoding::Kind::linear) return linear;
  if (encoding.kind == Encoding::Kind::srgb) return full_scale * linear_to_srgb(linear / full_scale);
  if (encoding.kind == Encoding::Kind::gamma) return full_scale * power(linear / full_scale, 1.0 / encoding.gamma);
  const std::vector<double>&x = encoding.stored, &y = encoding.linear;
  const bool rises = y.back() > y.front();
  const auto next = std::ranges::partition_point(y, [&](double v) { return rises ? v <= linear : v >= linear; });
  if (next == y.begin()) return x.front();
  if (next == y.end()) return x.back();
  const auto i = static_cast<std::size_t>(next - y.begin());
  return std::lerp(x[i - 1], x[i], (linear - y[i - 1]) / (y[i] - y[i - 1]));
}

}  // namespace

Encoding parse_oecf(std::string_view text, const std::string& source) {
  text = without_mark(text);
  Encoding encoding{.kind = Encoding::Kind::table, .gamma = 1.0, .name = source};
  bool header_allowed = true;
  int direction = 0;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = take_text_line(text);
    if (is_comment(row)) continue;
    const auto fail = [&](const std::string& why) {
      return UsageError(source + ":" + std::to_string(line) + ": " + why);
    };
    const auto cells = split_cells(row, separator_of(row));
    const bool header = header_allowed && !cell_number(cells.front());
    header_allowed = false;
    if (cells.size() != 2)
      throw fail(std::to_string(cells.size()) +
                 " columns where two belong: stored value, linear value; numbers have a decimal point, not a comma");
    if (header) continue;
    const auto number = [&](std::string_view cell) {
      const auto value = cell_number(cell);
      if (!value || !std::isfinite(*value))
        throw fail("\"" + printable(cell, 40) + "\" is no finite number; write it like 128 or 0.216");
      return *value;
    };
    const double stored = number(cells[0]), linear = number(cells[1]);
    if (!encoding.stored.empty()) {
      if (stored <= encoding.stored.back()) throw fail("stored values have to increase from line to line; sort them");
      const double step = linear - encoding.linear.back();
      const int sign = (step > 0.0) - (step < 0.0);
      if (sign * direction < 0)
        throw fail("linear values turn back here; they have to rise or to fall throughout, smooth the measured table");
      if (sign != 0) direction = sign;
    }
    if (encoding.stored.size() == kMaxTableRows) throw fail("more than a million rows; thin the table out");
    encoding.stored.push_back(stored);
    encoding.linear.push_back(linear);
  }
  if (encoding.stored.size() < 2)
    throw UsageError(source + ": a table needs two rows or more of stored value, linear value, such as 0,0 and 255,1");
  if (direction == 0)
    throw UsageError(source + ": all linear values are the same, so that the curve cannot be inverted");
  return encoding;
}

Encoding parse_encoding(const std::string& text, const std::string& folder) {
  if (text == "linear") return {};
  if (text == "srgb") return {.kind = Encoding::Kind::srgb, .gamma = 1.0, .name = text};
  if (text.starts_with("gamma")) {
    const auto value = text == "gamma"              ? std::optional(2.2)
                       : text.starts_with("gamma:") ? cell_number(text.substr(6))
                                                    : std::nullopt;
    if (!value || !(*value >= kMinGamma && *value <= kMaxGamma))
      throw UsageError("encoding \"" + printable(text, 60) +
                       "\": gamma takes a number from 0.1 to 10, as in gamma:2.2");
    return {.kind = Encoding::Kind::gamma, .gamma = *value, .name = text};
  }
  // A misspelt word is no path that anybody would write: those have a folder or an ending.
  if (text.find_first_of("./\\") == std::string::npos)
    throw UsageError("unknown encoding \"" + printable(text, 60) + "\"; it is " + std::string(kKnown));
  const std::string path = text.starts_with('/') ? text : folder + text;
  static_cast<void>(input_file_size(path));
  return parse_oecf(read_text_file(path, kMaxOecfBytes), path);
}

double full_scale(const FileInfo& info) {
  const std::string type = info.channels.empty() ? "" : info.channels.front().type;
  if (info.largest > 0.0) return info.largest;
  for (const int bits : {16, 32, 64}) {
    if (type == "uint" + std::to_string(bits)) return std::ldexp(1.0, bits) - 1.0;
    if (type == "int" + std::to_string(bits)) return std::ldexp(1.0, bits - 1) - 1.0;
  }
  if (type == "uint") return 4294967295.0;
  if (type == "int8") return 127.0;
  if (type != "uint8") return 1.0;
  for (const int bits : {1, 2, 4})
    if (info.storage.starts_with(std::to_string(bits) + "-bit") && info.storage.find("palette") == std::string::npos)
      return (1 << bits) - 1;
  return 255.0;
}

double least_stored(const FileInfo& info) {
  const bool is_signed = !info.channels.empty() && info.channels.front().type.starts_with("int");
  return is_signed ? -full_scale(info) - 1.0 : 0.0;
}

double decode(const Encoding& encoding, double stored, double full_scale) {
  if (encoding.kind == Encoding::Kind::linear) return stored;
  if (encoding.kind == Encoding::Kind::srgb) return full_scale * srgb_to_linear(stored / full_scale);
  if (encoding.kind == Encoding::Kind::gamma) return full_scale * power(stored / full_scale, encoding.gamma);
  return between(encoding.stored, encoding.linear, stored);
}

std::int64_t decode(const Encoding& encoding, ImageView<float> image, double full_scale) {
  if (encoding.kind == Encoding::Kind::linear) return 0;
  std::int64_t outside = 0;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      float& sample = image.at(x, y);
      const bool known = !std::isnan(sample);
      sample = static_cast<float>(decode(encoding, sample, full_scale));
      if (known && std::isnan(sample)) ++outside;
    }
  return outside;
}

double dct_rounding_sd(const std::vector<std::uint16_t>& steps) {
  if (steps.empty()) return 0.0;
  double sum = 0.0;
  for (const std::uint16_t step : steps) sum += static_cast<double>(step) * static_cast<double>(step);
  return std::sqrt(sum / (12.0 * static_cast<double>(steps.size())));
}

double quantum_at(const Encoding& encoding, double linear, double full_scale, double step) {
  if (encoding.kind == Encoding::Kind::linear) return step;
  double low = encode(encoding, linear, full_scale) - 0.5 * step, high = low + step;
  if (encoding.kind == Encoding::Kind::table) {
    low = std::max(low, encoding.stored.front());
    high = std::min(high, encoding.stored.back());
    if (!(high > low)) return 0.0;
  }
  return std::abs(decode(encoding, high, full_scale) - decode(encoding, low, full_scale)) * step / (high - low);
}

}  // namespace mtf::io
