// SPDX-License-Identifier: Apache-2.0
#pragma once

// FNV-1a (Fowler, Noll, Vo) with words for bytes. It tells scenes apart and finds a word that changed, whichever it is,
// since a step is one to one in the hash; it is no protection against malice.

#include <cstdint>

namespace mtf {

inline constexpr std::uint64_t kWordHashStart = 1469598103934665603U;

/// The hash of what came before and one more word.
constexpr std::uint64_t mixed(std::uint64_t hash, std::uint64_t word) { return (hash ^ word) * 1099511628211U; }

}  // namespace mtf
