// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/scene.h"

#include <charconv>
#include <cmath>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/exr/spectral_exr.h"
#include "mtf/io/image_formats.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::array kQuantities{Quantity::radiance, Quantity::photon_radiance, Quantity::spectral_radiance,
                                 Quantity::temperature, Quantity::counts};

std::optional<std::array<double, 2>> two_numbers(const std::string& text) {
  std::array<double, 2> values{};
  const char* at = text.data();
  const char* end = text.data() + text.size();
  for (double& value : values) {
    while (at != end && (*at == ' ' || *at == ',' || *at == '(')) ++at;
    const auto [next, status] = std::from_chars(at, end, value);
    if (status != std::errc{}) return std::nullopt;
    at = next;
  }
  return values;
}

// A file holds metres; the decimal of 15 digits takes back what the change of unit rounded.
double um_from_m(double value_m) { return *cell_number(significant(value_m * 1e6, 15)); }

SampleGrid grid_of(const SensorConfig& config, const ImageFile& file, const std::string& path) {
  const SampleGrid size{file.info.width, file.info.height, 0.0, 0.0};
  const auto grid = [&](double x_um, double y_um, const std::string& whose) -> SampleGrid {
    if (!fits_aspect(file.info, x_um, y_um))
      throw UsageError(path + ": " + aspect_note(file.info) + ", but its samples are " + format_double(x_um) + " x " +
                       format_double(y_um) + " um by " + whose +
                       "; state sample_x and sample_y in that ratio, or correct what the file states");
    return {size.width, size.height, x_um, y_um};
  };
  if (const auto pitch = stated_pitch_um(file.info)) return grid((*pitch)[0], (*pitch)[1], "its mtf:pixelPitch");
  if (config.scene.sample_x_um && config.scene.sample_y_um)
    return grid(*config.scene.sample_x_um, *config.scene.sample_y_um, "[scene] of " + config.file);
  throw UsageError(path +
                   ": the sample spacing is not known; add sample = \"3.75 um\" (at the focal plane), or ifov, or gsd "
                   "and range, to [scene] of " +
                   config.file);
}

std::optional<Quantity> stated_quantity(const ImageFile& file, const std::string& path) {
  const auto found = file.info.attributes.find("mtf:quantity");
  if (found == file.info.attributes.end()) return std::nullopt;
  for (const Quantity quantity : kQuantities)
    if (quantity_name(quantity) == found->second) return quantity;
  // Radiance that is weighted by a response; those who take it look at the attributes for which.
  if (found->second == "weighted_radiance") return Quantity::radiance;
  if (found->second == "weighted_photon_radiance") return Quantity::photon_radiance;
  throw UsageError(
      path + ": holds " + printable(found->second, 40) +
      ", which is no scene: a scene is radiance, photon_radiance, spectral_radiance, temperature or counts");
}

bool is_weighted(const ImageFile& file) {
  const auto found = file.info.attributes.find("mtf:quantity");
  return found != file.info.attributes.end() && found->second.starts_with("weighted_");
}

/// What a PNG or TIFF says of its values: value = gain x file + offset. Nothing where it says 1 and 0.
std::optional<IntegerScaling> stated_scaling(const FileInfo& info) {
  const auto number = [&](const char* name, double missing) {
    const auto found = info.attributes.find(name);
    return info.format == Format::exr || found == info.attributes.end() ? missing
                                                                        : cell_number(found->second).value_or(missing);
  };
  const IntegerScaling scaling{number("gain", 1.0), number("offset", 0.0)};
  if (scaling.gain == 1.0 && scaling.offset == 0.0) return std::nullopt;
  return scaling;
}

std::string words_of(const IntegerScaling& scaling) {
  return "gain = " + format_double(scaling.gain) + " and offset = " + format_double(scaling.offset);
}

/// Keys of [scene] that this file needs and the sensor file lacks, as one error.
void require_keys(const SensorConfig& config, const std::string& path, const ImageFile& file, bool quantity_stated,
                  bool unit_stated) {
  const SceneDefaults& defaults = config.scene;
  const bool float_exr = file.info.format == Format::exr && !file.integer;
  std::string missing;
  const auto need = [&](bool there, const char* key) {
    if (!there) missing += (missing.empty() ? "" : ", ") + std::string(key);
  };
  const std::optional<IntegerScaling> says = stated_scaling(file.info);
  if (file.integer || says || !unit_stated)
    need(defaults.gain.has_value(), "gain"), need(defaults.offset.has_value(), "offset");
  if (!float_exr) need(quantity_stated || defaults.quantity, "quantity");
  std::string text;
  if (!missing.empty())
    text = (file.integer ? "integer samples" : "samples of " + std::string(row_of(file.info.format).name)) +
           " carry no physical unit; add " + missing + " to [scene] of " + config.file +
           " (value = gain x file + offset, in the unit of quantity" +
           (says ? "; the file says " + words_of(*says) : "") + ")";
  const StatedEncoding& stated = file.info.encoding;
  if (!defaults.encoding && !stated.source.empty() && stated.word != "linear")
    text += (text.empty() ? "" : "; ") + stated.source + ": the values need not be proportional to light; add " +
            (stated.word.empty() ? "encoding with their curve (srgb, gamma:2.2 or a CSV file)"
                                 : "encoding = \"" + stated.word + "\"") +
            " to [scene] of " + config.file +
            " to undo the curve before gain and offset, or encoding = \"linear\" to take them as they are";
  if (!text.empty()) throw UsageError(path + ": " + text);
}

