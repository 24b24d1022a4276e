// SPDX-License-Identifier: Apache-2.0
#include "apps/atmosphere/atmosphere_report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/units.h"

namespace apps {

namespace air = radiometry::atmosphere;

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string length_words(double m) {
  const double shown = std::abs(m) < 1e-3 ? 0.0 : m;  // the rest is rounding of a traced line
  return shown >= 1000.0 ? significant(1e-3 * shown, 4) + " km" : significant(shown, 4) + " m";
}

std::string band_words(const radiometry::Interval& band) {
  return significant(band.lo_um, 4) + "-" + significant(band.hi_um, 4);
}

std::string radiance_unit(radiometry::Flux flux) {
  return flux == radiometry::Flux::watts ? "W m^-2 sr^-1" : "ph s^-1 m^-2 sr^-1";
}

/// Components that do nothing in any band would only fill the table.
bool acts(const AtmosphereReport& report, std::size_t component) {
  return std::any_of(report.bands.begin(), report.bands.end(),
                     [&](const BandAverage& b) { return b.component[component] < 0.99995; });
}

/// Of curves over the wavenumber those over the wavelength.
std::vector<double> reversed(const std::vector<double>& values) { return {values.rbegin(), values.rend()}; }

std::vector<double> wavelengths_um(const air::SpectralPath<double>& path) {
  std::vector<double> all = reversed(path.wavenumber_cm);
  for (double& one : all) one = 1e4 / one;
  return all;
}

/// The curve of one component over the wavelength.
radiometry::Path only(const air::SpectralPath<double>& path, std::size_t component) {
  radiometry::Path result;
  result.transmission = radiometry::make_spectrum(std::string(air::kComponentNames[component]), wavelengths_um(path),
                                                  reversed(path.component[component]), 1.0);
  return result;
}

Json sight_json(const air::SightNumbers<double>& sight) {
  return {{"range_m", sight.range_m},
          {"zenith_angle_deg", kDegrees * sight.zenith_rad},
          {"target_altitude_m", sight.object_altitude_m},
          {"lowest_altitude_m", sight.lowest_altitude_m}};
}

/// A row an angle: it, the radiance in each band, that of all wavelengths.
TextTable sky_rows(const SkyReport& report, std::vector<std::string> header,
                   const std::function<std::string(double)>& number) {
  TextTable table(std::move(header));
  for (std::size_t i = 0; i < report.zenith_deg.size(); ++i) {
    std::vector<std::string> row{number(report.zenith_deg[i])};
    for (const double value : report.band_radiance[i]) row.push_back(number(value));
    row.push_back(number(report.radiance[i]));
    table.add(std::move(row));
  }
  return table;
}

}  // namespace

BandAverage band_average(const air::SpectralPath<double>& path, const radiometry::SpectralCamera& camera,
                         double source_k) {
  const radiometry::Surface surface{.temperature_k = source_k};
  const radiometry::Path whole = path_of(path, "the air");
  const double clear = scene_radiance(camera, surface, {}), clear_slope = scene_derivative(camera, surface, {});
  if (!(clear > 0.0 && clear_slope > 0.0))
    throw mtf::UsageError("a blackbody of " + mtf::format_double(source_k) + " K gives nothing from " +
                          describe(camera.band) + " to weigh the air by; give a hotter --source-temperature");
  BandAverage average{.band = camera.band};
  average.transmission = scene_radiance(camera, surface, whole) / clear;
  average.contrast_transmission = scene_derivative(camera, surface, whole) / clear_slope;
  average.has_radiance = camera.band.lo_um >= air::kShortestEmission_um;
  average.radiance = band_radiances(camera, surface, whole, {}).path;
  for (std::size_t c = 0; c < air::kComponents; ++c)
    average.component[c] = scene_radiance(camera, surface, only(path, c)) / clear;
  return average;
}

