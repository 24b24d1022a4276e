// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf atmosphere` takes: the keys of [atmosphere], from a file, from options of the same names, or both.

#include <optional>
#include <string>

#include "apps/options.h"
#include "radiometry/atmosphere/atmosphere_settings.h"

namespace apps {

struct AtmosphereOptions {
  std::string file;                                        ///< sensor file with [atmosphere]; "" = the options alone
  std::vector<std::pair<std::string, std::string>> given;  ///< key of [atmosphere], text
  std::string bands;                                       ///< "LO:HI,LO:HI" in um; "" = the sensor's, or four usual
  double source_k = 300.0;
  double tolerance = 0.0;
  bool sky = false;
  std::optional<double> cloud_cover, cloud_k;  ///< of the sky
  std::optional<double> longwave_w_m2;         ///< measured, in place of cloud_cover
  Format format = Format::table;
  std::string out;     ///< "" = stdout
  std::string plot;    ///< .svg, .pdf or .png
  std::string table;   ///< CSV over range and wavelength, as path.table reads it
  std::string ranges;  ///< of it, in m: "START:STOP:COUNT" or a list; "" = as its tolerance needs
  std::string tape7;
};

/// What it prints with --format json. Writes no files. Throws UsageError and RuntimeError as the command.
std::string atmosphere_json(const AtmosphereOptions& options, const Global& global);

}  // namespace apps