/// [scene] takes precedence over the file; differences go to `warnings`.
ChosenEncoding encoding_of(const SensorConfig& config, const std::string& path, const ImageFile& file,
                           std::vector<std::string>& warnings) {
  const std::optional<Encoding>& given = config.scene.encoding;
  const StatedEncoding& stated = file.info.encoding;
  if (file.info.format == Format::exr) {
    if (given && given->kind != Encoding::Kind::linear)
      warnings.push_back(path + ": OpenEXR is linear by definition; encoding of [scene] is for PNG and TIFF");
    return {{}, "OpenEXR"};
  }
  if (!given) return {{}, stated.word.empty() ? "assumed" : stated.source};
  const std::string word = given->name == "gamma" ? "gamma:2.2" : given->name;
  if (!stated.word.empty() && stated.word != word)
    warnings.push_back(path + " says " + stated.word + " (" + stated.source + "), encoding of [scene] says " +
                       given->name + "; [scene] wins");
  return {*given, "[scene]"};
}

/// "255 at column 3, row 4": the first stored value that a table does not cover; "" where it covers all.
std::string first_outside(const Encoding& encoding, ImageView<const float> image) {
  if (encoding.kind != Encoding::Kind::table) return {};
  const double low = encoding.stored.front(), high = encoding.stored.back();
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x)
      if (const double stored = image.at(x, y); stored < low || stored > high)
        return format_double(stored) + " at column " + std::to_string(x) + ", row " + std::to_string(y);
  return {};
}

}  // namespace

std::optional<std::array<double, 2>> stated_pitch_um(const FileInfo& info) {
  const auto found = info.attributes.find("mtf:pixelPitch");
  if (found == info.attributes.end()) return std::nullopt;
  const auto pitch_m = two_numbers(found->second);
  if (!pitch_m || !((*pitch_m)[0] > 0.0 && (*pitch_m)[1] > 0.0)) return std::nullopt;
  return std::array{um_from_m((*pitch_m)[0]), um_from_m((*pitch_m)[1])};
}

bool fits_aspect(const FileInfo& info, double step_x, double step_y) {
  constexpr double kRounding = 1e-3;  // of both
  return info.pixel_aspect == 1.0 || std::abs(step_x / step_y / info.pixel_aspect - 1.0) <= kRounding;
}

std::string aspect_note(const FileInfo& info) {
  if (info.pixel_aspect == 1.0) return "";
  return "its pixels are " + significant(info.pixel_aspect, 5) + " times as wide as they are high, as it states";
}

std::int64_t make_physical(const Scene& scene, ImageView<float> image) {
  const std::int64_t outside = decode(scene.encoding.encoding, image, full_scale(scene.info));
  const double gain = scene.scaling.gain, offset = scene.scaling.offset;
  if (gain == 1.0 && offset == 0.0) return outside;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      const float stored =
          std::exchange(image.at(x, y), static_cast<float>(gain * static_cast<double>(image.at(x, y)) + offset));
      if (std::isinf(image.at(x, y)) && std::isfinite(stored))
        throw UsageError(words_of(scene.scaling) + " of [scene] take the stored value " +
                         format_double(static_cast<double>(stored)) + " at column " + std::to_string(x) + ", row " +
                         std::to_string(y) + " beyond 3.4e38, the largest of float32; correct them");
    }
  return outside;
}

