// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/thermal_detector.h"

namespace radiometry {

void require_bolometer(const std::string& where, const ThermalBody<double>& body,
                       const BolometerReadout<double>& readout, double emissivity, double area_m2) {
  const auto refuse = [&](const char* key, const std::string& why) {
    throw mtf::UsageError(where + "." + key + ": " + why);
  };
  if (!(body.conductance_w_k > 0.0))
    refuse("conductance", mtf::format_double(body.conductance_w_k) +
                              " W/K; a pixel that loses no heat has no steady temperature: give the conductance of its "
                              "legs, for example 1e-8");
  require_valid(where, body);
  require_valid(where, readout);
  const double least = radiation_conductance_w_k(emissivity, area_m2, body.temperature_k);
  if (body.conductance_w_k < least)
    refuse("conductance", mtf::format_double(body.conductance_w_k) + " W/K is below the " + mtf::three_digits(least) +
                              " W/K by which the pixel radiates, 4 emissivity sigma A T^3; give the conductance of "
                              "legs, gas and radiation together, or a smaller area or absorptance");
  if (readout.tcr_per_k == 0.0)
    refuse("tcr", "0, so that the resistance does not follow the temperature; give it per kelvin, for example -0.02");
  if (readout.corner_hz > 0.0 && !(readout.lowest_hz > 0.0 && readout.lowest_hz < readout.bandwidth_hz))
    refuse("lowest_frequency",
           mtf::format_double(readout.lowest_hz) +
               " Hz; 1/f noise has a finite value from a frequency above 0 to below the noise bandwidth of " +
               mtf::format_double(readout.bandwidth_hz) +
               " Hz: give the inverse of the time between two corrections of the offset, for example \"0.01 Hz\"");
}

}  // namespace radiometry
