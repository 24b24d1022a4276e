// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace radiometry {

/// A stage of the chain (chain.h) whose output may be wanted.
enum class OutputStage {
  radiance,
  irradiance,
  watts,      ///< of a thermal detector: what a pixel absorbs, less what it would of the shutter, without lag and noise
  electrons,  ///< of a photon detector
  volts,      ///< of a thermal one, at the same place of the chain
  dn,
  display
};
inline constexpr std::array<std::string_view, 7> kOutputStageNames{"radiance", "irradiance", "watts",  "electrons",
                                                                   "volts",    "dn",         "display"};
constexpr std::span<const std::string_view> words(OutputStage) { return kOutputStageNames; }
/// True where a sensor with a thermal detector, or one with a photon detector, may have that stage.
constexpr bool may_have_stage(OutputStage stage, bool thermal) {
  if (stage == OutputStage::watts || stage == OutputStage::volts) return thermal;
  return stage != OutputStage::electrons || !thermal;
}
inline std::string output_stage_name(OutputStage stage) {
  return std::string(kOutputStageNames[static_cast<std::size_t>(stage)]);
}

}  // namespace radiometry
