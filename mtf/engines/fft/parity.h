// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of an OTF by parity along x and y, H = ee + oo + i (eo + oe): with H(-f) = conj H(f) what is odd along one
// axis alone is imaginary. A mirrored scene, a sum of cosines, takes one inverse transform for each part.

#include <array>
#include <cstddef>
#include <utility>

namespace mtf {

/// Symmetry of a part of an OTF along one axis.
enum class Parity { even, odd };

struct OtfPart {
  bool operator==(const OtfPart&) const = default;
  Parity x = Parity::even, y = Parity::even;
  bool is_real() const { return x == y; }
};

/// The order in which parts are stored.
inline constexpr std::array kOtfParts{OtfPart{Parity::even, Parity::even}, OtfPart{Parity::even, Parity::odd},
                                      OtfPart{Parity::odd, Parity::even}, OtfPart{Parity::odd, Parity::odd}};

/// The parts that an OTF may have.
class Parities {
 public:
  explicit Parities(OtfPart only = {}) {
    for (std::size_t i = 0; i < has_.size(); ++i) has_[i] = kOtfParts[i] == only;
  }
  Parities(bool real, bool even_x, bool even_y) {
    for (std::size_t i = 0; i < has_.size(); ++i) {
      const auto [x, y] = kOtfParts[i];
      has_[i] = !(real && x != y) && !(even_x && x == Parity::odd) && !(even_y && y == Parity::odd);
    }
  }
  bool has(OtfPart part) const { return has_[index(part)]; }
  bool is_real() const { return !has_[1] && !has_[2]; }
  bool is_even_x() const { return !has_[2] && !has_[3]; }
  bool is_even_y() const { return !has_[1] && !has_[3]; }
  bool is_one() const { return has_[0] + has_[1] + has_[2] + has_[3] == 1; }
  /// Of the OTF with x and y exchanged.
  Parities swapped() const {
    Parities other = *this;
    std::swap(other.has_[1], other.has_[2]);
    return other;
  }
  /// Of a product.
  Parities operator*(const Parities& other) const {
    Parities product;
    product.has_ = {};
    for (std::size_t i = 0; i < has_.size(); ++i)
      for (std::size_t j = 0; j < has_.size(); ++j)
        product.has_[i ^ j] = product.has_[i ^ j] || (has_[i] && other.has_[j]);
    return product;
  }
  /// Of a sum.
  Parities operator+(const Parities& other) const {
    Parities sum = *this;
    for (std::size_t i = 0; i < has_.size(); ++i) sum.has_[i] = sum.has_[i] || other.has_[i];
    return sum;
  }

 private:
  static std::size_t index(OtfPart part) {
    return (part.x == Parity::odd ? 2U : 0U) + (part.y == Parity::odd ? 1U : 0U);
  }
  std::array<bool, kOtfParts.size()> has_{};
};

}  // namespace mtf
