// SPDX-License-Identifier: Apache-2.0
#include "mtf/resolution.h"

#include "mtf/resolution_impl.h"

namespace mtf {

Part part_of(std::string_view kind) {
  constexpr std::array<std::string_view, 7> kOptics{
      "diffraction", "defocus", "wavefront", "rms_wavefront", "random_wavefront", "birefringent_filter", "halo"};
  constexpr std::array<std::string_view, 9> kDetector{
      "footprint", "circular_footprint", "polygon_footprint", "binning", "diffusion", "crosstalk", "bolometer",
      "tdi",       "charge_transfer"};
  const auto among = [kind](const auto& kinds) { return std::find(kinds.begin(), kinds.end(), kind) != kinds.end(); };
  return among(kOptics) ? Part::optics : among(kDetector) ? Part::detector : Part::other;
}

template class ResolutionMeter<double>;

}  // namespace mtf
