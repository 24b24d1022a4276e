// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/camera_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <regex>

#include "apps/edges/fit_parameters.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/replace_value.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"

namespace apps {
namespace {

using calib::Characterization, calib::Finding;

/// Which key of a sensor file a number stands in.
struct Key {
  std::string_view finding, key, unit;
};
constexpr std::array kKeys{Key{"electrons_per_count", "adc.electrons_per_count", " e-"},
                           Key{"offset", "adc.offset", ""},
                           Key{"read_noise", "detector.read_noise", " e-"},
                           Key{"dark_current", "detector.dark_current", " e-/s"},
                           Key{"a2", "nonlinearity.a2", ""},
                           Key{"a3", "nonlinearity.a3", ""},
                           Key{"a4", "nonlinearity.a4", ""},
                           Key{"dsnu", "nonuniformity.dsnu", " e-"},
                           Key{"prnu", "nonuniformity.prnu", ""},
                           Key{"prnu_row", "nonuniformity.prnu_row", ""},
                           Key{"prnu_column", "nonuniformity.prnu_column", ""},
                           Key{"dcnu", "nonuniformity.dcnu", ""},
                           Key{"flicker_octave", "frame_flicker.octave", " e-"},
                           Key{"row_noise", "noise.row", " e-"},
                           Key{"column_noise", "noise.column", " e-"},
                           Key{"fixed_row", "noise.fixed_row", " e-"},
                           Key{"fixed_column", "noise.fixed_column", " e-"},
                           Key{"frame_noise", "noise_3d.t", " e-"}};

std::string quantity(double value, std::string_view unit) {
  const std::string number = mtf::format_double(value);
  return unit.empty() ? number : "\"" + number + std::string(unit) + "\"";
}

/// What the numbers that are measured hold already: noise that stands elsewhere in the nominal would count twice.
constexpr std::array<std::string_view, 9> kCounted{
    "detector.reset_noise", "detector.other_noise", "detector.capacitance", "noise_3d.v",  "noise_3d.h",
    "noise_3d.tv",          "noise_3d.th",          "noise_3d.vh",          "noise_3d.tvh"};

/// Of what is measured: numbers that others hold where stacks do not tell them.
constexpr std::array<std::string_view, 2> kNotApart{"dark_current", "flicker_octave"};

/// Numbers of pixels that are not like the others; those that have a unit have one of signal.
constexpr std::array kPixelKeys{
    Key{"dead_fraction", "defects.dead_fraction", ""},   Key{"hot_fraction", "defects.hot_fraction", ""},
    Key{"hot_excess", "defects.hot", "signal"},          Key{"blinking_fraction", "blinking.fraction", ""},
    Key{"blinking_excess", "blinking.excess", "signal"}, Key{"blinking_dwell", "blinking.dwell", ""}};

/// The sensor of a changed text.
mtf::io::SensorConfig read_again(const std::string& text, const mtf::io::SensorConfig& before) {
  mtf::io::ConfigResult read = mtf::io::parse_config(text, before.file, before.schema);
  mtf::io::cfg::require_no_errors(read.diagnostics, before.file);
  return std::move(read.config);
}

/// Of what chi-square is.
std::string model_name(const Characterization& camera) {
  return camera.reference_k > 0.0 ? "counts over radiance" : "photon transfer";
}

Json finding_json(const Finding& f) {
  Json one{{"name", f.name}, {"unit", f.unit}, {"verdict", calib::verdict_name(f.verdict)}};
  const bool known = f.verdict != calib::Verdict::not_determined;
  const bool measured = known && f.verdict != calib::Verdict::predicted;
  one["value"] = known ? Json(f.value) : Json();
  one["sd"] = known && f.sd > 0.0 ? Json(f.sd) : Json();
  one["sd_array"] = f.sd_array ? Json(*f.sd_array) : Json();
  one["sd_systematic"] = f.sd_systematic ? Json(*f.sd_systematic) : Json();
  one["interval95"] = measured ? Json(std::vector<double>{f.low95, f.high95}) : Json();
  one["from"] = f.from;
  one["why"] = f.why.empty() ? Json() : Json(f.why);
  return one;
}

Json provenance_json(const StacksFile& stacks) {
  return {{"stacks", stacks.file},
          {"sha256", stacks.sha256},
          {"nominal", text_or_null(stacks.nominal)},
          {"nominal_sha256", text_or_null(stacks.nominal_sha256)}};
}

bool is_set(const Finding* f) { return f != nullptr && f->verdict == calib::Verdict::determined; }

}  // namespace

std::string value_with_error(const Finding& f, std::string_view unit, double scale) {
  const bool limit = f.verdict == calib::Verdict::upper_limit;
  const double sd = limit ? 0.25 * (f.high95 - f.low95) : std::hypot(f.sd, f.sd_systematic.value_or(0.0));
  const auto part = [&](double number) {
    return quantity(rounded_to_error(scale * (limit ? std::max(0.0, number) : number), scale * sd), unit);
  };
  return "{ value = " + part(f.value) +
         (limit ? ", interval = [" + part(f.low95) + ", " + part(f.high95) + "]" : ", stderr = " + part(sd)) + " }";
}

std::string shown(const Finding& f) {
  const std::string unit = f.unit.empty() ? "" : " " + f.unit;
  if (f.verdict == calib::Verdict::not_determined) return "not determined: " + f.why;
  if (f.verdict == calib::Verdict::upper_limit)
    return significant(std::max(0.0, f.low95), 3) + " .. " + significant(f.high95, 3) + unit + " (95 %)";
  if (f.verdict == calib::Verdict::predicted || !(f.sd > 0.0)) return significant(f.value, 4) + unit;
  const double systematic = f.sd_systematic.value_or(0.0);
  return shown_with_error(f.value, f.sd) + " +- " + significant(f.sd, 2) + unit +
         (systematic > 0.0 ? " (random) +- " + significant(systematic, 2) + unit + " (blackbodies)" : "");
}

mtf::io::SensorConfig without_key(mtf::io::SensorConfig sensor, const std::string& key) {
  const std::size_t dot = key.find('.');
  const mtf::SettingsTable* table = find_table(sensor.tables, key.substr(0, dot));
  if (table == nullptr || table->find(key.substr(dot + 1)) == nullptr) return sensor;
  return read_again(mtf::io::without_value(sensor, key), sensor);
}

mtf::io::SensorConfig with_pixels(mtf::io::SensorConfig sensor, const Characterization& camera, std::string_view unit,
                                  double scale) {
  const bool blinks = is_set(camera.find("blinking_fraction"));
  const bool has_blinking = find_table(sensor.tables, "blinking") != nullptr;
  std::string blinking = "\n[blinking]\n";
  for (const Key& one : kPixelKeys) {
    const Finding* const f = camera.find(one.finding);
    const std::string key(one.key), name = key.substr(key.find('.') + 1);
    const bool known = f != nullptr && f->verdict != calib::Verdict::not_determined;
    std::string value;
    if (known) value = one.unit.empty() ? value_with_error(*f, "") : value_with_error(*f, unit, scale);
    if (blinks && name == "dwell" && !known) value = "1";  // from frame to frame
    if (key.starts_with("defects"))
      sensor = known ? mtf::io::replaced(sensor, key, value) : without_key(std::move(sensor), key);
    else if (has_blinking && !value.empty())
      sensor = mtf::io::replaced(sensor, key, value);
    else
      blinking += name + " = " + value + "\n";
  }
  return blinks && !has_blinking ? read_again(sensor.text + blinking, sensor) : sensor;
}

mtf::io::SensorConfig with_lag(mtf::io::SensorConfig sensor, const Characterization& camera) {
  const Finding *const share = camera.find("lag_share"), *const time = camera.find("lag_time_constant");
  if (is_set(time)) return mtf::io::replaced(sensor, "lag.time_constant", value_with_error(*time, " s"));
  const mtf::SettingsTable* const table = find_table(sensor.tables, "lag");
  if (table == nullptr || share == nullptr || share->verdict != calib::Verdict::upper_limit) return sensor;
  std::string text =
      table->find("time_constant") != nullptr ? mtf::io::without_value(sensor, "lag.time_constant") : sensor.text;
  // The table has no other key, and is nothing without this one.
  return read_again(std::regex_replace(text, std::regex("(^|\n)[ \t]*\\[[ \t]*lag[ \t]*\\][^\n]*"), "$1"), sensor);
}

mtf::io::SensorConfig own_named(const mtf::io::SensorConfig& sensor, const std::string& destination) {
  if (sensor.files.empty()) return sensor;
  mtf::io::SensorConfig there = sensor;
  there.file = destination;
  return read_again(write_config(sensor, destination), there);
}

std::vector<std::string> not_measured(const CameraFile& file) {
  std::vector<std::string> all;
  if (!file.kept.empty())
    all.push_back((file.placeholders ? "placeholders, as there is no nominal: " : "kept from the nominal: ") +
                  joined(file.kept));
  if (!file.left_out.empty()) all.push_back("left out: " + joined(file.left_out));
  return all;
}

void add_not_measured(CameraFile& file, const std::vector<std::string>& keys, const mtf::io::SensorConfig& sensor) {
  for (const std::string& key : keys)
    (mtf::io::stated_value(sensor, key).empty() ? file.left_out : file.kept).push_back(key);
}

std::string file_head(const Characterization& camera, const StacksFile& stacks, const CameraFile& file) {
  const std::string nominal = stacks.nominal_sha256.empty()
                                  ? ""
                                  : "\n# nominal " + one_line(stacks.nominal) + ", sha256 " + stacks.nominal_sha256;
  return "# mtf characterize " + one_line(stacks.file) + ", sha256 " + stacks.sha256 + nominal + "\n# " +
         (camera.misfit ? "the model does not describe the frames: " + camera.misfit_reason
                        : model_name(camera) + ": p = " + significant(camera.transfer.p, 2)) +
         "\n# no measured number:\n" +
         joined(
             not_measured(file), [](const std::string& line) { return "#   " + line + "\n"; }, "") +
         joined(
             camera.warnings, [](const std::string& w) { return "# warning: " + one_line(w) + "\n"; }, "");
}

std::string least_sensor(std::int64_t columns, std::int64_t rows, int bits, double time_s) {
  return "schema = 2\nname = \"characterized camera\"\n\n[frame]\nfocal_length = \"50 mm\"\npitch = \"5 um\"\nformat = "
         "[" +
         std::to_string(columns) + ", " + std::to_string(rows) + "]\nintegration_time = \"" +
         mtf::format_double(time_s) +
         " s\"\n\n[scene]\nsample = \"5 um\"\nquantity = \"photon_radiance\"\n\n[optics]\nf_number = 4.0\n\n[band]\n"
         "wavelength = [\"0.50 um\", \"0.60 um\"]\n\n[detector]\nquantum_efficiency = 1.0\n\n[adc]\nbits = " +
         std::to_string(bits) + "\n";
}

CameraFile camera_file(const Characterization& camera, const StacksFile& stacks, mtf::io::SensorConfig nominal,
                       int bits, bool placeholders, bool maps, const std::string& destination) {
  CameraFile file{.placeholders = placeholders};
  std::vector<std::string> left;
  const auto set = [&](const std::string& key, const std::string& value) {
    nominal = mtf::io::replaced(nominal, key, value);
  };
  const auto unset = [&](const std::string& key) { nominal = without_key(std::move(nominal), key); };
  set("adc.bits", std::to_string(bits));
  if (const auto* epc = find_table(nominal.tables, "adc"); epc->find("rounding") != nullptr)
    set("adc.rounding", "nearest");
  // The response is stated by a full well, which the converter may end before.
  if (camera.full_well_e > 0.0) set("detector.full_well", mtf::format_double(camera.full_well_e) + " e-");
  for (const std::string_view key : kCounted) unset(std::string(key));
  for (const Key& one : kKeys) {
    const Finding* f = camera.find(one.finding);
    const std::string key(one.key);
    if (f != nullptr && f->verdict != calib::Verdict::not_determined) {
      set(key, value_with_error(*f, one.unit));
      continue;
    }
    if (f != nullptr) left.push_back(key);
    // Patterns of the nominal may stay; what stacks do not tell apart is in offset, read noise and rate.
    if (f == nullptr || std::ranges::find(kNotApart, one.finding) != kNotApart.end()) unset(key);
  }
  for (const Key& one : kPixelKeys)
    if (const Finding* f = camera.find(one.finding); f != nullptr && f->verdict == calib::Verdict::not_determined)
      left.emplace_back(one.key);
  nominal = with_pixels(std::move(nominal), camera, " e-");
  if (camera.flicker_lowest > 0.0)
    set("frame_flicker.lowest", mtf::format_double(camera.flicker_lowest));
  else
    unset("frame_flicker.lowest");
  const Finding* const rate = camera.find("rate");
  const bool photons = stacks.tells_photons();
  if (photons && rate->value <= 1.0)
    set("detector.quantum_efficiency", value_with_error(*rate, ""));
  else
    left.emplace_back("detector.quantum_efficiency");
  for (const char* const key : {"optics.transmission", "optics.f_number"}) left.emplace_back(key);
  if (placeholders)
    for (const char* const key : {"frame.focal_length", "frame.pitch", "band.wavelength"}) left.emplace_back(key);
  const Finding *side = camera.find("crosstalk_side"), *corner = camera.find("crosstalk_corner");
  const auto& list = nominal.system.list(mtf::Stage::readout);
  const auto there =
      std::find_if(list.begin(), list.end(), [](const auto& e) { return e.component.kind() == "crosstalk"; });
  if (there != list.end()) {
    const std::string label = there->label;
    set(label + ".side", is_set(side) ? value_with_error(*side, "") : "0");
    if (is_set(corner)) set(label + ".corner", value_with_error(*corner, ""));
  } else if (is_set(side)) {
    const std::string text = nominal.text +
                             "\n[[readout]]\nkind = \"crosstalk\"\nside = " + value_with_error(*side, "") + "\n" +
                             (is_set(corner) ? "corner = " + value_with_error(*corner, "") + "\n" : "");
    nominal = read_again(text, nominal);
  }
  nominal = own_named(with_lag(std::move(nominal), camera), destination);
  if (maps) {
    for (const char* const key :
         {"nonuniformity.prnu", "nonuniformity.prnu_row", "nonuniformity.prnu_column", "nonuniformity.dsnu",
          "noise.fixed_row", "noise.fixed_column", "defects.hot_fraction", "defects.dead_fraction", "defects.hot"})
      unset(key);
    set("nonuniformity.offset", "offset.exr");
    set("nonuniformity.responsivity", "responsivity.exr");
  }
  add_not_measured(file, left, nominal);
  file.text = file_head(camera, stacks, file) + nominal.text;
  return file;
}

std::string characterize_table(const Characterization& camera, const CameraFile& file) {
  TextTable table({"number", "value", "from"});
  for (const Finding& f : camera.findings) table.add({f.name, shown(f), f.from});
  std::string text = table.aligned();
  const auto& t = camera.transfer;
  text += "\n" + model_name(camera) + std::string(21 - model_name(camera).size(), ' ') + "chi-square " +
          significant(t.chi2, 4) + ", " + std::to_string(t.dof) + " degrees of freedom, p = " + significant(t.p, 2) +
          "\n";
  text += "defects              " + plural(std::ssize(camera.defects), "pixel") +
          (camera.reference_k > 0.0 ? " beyond 4.5 sd, which noise_vh counts and dsnu leaves out\n"
                                    : " of the dark beyond 4.5 sd\n");
  for (const std::string& line : not_measured(file)) text += line + "\n";
  if (camera.misfit) text += "the model does not describe the frames: " + camera.misfit_reason + "\n";
  for (const std::string& warning : camera.warnings) text += "warning: " + warning + "\n";
  return text;
}

Json characterize_json(const Characterization& camera, const StacksFile& stacks, const CameraFile& file) {
  const auto& t = camera.transfer;
  Json json{{"version", mtf::version}, {"status", camera.misfit ? "model_wrong" : "ok"}};
  json["reason"] = camera.misfit ? Json(camera.misfit_reason) : Json();
  json["warnings"] = camera.warnings;
  json["numbers"] = Json::array();
  for (const Finding& f : camera.findings) json["numbers"].push_back(finding_json(f));
  Json covariance = Json::array();
  for (Eigen::Index i = 0; i < t.covariance.rows(); ++i) {
    std::vector<double> row;
    for (Eigen::Index j = 0; j < t.covariance.cols(); ++j) row.push_back(t.covariance(i, j));
    covariance.push_back(Json(row));
  }
  json[camera.reference_k > 0.0 ? "counts_over_radiance" : "photon_transfer"] = {{"chi2", t.chi2},
                                                                                 {"dof", t.dof},
                                                                                 {"p", t.p},
                                                                                 {"names", t.names},
                                                                                 {"covariance", covariance},
                                                                                 {"full_well_e", camera.full_well_e}};
  json["reference_temperature_k"] = camera.reference_k > 0.0 ? Json(camera.reference_k) : Json();
  json["defects"] = Json::array();
  constexpr std::size_t kMost = 10'000;
  for (std::size_t i = 0; i < std::min(kMost, camera.defects.size()); ++i)
    json["defects"].push_back(
        {{"x", camera.defects[i].x}, {"y", camera.defects[i].y}, {"excess_counts", camera.defects[i].excess}});
  json["defect_count"] = camera.defects.size();
  json["light_unit"] = stacks.has_blackbodies()               ? "weighted radiance"
                       : stacks.unit == LightUnit::irradiance ? "photons"
                                                              : name_of(stacks.unit);
  std::vector<std::string> all = file.kept;
  all.insert(all.end(), file.left_out.begin(), file.left_out.end());
  json["not_measured"] = all;
  json["kept_from_nominal"] = file.placeholders ? std::vector<std::string>() : file.kept;
  json["placeholders"] = file.placeholders ? file.kept : std::vector<std::string>();
  json["left_out"] = file.left_out;
  json["provenance"] = provenance_json(stacks);
  return json;
}

std::string emva1288_table(const calib::Emva1288& standard) {
  TextTable table({"EMVA 1288", "value", "definition"});
  std::string notes;
  for (const calib::EmvaNumber& n : standard.numbers) {
    table.add({n.finding.name, shown(n.finding), n.finding.from});
    if (!n.note.empty()) notes += "note: " + n.finding.name + ": " + n.note + "\n";
  }
  std::string text = table.aligned() + "\nphoton transfer      " + standard.frames + "\n";
  if (!standard.patterns.empty()) text += "patterns             " + standard.patterns + "\n";
  text += "biases               " + standard.biases + "\n" + notes;
  for (const std::string& warning : standard.warnings) text += "warning: " + warning + "\n";
  return text;
}

Json emva1288_json(const calib::Emva1288& standard, const StacksFile& stacks) {
  Json json{{"version", mtf::version}, {"method", "EMVA 1288 R4.0 Linear"}, {"warnings", standard.warnings}};
  json["numbers"] = Json::array();
  for (const calib::EmvaNumber& n : standard.numbers) {
    Json one = finding_json(n.finding);
    one["bias_relative"] = n.bias ? Json(*n.bias) : Json();
    one["note"] = n.note.empty() ? Json() : Json(n.note);
    json["numbers"].push_back(std::move(one));
  }
  json["frames"] = standard.frames;
  json["patterns"] = standard.patterns;
  json["biases"] = standard.biases;
  json["provenance"] = provenance_json(stacks);
  return json;
}

std::string levels_csv(const Characterization& camera) {
  TextTable table({"stack",
                   "light",
                   "exposure_s",
                   "frames",
                   "used",
                   "share_low",
                   "share_high",
                   "mean",
                   "model_mean",
                   "mean_z",
                   "variance",
                   "dof",
                   "model_variance",
                   "variance_z",
                   "light_error",
                   "t",
                   "v",
                   "h",
                   "tv",
                   "th",
                   "vh",
                   "tvh"});
  for (std::size_t i = 0; i < camera.stacks.size(); ++i) {
    const calib::Stack& stack = camera.stacks[i];
    const int level = camera.level_of[i];
    const auto fitted =
        level < 0 ? calib::PhotonTransfer::Level() : camera.transfer.levels[static_cast<std::size_t>(level)];
    const auto& squares = stack.sums.squares;
    const auto model = [&](double value) { return level < 0 ? std::string() : csv_number(value); };
    std::vector<std::string> row{csv_field(stack.name),
                                 csv_number(stack.light),
                                 csv_number(stack.time_s),
                                 std::to_string(stack.sums.frames),
                                 level < 0 ? "0" : "1",
                                 csv_number(stack.sums.share_low),
                                 csv_number(stack.sums.share_high),
                                 csv_number(stack.sums.mean),
                                 model(fitted.mean),
                                 model(fitted.mean_z),
                                 csv_number(squares.value[radiometry::kTvh]),
                                 csv_number(squares.dof(radiometry::kTvh)),
                                 model(fitted.variance),
                                 model(fitted.variance_z),
                                 model(fitted.light_error)};
    for (std::size_t part = 0; part < radiometry::kCubeParts; ++part) row.push_back(csv_number(squares.variance(part)));
    table.add(std::move(row));
  }
  return table.csv();
}

}  // namespace apps
