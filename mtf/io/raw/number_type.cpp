// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/raw/number_type.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

namespace mtf::io {
namespace {

static_assert(std::endian::native == std::endian::little);

template <class Number>
Number number_at(const char* from, bool turned) {
  std::array<char, sizeof(Number)> bytes;
  std::memcpy(bytes.data(), from, bytes.size());
  if (turned) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Number>(bytes);
}

template <class Number>
void convert_numbers(bool turned, const char* from, std::int64_t step, const Meaning& meaning, std::span<float> values,
                     Rounding* rounding) {
  // Whole numbers of 64 bits have more digits than double.
  using Exact = std::conditional_t<std::is_integral_v<Number> && sizeof(Number) == 8, long double, double>;
  const auto count = static_cast<std::int64_t>(values.size());
  const bool plain = meaning.gain == 1.0 && meaning.offset == 0.0;
  if (plain && (std::is_same_v<Number, float> || sizeof(Number) < 4)) rounding = nullptr;  // exact
  if (plain && !rounding && !meaning.no_data && !turned && step == sizeof(Number)) {  // most files: as fast as memory
    for (std::int64_t i = 0; i < count; ++i)
      values.data()[i] = static_cast<float>(number_at<Number>(from + i * std::int64_t{sizeof(Number)}, false));
    return;
  }
  // What is written in decimals stands for the nearest number of the type.
  const double stated = meaning.no_data.value_or(0.0);
  const double missing = std::is_floating_point_v<Number> ? static_cast<double>(static_cast<Number>(stated)) : stated;
  for (std::int64_t i = 0; i < count; ++i) {
    const auto number = number_at<Number>(from + i * step, turned);
    float& value = values.data()[i];
    if (meaning.no_data && static_cast<double>(number) == missing) {
      value = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    const auto itself = static_cast<Exact>(number);  // -0 among them
    const Exact exact = plain ? itself : itself * static_cast<Exact>(meaning.gain) + static_cast<Exact>(meaning.offset);
    value = static_cast<float>(exact);
    if (rounding != nullptr) rounding->add(static_cast<double>(exact), value);
  }
}

}  // namespace

std::string NumberType::name() const {
  if (kind == 'f') return bytes == 4 ? "float" : "double";
  return std::string(kind == 'u' ? "uint" : "int") + std::to_string(8 * bytes);
}

std::optional<NumberType> number_type(std::string_view word) {
  constexpr std::string_view known = " f4 f8 u1 i1 u2 i2 u4 i4 u8 i8 ";
  if (word.size() != 3 || known.find(" " + std::string(word.substr(1)) + " ") == std::string_view::npos)
    return std::nullopt;
  return NumberType{word[1], word[2] - '0', word[0] == '>'};
}

void to_floats(NumberType type, const char* from, std::int64_t step, const Meaning& meaning, std::span<float> values,
               Rounding* rounding) {
  const auto as = [&]<class Number>(Number) {
    convert_numbers<Number>(type.big_endian, from, step, meaning, values, rounding);
  };
  const bool sign = type.kind == 'i';
  if (type.is_float()) return type.bytes == 4 ? as(float{}) : as(double{});
  if (type.bytes == 1) return sign ? as(std::int8_t{}) : as(std::uint8_t{});
  if (type.bytes == 2) return sign ? as(std::int16_t{}) : as(std::uint16_t{});
  if (type.bytes == 4) return sign ? as(std::int32_t{}) : as(std::uint32_t{});
  return sign ? as(std::int64_t{}) : as(std::uint64_t{});
}

}  // namespace mtf::io
