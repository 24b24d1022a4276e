// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace radiometry {

/// A place in the chain (chain.h) whose image is wanted.
enum class Tap { radiance, irradiance, electrons, dn, display };
inline constexpr std::array<std::string_view, 5> kTapNames{"radiance", "irradiance", "electrons", "dn", "display"};
constexpr std::span<const std::string_view> words(Tap) { return kTapNames; }
inline std::string tap_name(Tap tap) { return std::string(kTapNames[static_cast<std::size_t>(tap)]); }

}  // namespace radiometry
