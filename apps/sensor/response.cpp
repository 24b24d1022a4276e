// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/response.h"

#include "mtf/io/sha256.h"
#include "mtf/words.h"

namespace apps {

std::string response_sha256(const radiometry::SpectralCamera& curves) {
  std::string text = curves.flux == radiometry::Flux::watts ? "watts" : "photons";
  const auto add = [&](double number) { text += " " + mtf::significant(number, 17); };
  add(curves.band.lo_um);
  add(curves.band.hi_um);
  for (const auto* list : {&curves.optics, &curves.cold_filter, &curves.quantum_efficiency}) {
    text += "\ncurves";
    for (const radiometry::Spectrum& curve : *list) {
      text += "\ncurve";
      for (std::size_t i = 0; i < curve.value.size(); ++i) {
        add(curve.wavelength_um[i]);
        add(curve.value[i]);
      }
    }
  }
  return mtf::io::sha256_hex(text);
}

}  // namespace apps