Scene describe_scene(const SensorConfig& config, const std::string& path, const ImageFile& file) {
  const SceneDefaults& defaults = config.scene;
  Scene scene;
  scene.grid = grid_of(config, file, path);
  const std::optional<SpectralPlanes> spectral =
      spectral_planes(path, file, defaults.quantity == Quantity::spectral_radiance);
  const std::optional<Quantity> stated = spectral ? Quantity::spectral_radiance : stated_quantity(file, path);
  // For spectra in OpenEXR there is a unit by convention.
  require_keys(config, path, file, stated.has_value(),
               !spectral || spectral->stated || file.info.format == Format::exr);
  scene.encoding = encoding_of(config, path, file, scene.warnings);
  if (!stated && !defaults.quantity)
    scene.warnings.push_back("quantity is not stated in " + path + " nor in [scene]; taken as radiance (W m-2 sr-1)");
  // Weighted radiance is a picture made for one sensor: nothing that [scene] says of other images belongs to it.
  if (stated && defaults.quantity && *stated != *defaults.quantity && !is_weighted(file))
    scene.warnings.push_back(path +
                             (spectral ? " is spectral radiance by the names of its channels"
                                       : " says quantity " + std::string(quantity_name(*stated))) +
                             ", [scene] says " + std::string(quantity_name(*defaults.quantity)) + "; the file wins");
  scene.quantity = stated ? *stated : defaults.quantity.value_or(Quantity::radiance);
  if (file.missing_pixels > 0)
    scene.warnings.push_back(path + ": " + std::to_string(file.missing_pixels) +
                             " pixels of the display window lie outside the data window and are 0");
  if (spectral) {
    scene.wavelength_um = spectral->wavelength_um;
    scene.warnings.insert(scene.warnings.end(), spectral->warnings.begin(), spectral->warnings.end());
  }
  // A spectrum without units is what [scene] makes of it, and only then an assumption.
  const bool of_scene = !stated || file.integer || (spectral && !spectral->stated && defaults.gain);
  if (of_scene)
    scene.scaling = {defaults.gain.value_or(1.0), defaults.offset.value_or(0.0)};
  else if (spectral)
    scene.scaling = {spectral->factor, 0.0};
  if (!of_scene && spectral && !spectral->stated)
    scene.warnings.push_back(path + " does not state emissiveUnits; taken as W m-2 sr-1 nm-1" +
                             (defaults.offset ? "; offset of [scene] needs a gain beside it and is not used" : ""));
  else if (!of_scene && (defaults.gain || defaults.offset))
    scene.warnings.push_back(path + " states " + (spectral ? "its units" : "its own quantity") +
                             "; gain and offset of [scene] are for files that do not");
  if (const auto says = stated_scaling(file.info);
      says && (says->gain != scene.scaling.gain || says->offset != scene.scaling.offset))
    scene.warnings.push_back(path + " says " + words_of(*says) + ", [scene] says " + words_of(scene.scaling) +
                             "; [scene] wins");
  for (const std::string& note : file.info.notes) scene.warnings.push_back(path + ": " + note);
  const auto& [width, height, step_x, step_y] = scene.grid;
  if (defaults.sample_x_um && (*defaults.sample_x_um != step_x || *defaults.sample_y_um != step_y))
    scene.warnings.push_back(path + " states samples of " + format_double(step_x) + " x " + format_double(step_y) +
                             " um, [scene] says " + format_double(*defaults.sample_x_um) + " x " +
                             format_double(*defaults.sample_y_um) + " um; the file wins");
  scene.names = file.names;
  scene.info = file.info;
  return scene;
}

Scene load_scene(const SensorConfig& config, const std::string& path, const ReadOptions& options) {
  return physical_scene(config, path, read_image(path, options));
}

Scene physical_scene(const SensorConfig& config, const std::string& path, ImageFile file) {
  Scene scene = describe_scene(config, path, file);
  scene.planes = std::move(file.planes);
  std::int64_t outside = 0;
  std::string first;
  for (std::size_t c = 0; c < scene.planes.size(); ++c) {
    const Image& plane = scene.planes[c];
    if (first.empty()) first = first_outside(scene.encoding.encoding, plane.view());
    outside += make_physical(scene, scene.planes[c].view());
  }
  if (outside == 0) return scene;
  const Encoding& table = scene.encoding.encoding;
  scene.undecoded = path + ": " + std::to_string(outside) + " samples lie outside the encoding table " +
                    printable(table.name) + ", which goes from " + format_double(table.stored.front()) + " to " +
                    format_double(table.stored.back()) + "; the first is " + first;
  scene.warnings.push_back(scene.undecoded);
  return scene;
}

void require_decoded(const Scene& scene) {
  if (scene.undecoded.empty()) return;
  throw UsageError(scene.undecoded + ": extend the table to what the file stores, or take another encoding in [scene]");
}

SceneAperture scene_aperture(const SceneDefaults& defaults, const SampleGrid& grid) {
  SceneAperture aperture;
  aperture.kind = static_cast<SceneAperture::Kind>(defaults.aperture);
  aperture.size = defaults.aperture_size;
  if (aperture.kind == SceneAperture::Kind::box && !aperture.size.given())
    aperture.size = {{grid.step_x_um, find_unit("um")}, {grid.step_y_um, find_unit("um")}, true};
  aperture.curve = defaults.aperture_curve;
  aperture.gain_limit = defaults.aperture_gain_limit;
  return aperture;
}

std::vector<std::string> sampling_warnings(const System<double>& system, const SampleGrid& grid) {
  std::vector<std::string> warnings;
  for (const Axis axis : {Axis::x, Axis::y}) {
    const double step = axis == Axis::x ? grid.step_x_um : grid.step_y_um;
    const double ratio = system.frame.pitch_um(axis) / step;
    if (ratio >= 2.0 * (1.0 - 1e-9)) continue;
    warnings.push_back("the scene has " + significant(ratio, 3) + " samples per pitch along " +
                       (axis == Axis::x ? "x" : "y") + ": it holds nothing above " + significant(500.0 / step, 4) +
                       " cy/mm, so aliasing of finer detail (up to the optics' cutoff) is missing; use 2 or more, "
                       "better 4");
  }
  return warnings;
}

}  // namespace mtf::io
