// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/path.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/units.h"

namespace radiometry {

using mtf::format_double;
using mtf::UsageError;

Path constant_path(double transmission, double radiance) {
  return {.transmission = constant_spectrum("transmission of the path", transmission, 1.0),
          .radiance = constant_spectrum("radiance of the path", radiance)};
}

Path absorbing_path(const Spectrum& transmission, double air_temperature_k) {
  if (!(air_temperature_k >= 0.0) || !std::isfinite(air_temperature_k))
    throw UsageError(transmission.source + ": air of " + format_double(air_temperature_k) +
                     " K; the temperature has to be 0 or above");
  return {.transmission = transmission, .emissivity = complement(transmission), .air_temperature_k = air_temperature_k};
}

Spectrum complement(const Spectrum& spectrum) {
  Spectrum rest = spectrum;
  for (std::size_t i = 0; i < rest.value.size(); ++i) {
    if (rest.value[i] > 1.0)
      throw UsageError(spectrum.source + ": sample " + std::to_string(i + 1) + ": value " +
                       format_double(rest.value[i]) + " is above 1; is it in percent?");
    rest.value[i] = 1.0 - rest.value[i];
  }
  return rest;
}

PathTable::PathTable(std::string source, std::vector<double> range_m, std::vector<double> wavelength_um,
                     std::vector<std::vector<double>> transmission, std::vector<std::vector<double>> radiance)
    : source_(std::move(source)), range_m_(std::move(range_m)), wavelength_um_(std::move(wavelength_um)) {
  if (range_m_.empty()) throw UsageError(source_ + ": no ranges; a table of paths needs at least one");
  if (transmission.size() != range_m_.size() || radiance.size() != range_m_.size())
    throw UsageError(source_ + ": " + std::to_string(range_m_.size()) + " ranges, " +
                     std::to_string(transmission.size()) + " curves of transmission and " +
                     std::to_string(radiance.size()) + " of radiance; give one of each for every range");
  for (std::size_t i = 0; i < range_m_.size(); ++i) {
    if (!std::isfinite(range_m_[i]) || !(range_m_[i] > (i == 0 ? 0.0 : range_m_[i - 1])))
      throw UsageError(source_ + ": range " + std::to_string(i + 1) + " is " + format_double(range_m_[i]) +
                       " m; ranges have to be above 0 and increase");
    const std::string where = source_ + ", range " + format_double(range_m_[i]) + " m";
    transmission_.push_back(make_spectrum(where + ", transmission", wavelength_um_, transmission[i], 1.0).value);
    radiance_.push_back(make_spectrum(where + ", radiance", wavelength_um_, radiance[i]).value);
  }
}

Path PathTable::at(double range_m) const {
  if (!(range_m >= 0.0 && range_m <= range_m_.back()))
    throw UsageError(source_ + ": a path of " + format_double(range_m) + " m; the table goes from 0 to " +
                     format_double(range_m_.back()) + " m");
  const std::size_t i = static_cast<std::size_t>(std::ranges::lower_bound(range_m_, range_m) - range_m_.begin());
  const double from = i == 0 ? 0.0 : range_m_[i - 1], t = (range_m - from) / (range_m_[i] - from);
  std::vector<double> transmission, radiance;
  for (std::size_t j = 0; j < wavelength_um_.size(); ++j) {
    const double tau0 = i == 0 ? 1.0 : transmission_[i - 1][j], tau1 = transmission_[i][j];
    const double added0 = i == 0 ? 0.0 : radiance_[i - 1][j], added1 = radiance_[i][j];
    const bool beer = tau0 > 0.0 && tau1 > 0.0;
    transmission.push_back(beer ? tau0 * std::pow(tau1 / tau0, t) : tau0 * (1.0 - t) + tau1 * t);
    radiance.push_back(added0 * (1.0 - t) + added1 * t);
  }
  return {.transmission = {source_ + ", transmission", wavelength_um_, std::move(transmission)},
          .radiance = {source_ + ", radiance", wavelength_um_, std::move(radiance)}};
}

}  // namespace radiometry
