// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/noise_lanes.h"

#include <cmath>

#include "mtf/math/clones.h"
#include "radiometry/stages/noise/lane_words.h"

namespace radiometry {

MTFKIT_CLONES void gaussian_lanes(const RandomRow& row, std::uint32_t half_column, float* out) {
  Words words;
  philox_lanes(row, half_column, words);
  alignas(64) float first[kPairs], second[kPairs];
  for (int i = 0; i < kPairs; ++i) {
    const std::int32_t a = upper31(words.w[0][i]), b = upper31(words.w[1][i]);
    const float energy = minus_log(unit_interval<float>(a, b), unit_interval<float>(mirrored(a), mirrored(b)));
    const float radius = std::sqrt(2.0F * energy);
    // The angle: a quarter of the circle from the upper bits, the rest within +-1/8 of it.
    const std::uint32_t quarter = (words.w[2][i] + 0x20000000U) >> 30;
    const auto rest = static_cast<std::int32_t>(words.w[2][i] - (quarter << 30));
    const float x = (static_cast<float>(rest) + 0.5F) * 0x1p-30F, y = x * x;
    const float sine =
        x *
        (1.570796327F + y * (-0.6459640961F + y * (0.07969258273F + y * (-0.004681266257F + y * 0.0001582063036F))));
    const float cosine = 1.0F + y * (-1.233700541F + y * (0.2536692037F + y * (-0.0208600695F + y * 0.0009036280664F)));
    const bool odd = (quarter & 1U) != 0;
    const float c = odd ? sine : cosine, s = odd ? cosine : sine;
    first[i] = ((quarter + 1U) & 2U) != 0 ? -radius * c : radius * c;
    second[i] = (quarter & 2U) != 0 ? -radius * s : radius * s;
  }
  for (int i = 0; i < kPairs; ++i) {
    out[2 * i] = first[i];
    out[2 * i + 1] = second[i];
  }
}

}  // namespace radiometry
