// SPDX-License-Identifier: Apache-2.0

// What `mtf atmosphere` takes: an option for every key of [atmosphere], from the field table of its settings.

#include "apps/atmosphere/atmosphere_options.h"
#include "apps/commands.h"
#include "apps/key_options.h"

namespace apps {

Command atmosphere_command() {
  const auto shared = std::make_shared<AtmosphereOptions>();
  AtmosphereOptions& options = *shared;
  Command app{
      "atmosphere", "transmission and thermal radiance of the air by a band model",
      "The air and the line of sight are those of [atmosphere] of a sensor file, or of options with the names "
      "of its\nkeys, which also take the place of single keys of the file. Of a scene file the air begins at its "
      "place. The table has averages in bands, "
      "weighted with the\nsensor's own response where a file is given; csv has the spectrum, json both. The "
      "model: radiometry/atmosphere.",
      "  mtf atmosphere --model mid_latitude_summer --haze rural --visibility '23 km' --range '2 km'\n"
      "  mtf atmosphere --model us_standard_1976 --zenith-angle '0 deg' --bands 8:12 --format csv -o zenith.csv"};
  add_text(app, "file", "FILE", "sensor or scene file with [atmosphere]; without one the options say all",
           options.file);
  add_keys(app, radiometry::AtmosphereSettings{}, options.given, [](std::string_view) { return true; });
  add_text(app, "--bands", "LO:HI,...", "in um; default: the band of the sensor, or 3:5,3.4:4.8,8:12,8:14",
           options.bands);
  add_word(app, "--source-temperature", "K", "of the blackbody that weighs transmissions; default 300",
           [&](const std::string& text) { options.source_k = temperature("--source-temperature", text).kelvin; });
  add_word(app, "--tolerance", "X",
           "leave out absorbers and layers that change no transmission by more; default 0: none",
           [&](const std::string& text) {
             options.tolerance = number("--tolerance", text);
             if (!(options.tolerance >= 0.0 && options.tolerance < 1.0))
               throw mtf::UsageError("--tolerance " + text + ": from 0 to below 1");
           });
  add_flag(app, "--sky", "the radiance of the sky over the zenith angle, in place of a line of sight", options.sky);
  add_word(app, "--cloud-cover", "N", "of --sky: share of the sky, 0 to 1, under clouds of --cloud-temperature",
           [&](const std::string& text) { options.cloud_cover = number("--cloud-cover", text); });
  add_word(app, "--cloud-temperature", "K", "of the clouds, taken for black",
           [&](const std::string& text) { options.cloud_k = temperature("--cloud-temperature", text).kelvin; });
  add_word(app, "--longwave", "W/m2",
           "measured on a horizontal plane: the cloud cover is the one that it needs, in place of --cloud-cover",
           [&](const std::string& text) { options.longwave_w_m2 = number("--longwave", text); });
  add_text(app, "--plot", "FILE", "figure of the spectrum: a .svg, .pdf or .png file", options.plot);
  add_text(app, "--table", "FILE", "CSV over range and wavelength, which path.table of a sensor file reads",
           options.table);
  add_text(app, "--ranges", "LIST",
           "of --table in m: START:STOP:COUNT or a comma list; default: from a hundredth of --range to it, as "
           "many as 1e-4 in transmission needs",
           options.ranges);
  add_text(app, "--tape7", "FILE", "the spectrum in columns as in MODTRAN's tape7", options.tape7);
  add_format(app, "table (default), csv or json", options.format);
  add_text(app, "-o,--out", "FILE", "write the result here instead of standard output", options.out);
  app.run = [shared](const Global& global) { return run_atmosphere(*shared, global); };
  return app;
}

}  // namespace apps
