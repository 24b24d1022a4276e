// SPDX-License-Identifier: Apache-2.0
#pragma once

// The tables of a sensor file that are not components: the same rows as a component's, so that reading, writing,
// explaining and describing use the same code. Ranges of [frame], [optics] and [band] are checked by System::check.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/border.h"
#include "mtf/components/field.h"
#include "mtf/settings.h"

namespace mtf::io::cfg {

inline constexpr std::array<std::string_view, 9> kTopKeys{"schema", "name",      "frame",   "scene",     "optics",
                                                          "band",   "presample", "readout", "postsample"};
inline constexpr std::array<std::string_view, 5> kQuantityNames{"radiance", "photon_radiance", "spectral_radiance",
                                                                "temperature", "counts"};
inline constexpr std::array<std::string_view, 4> kApertureNames{"point", "box", "gaussian", "curve"};

/// A length that System::check bounds.
constexpr FieldInfo length(std::string_view name, std::string_view unit, std::string_view example,
                           std::string_view doc) {
  return optional_row(name, Dimension::length, unit, 0.0, 0.0, example, doc);
}

// [frame]
inline constexpr FieldInfo kFocalLength = required(
    length("focal_length", "mm", "\"100 mm\"", "effective focal length; converts object angles to the focal plane"));
inline constexpr FieldInfo kPitch =
    of_type(FieldType::size, required(length("pitch", "um", "\"15 um\"", "centre to centre of the pixels")));
inline constexpr FieldInfo kFormat = of_type(
    FieldType::pair, optional_row("format", 1.0, 1e6, "[640, 512]", "columns and rows, the largest size of an image"));
inline constexpr FieldInfo kIntegrationTime =
    optional_row("integration_time", "s", 0.0, 0.0, "\"10 ms\"", "exposure of one frame");

// [optics]
inline constexpr FieldInfo kFNumber = excluding("aperture", optional(kFNumberInfo));
inline constexpr FieldInfo kApertureDiameter =
    excluding("f_number", length("aperture", "mm", "\"50 mm\"", "entrance pupil diameter, instead of f_number"));
inline constexpr FieldInfo kObscuration =
    optional_row("obscuration", "0.3", "central obscuration, inner / outer diameter");
inline constexpr FieldInfo kWavelength =
    length("wavelength", "um", "\"4.0 um\"", "the one wavelength, when there is no [band]");

// [band]
inline constexpr FieldInfo kBand =
    of_type(FieldType::pair, required(length("wavelength", "um", "[\"3.4 um\", \"4.8 um\"]", "shortest and longest")));

// [scene]
inline constexpr FieldInfo kSample = of_type(
    FieldType::size, excluding("ifov gsd", above(optional_row("sample", "um", 0.0, 1e6, "\"3.75 um\"",
                                                              "spacing of the scene's samples at the focal plane"))));
inline constexpr FieldInfo kIfov =
    excluding("sample gsd", above(optional_row("ifov", "urad", 0.0, 1e6, "\"37.5 urad\"",
                                               "spacing of the scene's samples as an object angle")));
inline constexpr FieldInfo kGsd = excluding(
    "sample ifov",
    above(optional_row("gsd", "m", 0.0, 1e9, "\"0.2 m\"", "spacing of the scene's samples in the object, with range")));
inline constexpr FieldInfo kRange =
    above(optional_row("range", "m", 0.0, 1e13, "\"5 km\"", "distance of the object, with gsd"));
inline constexpr FieldInfo kQuantity =
    of_type(FieldType::word, optional_row("quantity", "\"radiance\"", "what the values are"), kQuantityNames);
inline constexpr FieldInfo kGain = optional_row("gain", -1e300, 1e300, "1.0", "value = gain x file + offset");
inline constexpr FieldInfo kOffset = optional_row("offset", -1e300, 1e300, "0.0", "value = gain x file + offset");
inline constexpr FieldInfo kEncoding = of_type(
    FieldType::text,
    optional_row("encoding", "\"linear\"", "of PNG and TIFF: linear, srgb, gamma, gamma:1.8 or the file of a table"));
inline constexpr FieldInfo kBorder = of_type(
    FieldType::word, optional_row("border", "\"reflect\"", "how the scene goes on beyond its edge"), kBorderNames);
inline constexpr FieldInfo kBorderValue =
    optional_row("border_value", -1e300, 1e300, "0.0", "value outside the scene for border = \"constant\"");
inline constexpr FieldInfo kAperture =
    of_type(FieldType::word, optional_row("aperture", "\"box\"", "blur already in the samples, which is divided out"),
            kApertureNames);
inline constexpr FieldInfo kApertureSize = of_type(
    FieldType::size, above(optional_row("aperture_size", Dimension::extent, "", 0.0, 1e9, "\"3.75 um\"",
                                        "blur already in the samples: full width of the box, sigma of the gaussian")));
inline constexpr FieldInfo kApertureFile =
    of_type(FieldType::file, optional_row("aperture_file", "\"scene.csv\"", "CSV file of that blur's curve"));
inline constexpr FieldInfo kApertureGainLimit = above(
    optional_row("aperture_gain_limit", 1.0, 1e6, "10.0", "dividing that blur out never amplifies more than this"));

/// [frame], [scene], [optics] and [band], in this order.
const std::vector<TableInfo>& own_tables();
/// The rows of one of them.
const std::vector<FieldInfo>& own_rows(std::string_view table);

/// How a row may be written: "pitch"; for both axes also "pitch_x" and "pitch_y".
std::vector<std::string> keys_of(const FieldInfo& row);

}  // namespace mtf::io::cfg
