// SPDX-License-Identifier: Apache-2.0
#pragma once

// From the values that an image file stores back to light. Measuring needs values proportional to light; many files
// hold an encoded version of them. With the full scale W of the file (255, 65535, 1 for floating point) and v = stored
// / W,
//   linear     L = stored
//   srgb       L = W v / 12.92                      for v <= 0.04045
//              L = W ((v + 0.055) / 1.055)^2.4      above      (IEC 61966-2-1, 5.2)
//   gamma:g    L = W sign(v) |v|^g
//   a file     L by straight lines through a measured table of stored and linear values (an inverse OECF, ISO 14524)
// so that 0 and the full scale stay what they are; only a table has units of its own.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/image.h"
#include "mtf/io/image_io.h"

namespace mtf::io {

struct Encoding {
  enum class Kind { linear, srgb, gamma, table };

  Kind kind = Kind::linear;
  double gamma = 1.0;                      ///< of Kind::gamma
  std::vector<double> stored{}, linear{};  ///< of Kind::table: stored rises; linear rises or falls, flat parts allowed
  std::string name = "linear";             ///< as reports call it
};

/// "linear", "srgb", "gamma" (2.2), "gamma:1.8" (0.1 to 10) or the path of a table, a relative one from `folder` (with
/// a final slash; "" is the current one). Throws UsageError that lists these for any other word, RuntimeError for a
/// file that cannot be read.
Encoding parse_encoding(const std::string& text, const std::string& folder = {});

/// The curve that is undone in a file's values, and where it is stated.
struct ChosenEncoding {
  Encoding encoding;
  /// "--encoding", "[scene]", what the file has ("sRGB chunk"), or "assumed": linear, as nothing states a curve.
  std::string source;
};

/// A table of two columns, stored and linear value, separated by comma, semicolon or tab; a first line without numbers
/// is a header, `#` starts a comment line. 2 to a million rows. Throws UsageError "file:line: ...".
Encoding parse_oecf(std::string_view text, const std::string& source);

/// Largest value that the file's samples can store; 1 for floating point.
double full_scale(const FileInfo& info);

/// Least value that they can: 0, but for whole numbers with a sign.
double least_stored(const FileInfo& info);

/// The linear value; NaN outside a table.
double decode(const Encoding& encoding, double stored, double full_scale);

/// All samples in place. Returns how many became NaN because they lie outside the table.
std::int64_t decode(const Encoding& encoding, ImageView<float> image, double full_scale);

/// What the rounding of JPEG does to pixels, the standard deviation of its error in counts, for the steps q(u, v) of
/// FileInfo::dct_steps (ITU-T T.81, A.3.3 and A.3.4); 0 for an empty list. A plane is coded in blocks of 8 x 8 pixels,
/// whose orthonormal cosine transforms are rounded to whole multiples of the steps. Rounding errors that are spread
/// evenly over a step have a variance of q^2 / 12, and as the transform is orthonormal, those of a pixel have
///   sd = sqrt(sum of q(u, v)^2 / 12 / 64)
/// That is an upper limit where a coefficient is smaller than half of its step: then it is set to zero, and the error
/// is the coefficient itself, which removes noise and fine structure alike. Errors are not independent: those of a
/// block belong together.
double dct_rounding_sd(const std::vector<std::uint16_t>& steps);

/// The step in linear values that one `step` of stored values makes at the value `level`: the size of rounding to
/// whole counts there. 0 where no stored value decodes to it.
double quantum_at(const Encoding& encoding, double level, double full_scale, double step = 1.0);

}  // namespace mtf::io
