// SPDX-License-Identifier: Apache-2.0
#pragma once

// Arrays of numpy.save (NPY, versions 1 to 3), and bare numbers without a header that says what they are (raw), in
// pieces of any size, in C order: numbers as in mtf/io/raw/number_type.h.

#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "mtf/io/float_rounding.h"

namespace mtf::io {

class NpyReader {
 public:
  /// Reads the header. Throws UsageError with the path where this is no such array or one that is cut off, RuntimeError
  /// where the file cannot be read.
  explicit NpyReader(const std::string& path);
  /// Planes of bare numbers from that byte on, as many as the file holds. Throws UsageError where that is no whole
  /// number of planes, with the sizes that would fit.
  NpyReader(const std::string& path, std::string type, std::uint64_t begin, std::uint64_t rows, std::uint64_t columns);

  const std::vector<std::uint64_t>& shape() const { return shape_; }
  const std::string& type() const { return type_; }  ///< as numpy has it: "<f4", "|u1", ">u2"
  bool is_float() const { return type_[1] == 'f'; }
  /// Values from the `first` one on, as many as `values` holds, rounded to float. `rounding` counts what that takes,
  /// for values whose contrast counts, as in frames of a camera; point spreads, displacements and temperatures in K
  /// keep seven digits of each. Throws RuntimeError.
  void read(std::uint64_t first, std::span<float> values, Rounding* rounding = nullptr);

 private:
  std::string path_, type_;
  std::vector<std::uint64_t> shape_;
  std::uint64_t begin_ = 0;  ///< of the values, in bytes
  std::size_t item_ = 0;     ///< bytes of a value
  std::ifstream file_;
};

}  // namespace mtf::io
