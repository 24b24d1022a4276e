// SPDX-License-Identifier: Apache-2.0
#pragma once

// The modes of a part of the image. With the modes of the whole image, whose weights are a_m and OTFs P_m
// (field_modes.h), what a tile sees of the deviation from the mean is a sum of far fewer,
//   sum over m of a_m(x) P_m(f) ~ sum over k of w_k(x) Q_k(f),    Q_k = sum over m of mix_km P_m
// because the a_m change little over a tile: the w_k are the singular vectors of (scale_m a_m(x)) over the tile, as
// polynomials of its own. Of what is left, b_m = a_m - sum over k of w_k mix_km, the bound is that of the whole image
// (FieldModes::Measure): the same for every scene of that power, wherever in the image its contrast lies.

#include <optional>
#include <vector>

#include "mtf/field/field_modes.h"
#include "mtf/image.h"

namespace mtf {

struct TileModes {
  static constexpr std::size_t kTerms = 7;  ///< of a weight along an axis

  Region region;               ///< pixels
  std::size_t count = 0;       ///< modes
  std::vector<double> mix;     ///< [mode][mode of the image]; weights are within -1 .. 1
  std::vector<float> rows;     ///< [mode][row][term]: each weight along x, in Chebyshev polynomials over the tile
  std::vector<double> amount;  ///< of each mode of the image, its largest weight in the tile
  double error = 0.0;          ///< bound of the rms error of what is left out
};

/// The polynomials that `rows` means, at the pixels of a tile's row: [term][pixel].
std::vector<float> tile_terms(std::int64_t width);

/// The fewest modes that leave at most `allowed`; nothing where `most` are too few.
std::optional<TileModes> tile_modes(const FieldModes& field, const FieldModes::Measure& measure, const Region& region,
                                    double allowed, std::size_t most);

}  // namespace mtf
