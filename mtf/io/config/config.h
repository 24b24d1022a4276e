// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sensor files (TOML) to System and back. The file: mtf config init; every component table is read and
// written through the field tables of mtf/component.h, so a new component needs nothing here.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/border.h"
#include "mtf/io/codecs/encoding.h"
#include "mtf/settings.h"
#include "mtf/system.h"

namespace mtf::io {

enum class Quantity { radiance, photon_radiance, spectral_radiance, temperature, counts };
enum class Aperture { point, box, gaussian, curve };

std::string_view quantity_name(Quantity quantity);
/// Unit of a quantity as written into files: "W.m^-2.sr^-1", "ph.s^-1.m^-2.sr^-1", "W.m^-2.sr^-1.um^-1", "K", "counts".
std::string_view quantity_unit(Quantity quantity);

/// [scene]: what a scene file does not say itself.
struct SceneDefaults {
  std::optional<double> sample_x_um;  ///< scene sample spacing at the focal plane; from sample, ifov, or gsd + range
  std::optional<double> sample_y_um;
  std::optional<Quantity> quantity;
  std::optional<double> gain;  ///< value = gain x file + offset
  std::optional<double> offset;
  std::optional<Encoding> encoding;  ///< of PNG and TIFF values, undone before gain and offset
  Border border = Border::reflect;
  double border_value = 0.0;            ///< for border = "constant", in the scene's quantity
  Aperture aperture = Aperture::point;  ///< blur already in the samples, divided out
  AxisPair<double> aperture_size;       ///< box: full width (default one sample); gaussian: sigma
  std::shared_ptr<const Curve> aperture_curve;
  double aperture_gain_limit = 10.0;  ///< the division never amplifies more than this
};

/// Position of a key in the file, for messages made later. 1-based; 0 = not in the file.
struct Position {
  int line = 0;
  int column = 0;
};

/// A number written as a table { value, fit, min, max, prior, stderr, interval }; `path` is e.g. "presample[1].rms" or
/// "frame.focal_length". Numbers are in the unit that the System holds the value in: FieldInfo::unit of the field, or
/// the own unit of an Extent or SpatialFrequency, which is the one `value` was written in.
struct FitSpec {
  std::string path;
  bool fit = false;
  std::string unit{};  ///< that the numbers are in, "" for plain ones
  double value = 0.0;  ///< as the file has it
  std::optional<double> min, max, stderr_value;
  std::optional<std::array<double, 2>> prior{};     ///< mean, sd
  std::optional<std::array<double, 2>> interval{};  ///< ends of 95 %, of a number that may be 0, in place of stderr
  Position value_at{}, stderr_at{};                 ///< where the file has them

  /// Of the value: stderr, or what the width of the interval is of a normal number; 0 where neither is stated.
  double sd() const { return interval ? ((*interval)[1] - (*interval)[0]) / (2.0 * 1.96) : stderr_value.value_or(0.0); }
};

struct Diagnostic {
  bool error = true;
  Position position;
  std::string path;     ///< "presample[1].rms"
  std::string text;     ///< with what to write instead
  bool remark = false;  ///< not an error: shown as "note" instead of "warning"
};

struct SensorConfig {
  System<double> system;
  SceneDefaults scene;
  std::vector<FitSpec> fits;
  int version = kSensorVersion;       ///< the key `schema` of the file
  std::vector<TableInfo> schema;      ///< tables beyond those of the system that the reader knows
  std::vector<SettingsTable> tables;  ///< those of them that are in the file, in the order of the schema
  std::string file;                   ///< as given by the user
  std::string text;                   ///< the whole source
  std::string sha256;                 ///< of the source, 64 hex digits
  std::vector<std::string> files{};   ///< that the text names, beside `file`
};

struct ConfigResult {
  SensorConfig config;                  ///< usable only when there is no error
  std::vector<Diagnostic> diagnostics;  ///< sorted by position; all errors of the file in one pass, then notes
  bool ok() const;
};

/// Reads and checks; never throws for what is in the text. Names of files are relative to the folder of the
/// sensor file. `schema`: tables beyond those of the system (mtf/settings.h); other tables are errors.
ConfigResult parse_config(const std::string& text, const std::string& file, std::vector<TableInfo> schema = {});

/// Reads a file. Throws RuntimeError when it cannot be read, UsageError with every error as "file:line:col: error: …"
/// lines when it is wrong. Warnings go to `warnings` when given.
SensorConfig load_config(const std::string& file, std::vector<Diagnostic>* warnings = nullptr,
                         std::vector<TableInfo> schema = {});

/// "file:line:col: error: presample[1].rms: …", likewise "warning" and "note".
std::string format_diagnostic(const Diagnostic& diagnostic, const std::string& file);

/// TOML of a system, scene and fits; parse_config of it gives the same values bit for bit. `destination` is the file
/// the text is meant for (config.file when empty): curve files in or below its folder are named relative to it, others
/// by their absolute path. Labels that parse_config would choose itself are left out.
std::string write_config(const SensorConfig& config, const std::string& destination = {});

/// The text of the file with new values, `values[i]` of config.fits[i] in its unit, and the standard errors that the
/// fits hold now; all else as it was written. Fit tables that are not written in one piece (value and stderr as keys of
/// a [table]) may come out wrong: parse the text before use.
std::string splice_fits(const SensorConfig& config, std::span<const std::optional<double>> values);

/// The same for any file that has such tables. `toml`: a number as the file writes it, a value or its standard error.
std::string splice_numbers(std::string_view text, std::span<const FitSpec> fits,
                           std::span<const std::optional<double>> values,
                           const std::function<std::string(const FitSpec& fit, double number, bool is_error)>& toml);

/// A commented starter file (`mtf config init`): the MWIR sensor of the README, every table explained.
std::string starter_config();

/// What every number becomes after units and defaults (`mtf config explain`): a table of path, as written, resolved
/// value with unit, where it came from (file:line, [optics], default), and what follows (cutoff, Nyquist, Q, IFOV).
std::string explain_config(const SensorConfig& config);

}  // namespace mtf::io
