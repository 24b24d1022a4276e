// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace radiometry {

/// A stage of the chain (chain.h) whose output may be wanted.
enum class OutputStage { radiance, irradiance, electrons, dn, display };
inline constexpr std::array<std::string_view, 5> kOutputStageNames{"radiance", "irradiance", "electrons", "dn",
                                                                   "display"};
constexpr std::span<const std::string_view> words(OutputStage) { return kOutputStageNames; }
inline std::string output_stage_name(OutputStage stage) {
  return std::string(kOutputStageNames[static_cast<std::size_t>(stage)]);
}

}  // namespace radiometry