std::string air_words(const radiometry::AtmosphereSettings& s, const air::Air<double>& through) {
  std::string text = through.profile.source;
  if (s.temperature_k && !s.pressure_pa) text += ", " + significant(*s.temperature_k, 5) + " K at the lowest altitude";
  if (s.relative_humidity && !s.pressure_pa)
    text += ", " + significant(100.0 * *s.relative_humidity, 4) + " % humidity at the lowest altitude";
  text += ", CO2 " + significant(through.profile.levels.front()[air::Gas::carbon_dioxide], 4) + " ppm";
  const std::string kind(air::kHazeNames[static_cast<std::size_t>(through.haze.kind)]);
  text += through.haze.kind == air::HazeKind::none ? ", no aerosol"
                                                   : ", " + kind + (kind.ends_with("fog") ? "" : " haze") +
                                                         ", visibility " + length_words(through.haze.visibility_m);
  if (through.rain_mm_h > 0.0) text += ", rain " + significant(through.rain_mm_h, 4) + " mm/h";
  return text;
}

std::string sight_words(const air::SightNumbers<double>& sight, double sensor_altitude_m) {
  return length_words(sight.range_m) + " from " + length_words(sensor_altitude_m) + " to " +
         length_words(sight.object_altitude_m) + " altitude, zenith angle " +
         significant(kDegrees * sight.zenith_rad, 5) + " deg at the sensor, lowest altitude " +
         length_words(sight.lowest_altitude_m);
}

std::string as_table(const AtmosphereReport& report) {
  std::string text = "air   " + one_line(report.air) + "\nline  " + report.line + "\n";
  TextTable bands({"band [um]", "transmission", "of contrast", "path radiance [" + radiance_unit(report.flux) + "]"});
  for (const BandAverage& b : report.bands)
    bands.add({band_words(b.band), fixed(b.transmission, 5), fixed(b.contrast_transmission, 5),
               b.has_radiance ? significant(b.radiance, 5) : "not modelled"});
  const std::string source = significant(report.source_k, 5) + " K";
  text += bands.aligned({Align::left, Align::right, Align::right, Align::right});
  text += "transmission: of a blackbody of " + source + (report.response ? " through the sensor's response" : "") +
          "; of contrast: of a small difference from " + source + "\n\n";
  std::vector<std::string> header{"component"};
  for (const BandAverage& b : report.bands) header.push_back(band_words(b.band) + " um");
  TextTable components(header);
  std::string clear;
  for (std::size_t c = 0; c < air::kComponents; ++c) {
    const std::string name(air::kComponentNames[c]);
    if (!acts(report, c)) {
      clear += (clear.empty() ? "" : ", ") + name;
      continue;
    }
    std::vector<std::string> row{name};
    for (const BandAverage& b : report.bands) row.push_back(fixed(b.component[c], 5));
    components.add(std::move(row));
  }
  text += components.aligned({Align::left, Align::right, Align::right, Align::right, Align::right});
  if (!clear.empty()) text += "above 0.99995 in every band: " + clear + "\n";
  for (const air::LeftOut& left : report.path.left_out)
    text += "left out: " + left.what + " (transmission at most " + significant(left.bound, 2) + " too large)\n";
  return text;
}

std::string as_json(const AtmosphereReport& report) {
  Json json{{"air", report.air}, {"line", sight_json(report.path.sight)}, {"source_temperature_k", report.source_k}};
  json["bands"] = Json::array();
  for (const BandAverage& b : report.bands) {
    Json band{{"wavelength_um", {b.band.lo_um, b.band.hi_um}},
              {"transmission", b.transmission},
              {"contrast_transmission", b.contrast_transmission},
              {"path_radiance", b.has_radiance ? Json(b.radiance) : Json()},
              {"path_radiance_unit", radiance_unit(report.flux)}};
    for (std::size_t c = 0; c < air::kComponents; ++c)
      band["components"][std::string(air::kComponentNames[c])] = b.component[c];
    json["bands"].push_back(std::move(band));
  }
  json["wavenumber_cm-1"] = report.path.wavenumber_cm;
  json["transmittance"] = report.path.transmission;
  Json& radiance = json["path_radiance_W_m-2_sr-1_per_cm-1"] = report.path.radiance;
  while (radiance.size() < report.path.wavenumber_cm.size()) radiance.push_back(nullptr);
  for (std::size_t c = 0; c < air::kComponents; ++c)
    json["components"][std::string(air::kComponentNames[c])] = report.path.component[c];
  json["left_out"] = Json::array();
  for (const air::LeftOut& left : report.path.left_out)
    json["left_out"].push_back({{"what", left.what}, {"bound", left.bound}});
  json["limits"] = report.limits;
  return json_document(json, -1);
}

