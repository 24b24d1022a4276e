// SPDX-License-Identifier: Apache-2.0

// `mtf atmosphere`: spectrum, band averages, sky, and files of the air that other programs read.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "apps/atmosphere/atmosphere_options.h"
#include "apps/atmosphere/atmosphere_report.h"
#include "apps/commands.h"
#include "apps/config_command.h"
#include "apps/key_options.h"
#include "apps/modules/modules.h"
#include "apps/sensor/sensor_air.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/config_tree.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/units.h"
#include "radiometry/atmosphere/range_table.h"
#include "radiometry/atmosphere/spectral_path.h"
#include "radiometry/light/path.h"

namespace apps {
namespace {

// Spectra of the air as files: CSV of `mtf atmosphere`, the table over ranges that path.table reads, and
// columns as in MODTRAN's tape7 (mtf/io/csv/tape7.h says which), for programs that read those.

namespace air = radiometry::atmosphere;

/// wavenumber_cm-1,wavelength_um,transmittance,path_radiance_W_m-2_sr-1_per_cm-1, then one column a component. Without
/// emission (above 3500 cm^-1) the radiance is an empty field.
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

/// range_m,wavelength_um,transmission,radiance_w_m2_sr_um
std::string path_table_csv(const radiometry::PathTable& table, const std::string& what) {
  std::string text = "# " + one_line(what) + "\nrange_m,wavelength_um,transmission,radiance_w_m2_sr_um\n";
  for (std::size_t r = 0; r < table.range_m().size(); ++r)
    for (std::size_t i = 0; i < table.wavelength_um().size(); ++i)
      text += mtf::format_double(table.range_m()[r]) + "," + mtf::format_double(table.wavelength_um()[i]) + "," +
              mtf::format_double(table.transmission()[r][i]) + "," + mtf::format_double(table.radiance()[r][i]) + "\n";
  return text;
}

/// One run with FREQ, TOT TRANS and PTH THRML; SOL SCAT is blank. Throws UsageError where the model has no emission.
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

using radiometry::Interval;

constexpr double kTableError = 1e-4, kNearest = 1e-2;  // of a table up to --range
constexpr double kDryAltitude_m = 5000.0;
constexpr std::size_t kMostTableRanges = 4096, kMostRanges = 256, kMostBands = 32;
constexpr std::array kUsualBands{Interval{3.0, 5.0}, Interval{3.4, 4.8}, Interval{8.0, 12.0}, Interval{8.0, 14.0}};

/// What file and options say together.
struct Given {
  radiometry::AtmosphereSettings settings;
  std::optional<radiometry::SpectralCamera> camera;  ///< of a sensor file
  air::AerosolLoss loss = air::AerosolLoss::extinction;
  std::optional<double> place_m;  ///< altitude of the place of a scene file, where its air begins
  std::vector<std::string> files;
};

/// Of a scene, whose weather gives the temperature and humidity at its place, the air above that.
air::Air<double> air_in(const Given& given) {
  if (!given.place_m) return read_air(given.settings);
  radiometry::AtmosphereSettings alone = given.settings;
  alone.sensor_altitude_m = 0.0;
  alone.target_altitude_m = alone.zenith_deg = alone.range_m = std::nullopt;
  return scenes_module().air_above(alone, *given.place_m);
}

/// True for a scene file: sensor files have no [place].
bool is_scene_file(const std::string& file) {
  const mtf::io::cfg::Tree tree = mtf::io::cfg::read_tree(mtf::io::read_text_file(file, mtf::io::cfg::kMaxBytes));
  return !tree.error && tree.root.find("place") != nullptr;
}

Given given_by(const AtmosphereOptions& options, const Global& global) {
  Given given;
  if (!options.file.empty() && is_scene_file(options.file)) {
    SceneAir scene = scenes_module().air(options.file, global);
    given.settings = std::move(scene.settings);
    given.place_m = scene.place_m;
    given.files = std::move(scene.files);
  } else if (!options.file.empty()) {
    const mtf::io::SensorConfig config = read_sensor(options.file, global);
    const mtf::SettingsTable* table = find_table(config.tables, "atmosphere");
    if (table == nullptr)
      throw mtf::UsageError(config.file +
                            ": has no [atmosphere]; add one (mtf config kinds atmosphere), or say all by options");
    given.settings = radiometry::from_table<radiometry::AtmosphereSettings>(*table);
    if (config.system.band) given.camera = load_curves(config);
    given.loss = loss_in(config.system);
    given.files = files_of(config);
  }
  set_keys(given.settings, options.given);
  if (!given.settings.profile.empty()) given.files.push_back(given.settings.profile);
  return given;
}

std::vector<Interval> bands_of(const AtmosphereOptions& options, const Given& given) {
  if (options.bands.empty())
    return given.camera ? std::vector{given.camera->band}
                        : std::vector<Interval>(kUsualBands.begin(), kUsualBands.end());
  std::vector<Interval> bands;
  for (std::size_t at = 0; at <= options.bands.size();) {
    const std::size_t end = std::min(options.bands.find(',', at), options.bands.size());
    const auto ends = number_range("--bands", options.bands.substr(at, end - at));
    bands.push_back({ends[0], ends[1]});
    at = end + 1;
  }
  if (bands.size() > kMostBands) throw mtf::UsageError("--bands: at most " + std::to_string(kMostBands) + " bands");
  return bands;
}

Interval hull(const std::vector<Interval>& bands) {
  Interval all = bands.front();
  for (const Interval& band : bands) all = {std::min(all.lo_um, band.lo_um), std::max(all.hi_um, band.hi_um)};
  return all;
}

radiometry::SpectralCamera camera_in(const Given& given, const Interval& band) {
  radiometry::SpectralCamera camera = given.camera.value_or(radiometry::SpectralCamera{});
  if (!given.camera) camera.flux = radiometry::Flux::watts;
  camera.band = band;
  return camera;
}

std::vector<std::string> outputs_of(const AtmosphereOptions& options) {
  std::vector<std::string> outputs;
  for (const std::string& file : {options.table, options.tape7})
    if (!file.empty()) outputs.push_back(file);
  for (std::string& file : figure_files(options.plot)) outputs.push_back(std::move(file));
  outputs.push_back(options.out);
  if (options.sky && (!options.table.empty() || !options.tape7.empty() || !options.plot.empty()))
    throw mtf::UsageError("--sky: prints the sky; --table, --tape7 and --plot are of a line of sight, remove them");
  const int covers = (options.cloud_cover ? 1 : 0) + (options.longwave_w_m2 ? 1 : 0);
  if (!options.sky && (covers > 0 || options.cloud_k))
    throw mtf::UsageError("clouds: are of --sky; add it, or remove --cloud-cover, --cloud-temperature and --longwave");
  if (covers != (options.cloud_k ? 1 : 0))
    throw mtf::UsageError("clouds: give --cloud-temperature and one of --cloud-cover and --longwave");
  if (!options.ranges.empty() && options.table.empty())
    throw mtf::UsageError("--ranges: are those of --table FILE; add it");
  return outputs;
}

std::vector<double> table_ranges(const AtmosphereOptions& options, const air::Air<double>& through,
                                 const air::Sight<double>& sight, const Interval& band, const Global& global) {
  if (!options.ranges.empty()) {
    std::vector<double> ranges_m = frequency_list("--ranges", options.ranges);
    if (ranges_m.size() > kMostTableRanges)
      throw mtf::UsageError("--ranges: " + std::to_string(ranges_m.size()) + " ranges; a table has at most " +
                            std::to_string(kMostTableRanges) + ", between which it is interpolated");
    return ranges_m;
  }
  const double longest_m = sight_numbers(through, sight).range_m;
  double nearest_m = kNearest * longest_m;
  if (const auto* between = std::get_if<air::Between<double>>(&sight))
    nearest_m = std::max(nearest_m, std::abs(between->object_altitude_m - between->sensor_altitude_m));
  const air::TableRanges found = ranges_for(through, sight, nearest_m, longest_m, kTableError, band, kMostRanges);
  note(global, "note: " + std::to_string(found.ranges_m.size()) + " ranges from " +
                   significant(found.ranges_m.front(), 4) + " m on; between them the table is right within " +
                   significant(found.error, 2));
  return found.ranges_m;
}

std::string table_text(const AtmosphereOptions& options, const air::Air<double>& through,
                       const air::Sight<double>& sight, const Interval& band, const std::string& what,
                       const Global& global) {
  const std::vector<double> ranges_m = table_ranges(options, through, sight, band, global);
  const air::RangeTableResult result =
      path_table(through, sight, ranges_m, {.band = band, .tolerance = options.tolerance});
  return path_table_csv(result.table, what);
}

air::Clouds clouds_of(const AtmosphereOptions& options, double clear_w_m2) {
  if (!options.cloud_k) return {};
  const double cover = options.longwave_w_m2 ? air::cloud_cover(*options.longwave_w_m2, clear_w_m2, *options.cloud_k)
                                             : *options.cloud_cover;
  return {cover, *options.cloud_k};
}

SkyReport sky_report(const AtmosphereOptions& options, const Given& given, const std::vector<Interval>& bands,
                     const Global& global) {
  const air::Air<double> through = air_in(given);
  SkyReport report;
  report.air = air_words(given.settings, through);
  report.altitude_m = given.settings.sensor_altitude_m;
  report.bands = bands;
  report.zenith_deg = {0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 75.0, 80.0, 85.0, 87.5, 90.0};
  const air::SkyFlux clear = sky_flux(through, report.altitude_m);
  report.clouds = clouds_of(options, clear.total_w_m2);
  if (options.longwave_w_m2 && report.clouds.cover == 0.0)
    note(global, "warning: --longwave " + mtf::format_double(*options.longwave_w_m2) +
                     " W/m2 is at most that of the clear sky, " + fixed(clear.total_w_m2, 1) +
                     " W/m2: it is taken for clear");
  if (options.longwave_w_m2 && report.clouds.cover == 1.0)
    note(global, "warning: --longwave " + mtf::format_double(*options.longwave_w_m2) +
                     " W/m2 is at least that of clouds all over: it is taken for overcast");
  for (const double degrees : report.zenith_deg) {
    const air::SkyRadiance sky = under_clouds(
        sky_radiance(through, report.altitude_m, degrees * std::numbers::pi / 180.0, options.tolerance), report.clouds);
    report.radiance.push_back(sky.whole);
    air::SpectralPath<double> path;
    path.wavenumber_cm = sky.wavenumber_cm;
    path.radiance = sky.radiance;
    path.transmission.assign(path.wavenumber_cm.size(), 0.0);
    auto& row = report.band_radiance.emplace_back();
    for (const Interval& band : bands)
      row.push_back(weighted_path_radiance(camera_in({}, band), path_of(path, "the sky")));
  }
  report.flux = under_clouds(clear, report.clouds);
  for (const std::string& limit : limits_of(through, hull(bands))) note(global, "warning: " + limit);
  if (report.altitude_m > kDryAltitude_m)
    note(global,
         "warning: above 5 km too little vapour is left to make the sky black below 650 cm^-1, as the flux takes it");
  return report;
}

/// The air that the line of sight goes through, haze as the sensor counts it.
air::Air<double> air_along(const Given& given) {
  air::Air<double> through = air_in(given);
  through.haze.loss = given.loss;
  return through;
}

AtmosphereReport line_report(const AtmosphereOptions& options, const Given& given, const std::vector<Interval>& bands) {
  const air::Air<double> through = air_along(given);
  const air::Sight<double> sight = read_sight(given.settings);
  AtmosphereReport report;
  report.air = air_words(given.settings, through);
  report.path =
      spectral_path(through, sight, {.band = hull(bands), .components = true, .tolerance = options.tolerance});
  report.flux = given.camera ? given.camera->flux : radiometry::Flux::watts;
  report.response = given.camera.has_value();
  report.source_k = options.source_k;
  report.line = sight_words(report.path.sight, given.settings.sensor_altitude_m);
  report.limits = limits_of(through, hull(bands), sight);
  for (const Interval& band : bands)
    report.bands.push_back(band_average(report.path, camera_in(given, band), options.source_k));
  return report;
}

int run_atmosphere(const AtmosphereOptions& options, const Global& global) {
  const Given given = given_by(options, global);
  OutputSet outputs({.files = outputs_of(options), .inputs = given.files});
  const std::vector<Interval> bands = bands_of(options, given);
  if (options.sky) {
    const SkyReport sky = sky_report(options, given, bands, global);
    outputs.commit(options.out, options.format == Format::csv    ? as_csv(sky)
                                : options.format == Format::json ? as_json(sky)
                                                                 : as_table(sky));
    return 0;
  }

  const air::Air<double> through = air_along(given);
  if (given.loss == air::AerosolLoss::absorption && through.haze.kind != air::HazeKind::none)
    note(
        global,
        "note: what haze scatters is in the aerosol component of the sensor; transmissions here hold what is absorbed");
  const air::Sight<double> sight = read_sight(given.settings);
  const AtmosphereReport report = line_report(options, given, bands);
  // A sensor file has said them already, of its own band.
  if (options.file.empty() || !options.bands.empty())
    for (const std::string& limit : report.limits) note(global, "warning: " + limit);

  const std::string what = report.air + "; " + report.line;
  if (!options.table.empty())
    emit(outputs.at(options.table), table_text(options, through, sight, hull(bands), what, global));
  if (!options.tape7.empty()) emit(outputs.at(options.tape7), tape7_text(report.path, what));
  if (!options.plot.empty() && !write_figures(outputs.at(options.plot), atmosphere_figures(report)))
    note(global, figure_note(options.plot, false));
  outputs.commit(options.out, options.format == Format::csv    ? spectrum_csv(report.path)
                              : options.format == Format::json ? as_json(report)
                                                               : as_table(report));
  return 0;
}

}  // namespace

std::string atmosphere_json(const AtmosphereOptions& options, const Global& global) {
  const Given given = given_by(options, global);
  const std::vector<Interval> bands = bands_of(options, given);
  return options.sky ? as_json(sky_report(options, given, bands, global)) : as_json(line_report(options, given, bands));
}

Command atmosphere_command() {
  Command app{
      "atmosphere", "transmission and thermal radiance of the air by a band model",
      "The air and the line of sight are those of [atmosphere] of a sensor file, or of options with the names "
      "of its\nkeys, which also take the place of single keys of the file. Of a scene file the air begins at its "
      "place. The table has averages in bands, "
      "weighted with the\nsensor's own response where a file is given; csv has the spectrum, json both. The "
      "model: radiometry/atmosphere.",
      "  mtf atmosphere --model mid_latitude_summer --haze rural --visibility '23 km' --range '2 km'\n"
      "  mtf atmosphere --model us_standard_1976 --zenith-angle '0 deg' --bands 8:12 --format csv -o zenith.csv"};
  auto& options = options_of<AtmosphereOptions>(app, run_atmosphere);
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
  add_value(app, "--cloud-cover", "N", "of --sky: share of the sky, 0 to 1, under clouds of --cloud-temperature",
            options.cloud_cover, number);
  add_word(app, "--cloud-temperature", "K", "of the clouds, taken for black",
           [&](const std::string& text) { options.cloud_k = temperature("--cloud-temperature", text).kelvin; });
  add_value(app, "--longwave", "W/m2",
            "measured on a horizontal plane: the cloud cover is the one that it needs, in place of --cloud-cover",
            options.longwave_w_m2, number);
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
  return app;
}

}  // namespace apps
