// SPDX-License-Identifier: Apache-2.0
#pragma once

// Field tables of the tables of a sensor file that are not components: the same rows as a component's, so that reading,
// writing and explaining use the same code. Ranges of [frame], [optics] and [band] are checked by System::check.

#include <array>
#include <span>
#include <string_view>

#include "mtf/component.h"
#include "mtf/components/field.h"

namespace mtf::io::cfg {

inline constexpr int kSchema = 1;
inline constexpr std::array<std::string_view, 9> kTopKeys{"schema", "name",      "frame",   "scene",     "optics",
                                                          "band",   "presample", "readout", "postsample"};

// [frame]
inline constexpr FieldInfo kFocalLength{.name = "focal_length",
                                        .dimension = Dimension::length,
                                        .unit = "mm",
                                        .example = "\"100 mm\"",
                                        .doc = "effective focal length; converts object angles to the focal plane"};
inline constexpr FieldInfo kPitch{.name = "pitch",
                                  .dimension = Dimension::length,
                                  .unit = "um",
                                  .example = "\"15 um\"",
                                  .doc = "centre to centre of the pixels"};
inline constexpr FieldInfo kIntegrationTime{.name = "integration_time",
                                            .dimension = Dimension::time,
                                            .unit = "s",
                                            .presence = Presence::optional,
                                            .example = "\"10 ms\"",
                                            .doc = "exposure of one frame"};

// [optics]
inline constexpr FieldInfo kFNumber = [] {
  FieldInfo info = kFNumberInfo;
  info.presence = Presence::optional;
  return info;
}();
inline constexpr FieldInfo kApertureDiameter{.name = "aperture",
                                             .dimension = Dimension::length,
                                             .unit = "mm",
                                             .presence = Presence::optional,
                                             .example = "\"50 mm\"",
                                             .doc = "entrance pupil diameter, instead of f_number"};
inline constexpr FieldInfo kObscuration{.name = "obscuration",
                                        .presence = Presence::optional,
                                        .example = "0.3",
                                        .doc = "central obscuration, inner / outer diameter"};
inline constexpr FieldInfo kWavelength{.name = "wavelength",
                                       .dimension = Dimension::length,
                                       .unit = "um",
                                       .presence = Presence::optional,
                                       .example = "\"4.0 um\"",
                                       .doc = "the one wavelength, when there is no [band]"};

// [scene]
inline constexpr FieldInfo kSample{.name = "sample",
                                   .dimension = Dimension::length,
                                   .unit = "um",
                                   .hi = 1e6,
                                   .lo_open = true,
                                   .presence = Presence::optional,
                                   .example = "\"3.75 um\"",
                                   .doc = "spacing of the scene's samples at the focal plane"};
inline constexpr FieldInfo kIfov{.name = "ifov",
                                 .dimension = Dimension::angle,
                                 .unit = "urad",
                                 .hi = 1e6,
                                 .lo_open = true,
                                 .presence = Presence::optional,
                                 .example = "\"37.5 urad\"",
                                 .doc = "spacing of the scene's samples as an object angle"};
inline constexpr FieldInfo kGsd{.name = "gsd",
                                .dimension = Dimension::length,
                                .unit = "m",
                                .hi = 1e9,
                                .lo_open = true,
                                .presence = Presence::optional,
                                .example = "\"0.2 m\"",
                                .doc = "spacing of the scene's samples in the object, with range"};
inline constexpr FieldInfo kRange{.name = "range",
                                  .dimension = Dimension::length,
                                  .unit = "m",
                                  .hi = 1e13,
                                  .lo_open = true,
                                  .presence = Presence::optional,
                                  .example = "\"5 km\"",
                                  .doc = "distance of the object, with gsd"};
inline constexpr FieldInfo kGain{.name = "gain",
                                 .lo = -1e300,
                                 .hi = 1e300,
                                 .presence = Presence::optional,
                                 .example = "1.0",
                                 .doc = "value = gain x file + offset"};
inline constexpr FieldInfo kOffset{.name = "offset",
                                   .lo = -1e300,
                                   .hi = 1e300,
                                   .presence = Presence::optional,
                                   .example = "0.0",
                                   .doc = "value = gain x file + offset"};
inline constexpr FieldInfo kBorderValue{.name = "border_value",
                                        .lo = -1e300,
                                        .hi = 1e300,
                                        .presence = Presence::optional,
                                        .example = "0.0",
                                        .doc = "value outside the scene for border = \"constant\""};
inline constexpr FieldInfo kApertureSize{
    .name = "aperture_size",
    .dimension = Dimension::extent,
    .hi = 1e9,
    .lo_open = true,
    .presence = Presence::optional,
    .example = "\"3.75 um\"",
    .doc = "blur already in the samples: full width of the box, sigma of the gaussian"};
inline constexpr FieldInfo kApertureGainLimit{.name = "aperture_gain_limit",
                                              .lo = 1.0,
                                              .hi = 1e6,
                                              .lo_open = true,
                                              .presence = Presence::optional,
                                              .example = "10.0",
                                              .doc = "dividing that blur out never amplifies more than this"};

inline constexpr std::array<std::string_view, 6> kFrameKeys{"focal_length", "pitch",  "pitch_x",
                                                            "pitch_y",      "format", "integration_time"};
inline constexpr std::array<std::string_view, 4> kOpticsKeys{"f_number", "aperture", "obscuration", "wavelength"};
inline constexpr std::array<std::string_view, 1> kBandKeys{"wavelength"};
inline constexpr std::array<std::string_view, 18> kSceneKeys{"sample",
                                                             "sample_x",
                                                             "sample_y",
                                                             "ifov",
                                                             "gsd",
                                                             "range",
                                                             "quantity",
                                                             "gain",
                                                             "offset",
                                                             "encoding",
                                                             "border",
                                                             "border_value",
                                                             "aperture",
                                                             "aperture_size",
                                                             "aperture_size_x",
                                                             "aperture_size_y",
                                                             "aperture_file",
                                                             "aperture_gain_limit"};

inline constexpr std::array<std::string_view, 5> kQuantityNames{"radiance", "photon_radiance", "spectral_radiance",
                                                                "temperature", "counts"};
inline constexpr std::array<std::string_view, 4> kApertureNames{"point", "box", "gaussian", "curve"};

}  // namespace mtf::io::cfg