std::vector<Figure> atmosphere_figures(const AtmosphereReport& report) {
  const air::SpectralPath<double>& path = report.path;
  const std::vector<double> wavelength_um = wavelengths_um(path);
  Figure transmission;
  transmission.title = "transmission over " + length_words(path.sight.range_m);
  transmission.x_label = "wavelength [um]";
  transmission.y_label = "transmission";
  transmission.y_low = 0.0;
  transmission.y_high = 1.02;
  for (std::size_t c = 0; c < air::kComponents; ++c) {
    const auto& curve = path.component[c];
    if (curve.empty() || *std::min_element(curve.begin(), curve.end()) > 0.95) continue;
    Series series{std::string(air::kComponentNames[c]), wavelength_um, reversed(curve)};
    std::replace(series.name.begin(), series.name.end(), '_', ' ');
    series.style = c;
    transmission.series.push_back(std::move(series));
  }
  transmission.series.push_back({"total", wavelength_um, reversed(path.transmission), true});
  std::vector<Figure> figures{std::move(transmission)};
  if (path.radiance.size() != path.wavenumber_cm.size()) return figures;  // no emission in a part of the band
  Figure radiance;
  radiance.title = "thermal radiance of the path";
  radiance.x_label = "wavelength [um]";
  radiance.y_label = "radiance [W/m2/sr/um]";
  std::vector<double> per_um;
  for (std::size_t i = path.radiance.size(); i-- > 0;)
    per_um.push_back(path.radiance[i] * path.wavenumber_cm[i] * path.wavenumber_cm[i] * 1e-4);
  radiance.series.push_back({"path radiance", wavelength_um, std::move(per_um), true});
  radiance.y_low = 0.0;
  figures.push_back(std::move(radiance));
  return figures;
}

std::string as_table(const SkyReport& report) {
  std::vector<std::string> header{"zenith angle [deg]"};
  for (const radiometry::Interval& band : report.bands) header.push_back(band_words(band) + " um");
  header.emplace_back("all wavelengths");
  const TextTable table = sky_rows(report, std::move(header), [](double value) { return significant(value, 5); });
  return "air   " + one_line(report.air) + "\nsky   radiance in W m^-2 sr^-1, seen from an altitude of " +
         length_words(report.altitude_m) + "\n" +
         table.aligned(std::vector<Align>(report.bands.size() + 2, Align::right)) +
         (report.clouds.cover > 0.0 ? "clouds of " + significant(report.clouds.temperature_k, 4) + " K over " +
                                          significant(100.0 * report.clouds.cover, 3) + " % of the sky\n"
                                    : "") +
         "long-wave irradiance of a horizontal plane under this " + (report.clouds.cover > 0.0 ? "" : "clear ") +
         "sky " + fixed(report.flux.total_w_m2, 1) + " W/m2, of it " + fixed(report.flux.below_650_w_m2, 1) +
         " W/m2 below 650 cm^-1, where the sky is taken for black\n";
}

std::string as_csv(const SkyReport& report) {
  std::vector<std::string> header{"zenith_angle_deg"};
  for (const radiometry::Interval& band : report.bands)
    header.push_back("radiance_" + band_words(band) + "_um_W_m-2_sr-1");
  header.emplace_back("all_wavelengths_W_m-2_sr-1");
  return sky_rows(report, std::move(header), [](double value) { return mtf::format_double(value); }).csv();
}

std::string as_json(const SkyReport& report) {
  Json json{{"air", report.air},
            {"altitude_m", report.altitude_m},
            {"cloud_cover", report.clouds.cover},
            {"cloud_temperature_k", report.clouds.cover > 0.0 ? Json(report.clouds.temperature_k) : Json()},
            {"longwave_w_m2", report.flux.total_w_m2},
            {"longwave_below_650_cm-1_w_m2", report.flux.below_650_w_m2},
            {"zenith_angle_deg", report.zenith_deg},
            {"radiance_W_m-2_sr-1", report.radiance}};
  json["bands"] = Json::array();
  for (std::size_t b = 0; b < report.bands.size(); ++b) {
    Json values = Json::array();
    for (const auto& row : report.band_radiance) values.push_back(row[b]);
    json["bands"].push_back({{"wavelength_um", {report.bands[b].lo_um, report.bands[b].hi_um}},
                             {"radiance_W_m-2_sr-1", std::move(values)}});
  }
  return json_document(json, -1);
}

}  // namespace apps
