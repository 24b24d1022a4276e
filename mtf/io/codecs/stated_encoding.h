// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an image file says of the curve between light and its stored values, in the words of mtf/io/codecs/encoding.h.
// Sources: PNG specification, third edition, 11.3.2 (cICP before iCCP before sRGB before gAMA); TIFF 6.0,
// TransferFunction; ICC.1:2022, 7 and 10 for the name of a profile.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace mtf::io {

struct StatedEncoding {
  /// "srgb", "gamma:2.2", "linear"; "" when the file states none, or one that is not known here.
  std::string word;
  std::string source;  ///< "sRGB chunk", "gAMA chunk (0.45455)"; "" when the file states none

  bool operator==(const StatedEncoding&) const = default;
};

/// The chunks of a PNG that say it.
struct PngColour {
  std::optional<int> transfer;            ///< cICP: transfer function of ITU-T H.273
  std::optional<std::string> profile;     ///< iCCP: name of the profile
  bool srgb = false;                      ///< sRGB
  std::optional<std::uint32_t> gamma_e5;  ///< gAMA: stored = light^(value / 100000)
};
StatedEncoding stated_by_png(const PngColour& colour);

/// `tables`: TransferFunction, linear values 0..65535 of every stored value, one table or one a colour; none when
/// empty. `profile`: bytes of the ICC profile; none when empty.
StatedEncoding stated_by_tiff(std::span<const std::span<const std::uint16_t>> tables,
                              std::span<const unsigned char> profile);

/// Name in the description of an ICC profile; "" when it cannot be found.
std::string icc_name(std::span<const unsigned char> profile);

}  // namespace mtf::io
