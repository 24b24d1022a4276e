// SPDX-License-Identifier: Apache-2.0
#include "apps/atmosphere/spectrum_text.h"

#include <array>
#include <cstdio>

#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/units.h"

namespace apps {

namespace air = radiometry::atmosphere;

std::string spectrum_csv(const air::SpectralPath<double>& path) {
  std::string text = "wavenumber_cm-1,wavelength_um,transmittance,path_radiance_W_m-2_sr-1_per_cm-1";
  const bool components = !path.component.front().empty();
  if (components)
    for (const std::string_view name : air::kComponentNames) text += "," + std::string(name);
  text += "\n";
  for (std::size_t i = 0; i < path.wavenumber_cm.size(); ++i) {
    text += mtf::format_double(path.wavenumber_cm[i]) + "," + mtf::format_double(1e4 / path.wavenumber_cm[i]) + "," +
            mtf::format_double(path.transmission[i]) + "," +
            (i < path.radiance.size() ? mtf::format_double(path.radiance[i]) : "");
    if (components)
      for (const auto& curve : path.component) text += "," + mtf::format_double(curve[i]);
    text += "\n";
  }
  return text;
}

std::string path_table_csv(const radiometry::PathTable& table, const std::string& what) {
  std::string text = "# " + one_line(what) + "\nrange_m,wavelength_um,transmission,radiance_w_m2_sr_um\n";
  for (std::size_t r = 0; r < table.range_m().size(); ++r)
    for (std::size_t i = 0; i < table.wavelength_um().size(); ++i)
      text += mtf::format_double(table.range_m()[r]) + "," + mtf::format_double(table.wavelength_um()[i]) + "," +
              mtf::format_double(table.transmission()[r][i]) + "," + mtf::format_double(table.radiance()[r][i]) + "\n";
  return text;
}

std::string tape7_text(const air::SpectralPath<double>& path, const std::string& what) {
  if (path.radiance.size() != path.wavenumber_cm.size())
    throw mtf::UsageError(
        "--tape7: the model has no emission above 3500 cm^-1 (below 2.857 um), which those columns need; give --bands "
        "above that wavelength, or take the transmission from --format csv");
  std::string text = " " + one_line(what) + "\n    FREQ  TOT_TRANS  PTH_THRML   SOL_SCAT\n";
  constexpr double kPerSquareCentimetre = 1e-4;
  for (std::size_t i = 0; i < path.wavenumber_cm.size(); ++i) {
    std::array<char, 64> line{};
    std::snprintf(line.data(), line.size(), "%8.2f %10.8f %10.4E%11s\n", path.wavenumber_cm[i], path.transmission[i],
                  kPerSquareCentimetre * path.radiance[i], "");
    text += line.data();
  }
  return text + " -9999.\n";
}

}  // namespace apps
