// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/uniform_runs.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "mtf/engines/kernels.h"
#include "mtf/math/clones.h"
#include "mtf/math/simd.h"

namespace mtf {
namespace {

constexpr std::int64_t kPlaces = 8;  // along each side
constexpr std::size_t kMostValues = 16;
constexpr std::int64_t kGroup = UniformRuns::kGroup, kTogether = 8;

static_assert(kGroup == simd::kBits);
using simd::any_bit, simd::Bits, simd::bits, simd::bits_of;

// Samples are told apart by their bits: 0 and -0 differ.
bool same_bits(float a, float b) { return std::bit_cast<std::int32_t>(a) == std::bit_cast<std::int32_t>(b); }

// kTogether whole groups at once where all have the value found last, else one by one.
MTFKIT_CLONES void classify_groups(const float* p, std::int64_t groups, const float* values, std::size_t count,
                                   UniformRuns::Kind* kinds) {
  std::size_t k = 0;
  for (std::int64_t g = 0; g < groups;) {
    const Bits same = bits_of(values[k]);
    if (g + kTogether <= groups && same_bits(p[g * kGroup], values[k])) {
      Bits any{};
      for (std::int64_t i = g; i < g + kTogether; ++i) any |= bits(p + i * kGroup) ^ same;
      if (!any_bit(any)) {
        std::memset(kinds + g, static_cast<int>(k + 1), kTogether);
        g += kTogether;
        continue;
      }
    }
    const std::int64_t end = std::min(groups, g + kTogether);
    for (; g < end; ++g) {
      const float* group = p + g * kGroup;
      std::size_t found = 0;
      while (found < count && !same_bits(group[0], values[found])) ++found;
      kinds[g] = 0;
      if (found == count || any_bit(bits(group) ^ bits_of(values[found]))) continue;
      k = found;
      kinds[g] = static_cast<UniformRuns::Kind>(k + 1);
    }
  }
}

}  // namespace

UniformRuns::UniformRuns(ImageView<const float> plane) : plane_(plane), groups_((plane.width + kGroup - 1) / kGroup) {
  if (plane.width < kGroup) return;
  for (std::int64_t j = 0; j < kPlaces; ++j)
    for (std::int64_t i = 0; i < kPlaces && values_.size() < kMostValues; ++i) {
      const float* p = plane.row((2 * j + 1) * plane.height / (2 * kPlaces));
      p += (2 * i + 1) * (plane.width - kGroup) / (2 * kPlaces);
      if (kernels::all_alike(p, kGroup) && kind_of(*p) == 0) values_.push_back(*p);
    }
  if (any()) kinds_.resize(static_cast<std::size_t>(groups_ * plane.height));
}

UniformRuns::Kind UniformRuns::kind_of(float value) const {
  const auto at = std::find_if(values_.begin(), values_.end(), [&](float v) { return same_bits(v, value); });
  return at == values_.end() ? Kind{0} : static_cast<Kind>(at - values_.begin() + 1);
}

const UniformRuns::Kind* UniformRuns::classify_row(std::int64_t y) {
  const float* samples = plane_.row(y);
  Kind* kinds = kinds_.data() + y * groups_;
  const std::int64_t whole = plane_.width / kGroup;
  classify_groups(samples, whole, values_.data(), values_.size(), kinds);
  if (whole == groups_) return kinds;
  const float* rest = samples + whole * kGroup;
  kinds[whole] = kernels::all_alike(rest, plane_.width - whole * kGroup) ? kind_of(*rest) : Kind{0};
  return kinds;
}

}  // namespace mtf
