// SPDX-License-Identifier: Apache-2.0
#pragma once

// SHA-256 (FIPS 180-4) of short texts: identifies the sensor file that an image was made with. Not for secrets.

#include <string>
#include <string_view>

namespace mtf::io {

/// 64 lower-case hex digits.
std::string sha256_hex(std::string_view bytes);

/// The same of a file, read in pieces. Throws RuntimeError when it cannot be read.
std::string sha256_file(const std::string& path);

}  // namespace mtf::io
