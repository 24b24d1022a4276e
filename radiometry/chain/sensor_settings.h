// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a sensor file says of everything but the OTF: one value type for each of its tables. Stages run in the order of
// their rows in chain/steps; one whose table is missing is left out. The signal of a thermal detector is in volts: its
// tables have volts where those of a photon detector have electrons, in the same members, whose names end in _e.

#include <optional>
#include <vector>

#include "radiometry/atmosphere/atmosphere_settings.h"
#include "radiometry/chain/thermal_settings.h"
#include "radiometry/light/raw_counts.h"
#include "radiometry/light/scene_radiance.h"
#include "radiometry/light/signal.h"
#include "radiometry/light/spectral_signal.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/detector/blooming.h"
#include "radiometry/stages/detector/lag.h"
#include "radiometry/stages/detector/microscan.h"
#include "radiometry/stages/detector/nonlinearity.h"
#include "radiometry/stages/detector/shutter.h"
#include "radiometry/stages/noise/blinking.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/flicker.h"
#include "radiometry/stages/noise/frame_flicker.h"
#include "radiometry/stages/noise/noise_3d.h"
#include "radiometry/stages/optics/distortion.h"
#include "radiometry/stages/optics/narcissus.h"
#include "radiometry/stages/optics/veiling_glare.h"
#include "radiometry/stages/optics/vignetting.h"
#include "radiometry/stages/processing/agc.h"
#include "radiometry/stages/processing/correction.h"

namespace radiometry {

/// The largest temperature that a sensor file may give.
inline constexpr double kMostTemperature_k = 1e9;

/// Rows added to [frame].
struct FrameSettings {
  std::optional<double> frame_time_s{};  ///< from a frame to the next; else the integration time

  static constexpr auto fields() {
    return std::tuple{optional(&FrameSettings::frame_time_s, "frame_time", "s", 1e-12, 1e9, "\"20 ms\"",
                               "from one frame of a sequence to the next; else the integration time")};
  }
};

/// Rows added to [scene]: what its values stand for.
struct SceneSettings {
  NumberOrFile emissivity{1.0};
  std::optional<double> surroundings_k{};  ///< reflected by what does not emit
  std::optional<double>
      source_temperature_k{};  ///< whose spectrum a scene given in a band has; else constant in photons
  ChannelName emissivity_channel{}, depth_channel{};
  Negative negative = Negative::refuse;

  static constexpr auto fields() {
    return std::tuple{
        optional(&SceneSettings::emissivity, "emissivity", 0.0, 1.0, "0.95",
                 "emissivity of a scene in K: a number or the CSV file of a curve"),
        optional(&SceneSettings::surroundings_k, "surroundings", "K", 0.0, kMostTemperature_k, "\"293 K\"",
                 "what a scene in K reflects where it does not emit"),
        optional(&SceneSettings::source_temperature_k, "source_temperature", "K", 0.0, kMostTemperature_k, "\"300 K\"",
                 "whose spectrum a radiance in the band has; else even in photons"),
        optional(&SceneSettings::emissivity_channel, "emissivity_channel", "\"emissivity\"",
                 "channel of the scene with the emissivity of each pixel"),
        optional(&SceneSettings::depth_channel, "depth_channel", "\"Z\"",
                 "channel of the scene with the range of each pixel in m"),
        optional(&SceneSettings::negative, "negative", "\"clamp\"", "values below 0: refuse, or clamp to 0")};
  }
};

/// The path between scene and aperture: numbers, curves of the wavelength, or a table over the range.
struct PathSettings {
  NumberOrFile transmission{1.0};
  NumberOrFile radiance{0.0};                 ///< W m^-2 sr^-1 um^-1
  std::optional<double> air_temperature_k{};  ///< of air that only absorbs: it emits what it takes
  std::string table{};                        ///< over range and wavelength
  std::optional<double> range_m{};            ///< of the whole scene

  static constexpr auto fields() {
    return std::tuple{optional(&PathSettings::transmission, "transmission", 0.0, 1.0, "0.8",
                               "of the path: a number or the CSV file of a curve"),
                      optional(&PathSettings::radiance, "radiance", 0.0, 1e30, "0.02",
                               "of the path, W m^-2 sr^-1 um^-1: a number or the CSV file of a curve"),
                      optional(&PathSettings::air_temperature_k, "air_temperature", "K", 0.0, kMostTemperature_k,
                               "\"288 K\"", "of air that absorbs: it emits 1 - transmission of a blackbody"),
                      optional(&PathSettings::table, "table", "\"path.csv\"",
                               "CSV file of transmission and radiance over range and wavelength, or a tape7"),
                      optional(&PathSettings::range_m, "range", "m", 0.0, 1e9, "\"2 km\"",
                               "of the whole scene, where its table has several")};
  }
};

/// Rows added to [optics].
struct OpticsSettings {
  NumberOrFile transmission{1.0};
  NumberOrFile cold_transmission{1.0};  ///< of what lies between cold stop and detector
  double emissivity = 0.0;              ///< of the warm optics
  double obscuration_emissivity = 0.0;
  double temperature_k = 0.0;
  double stop_emissivity = 1.0;
  double stop_temperature_k = 0.0;
  StopBand stop_band = StopBand::band;
  Cone cone = Cone::tangent;

  static constexpr auto fields() {
    return std::tuple{
        optional(&OpticsSettings::transmission, "transmission", 0.0, 1.0, "0.85",
                 "of the warm optics: a number or the CSV file of a curve"),
        optional(&OpticsSettings::cold_transmission, "cold_transmission", 0.0, 1.0, "0.9",
                 "of the cold filter: a number or the CSV file of a curve"),
        optional(&OpticsSettings::emissivity, "emissivity", 0.0, 1.0, "0.1", "of the warm optics"),
        optional(&OpticsSettings::obscuration_emissivity, "obscuration_emissivity", 0.0, 1.0, "0.9",
                 "of the back of the obscuration"),
        optional(&OpticsSettings::temperature_k, "temperature", "K", 0.0, kMostTemperature_k, "\"293 K\"",
                 "of the warm optics; without it they do not glow"),
        optional(&OpticsSettings::stop_emissivity, "stop_emissivity", 0.0, 1.0, "1.0",
                 "of what surrounds the cone of light"),
        optional(&OpticsSettings::stop_temperature_k, "stop_temperature", "K", 0.0, kMostTemperature_k, "\"77 K\"",
                 "of what surrounds the cone of light"),
        optional(&OpticsSettings::stop_band, "stop_band", "\"response\"",
                 "where its emission counts: in the band (band), or over the whole curve of the quantum efficiency "
                 "(response)"),
        optional(&OpticsSettings::cone, "cone", "\"sine\"",
                 "half angle of the cone of light: its tangent is 1/(2 N) (cold stop), or its sine (aplanat)")};
  }
};

/// Whether a width alone in [detector] is that of a square; in older files the height is the pitch then.
inline bool width_is_square(const mtf::SettingsTable& detector) { return detector.version >= 2; }

struct DetectorSettings {
  DetectorKind kind = DetectorKind::photon;
  std::optional<double> width_um{}, height_um{};  ///< of the active area; neither: the pitch
  bool square = true;                             ///< width_is_square
  NumberOrFile quantum_efficiency{1.0};
  double full_well_e = std::numeric_limits<double>::infinity();
  double dark_e_s = 0.0;
  double read_e = 0.0;
  double reset_e = 0.0;
  double other_e = 0.0;
  std::optional<double> capacitance_f{}, temperature_k{};  ///< that are reset, in place of reset_e

  static constexpr auto fields() {
    using T = DetectorSettings;
    return std::tuple{optional(&T::kind, "kind", "\"photon\"", "photon: electrons; thermal: a pixel that warms"),
                      optional(&T::width_um, "width", "um", 1e-3, 1e6, "\"14 um\"",
                               "of the active area, alone that of a square; else the pitch"),
                      optional(&T::height_um, "height", "um", 1e-3, 1e6, "\"14 um\"",
                               "of the active area; with width alone the same, with neither the pitch"),
                      optional(&T::quantum_efficiency, "quantum_efficiency", 0.0, 1.0, "0.75",
                               "electrons per photon: a number or the CSV file of a curve"),
                      optional(&T::full_well_e, "full_well", "e-", 1e-3, mtf::kInfinity, "\"7 Me-\"",
                               "electrons that a pixel can hold"),
                      optional(&T::dark_e_s, "dark_current", "e-/s", 0.0, 1e30, "\"1e5 e-/s\"", "of a pixel"),
                      optional(&T::read_e, "read_noise", "e-", 0.0, 1e15, "\"300 e-\"", "rms"),
                      optional(&T::reset_e, "reset_noise", "e-", 0.0, 1e15, "\"100 e-\"", "kTC noise, rms"),
                      optional(&T::other_e, "other_noise", "e-", 0.0, 1e15, "\"50 e-\"", "further temporal noise, rms"),
                      optional(&T::capacitance_f, "capacitance", "F", 0.0, 1.0, "\"100 fF\"",
                               "that is reset, in place of reset_noise"),
                      optional(&T::temperature_k, "temperature", "K", 0.0, 1e6, "\"77 K\"", "of that capacitance")};
  }
};

/// Rms of the reset noise, as given or of what is reset.
inline double reset_e_of(const DetectorSettings& detector) {
  return detector.capacitance_f && detector.temperature_k
             ? ResetNoise{*detector.capacitance_f, *detector.temperature_k}.rms_e()
             : detector.reset_e;
}

struct NonuniformitySettings {
  double prnu = 0.0, prnu_row = 0.0, prnu_column = 0.0;
  double dsnu_e = 0.0;
  double dcnu = 0.0;
  std::string responsivity{};  ///< map of factors
  std::string offset{};        ///< map of offsets

  static constexpr auto fields() {
    using T = NonuniformitySettings;
    return std::tuple{
        optional(&T::prnu, "prnu", 0.0, 1.0, "0.01", "responsivity from pixel to pixel, rms fraction"),
        optional(&T::prnu_row, "prnu_row", 0.0, 1.0, "0.002", "responsivity of whole rows, rms fraction"),
        optional(&T::prnu_column, "prnu_column", 0.0, 1.0, "0.002", "responsivity of whole columns, rms fraction"),
        optional(&T::dsnu_e, "dsnu", "e-", 0.0, 1e15, "\"200 e-\"", "offset from pixel to pixel, rms"),
        optional(&T::dcnu, "dcnu", 0.0, 10.0, "0.2", "dark current from pixel to pixel, rms fraction"),
        optional(&T::responsivity, "responsivity", "\"gain.exr\"", "map of factors in place of all prnu"),
        optional(&T::offset, "offset", "\"offset.exr\"",
                 "map of offsets in place of dsnu, in electrons or volts as that")};
  }

  bool has_prnu() const { return prnu > 0.0 || prnu_row > 0.0 || prnu_column > 0.0; }

  bool operator==(const NonuniformitySettings&) const = default;
};

struct NoiseSettings {
  int seed = 0;
  bool shot = true;
  double row_e = 0.0, column_e = 0.0, fixed_row_e = 0.0, fixed_column_e = 0.0;

  static constexpr auto fields() {
    return std::tuple{
        optional(&NoiseSettings::seed, "seed", 0.0, 2147483647.0, "1", "of all random numbers"),
        optional(&NoiseSettings::shot, "shot", "true", "shot noise of light and dark current"),
        optional(&NoiseSettings::row_e, "row", "e-", 0.0, 1e15, "\"20 e-\"", "of whole rows, new in every frame, rms"),
        optional(&NoiseSettings::column_e, "column", "e-", 0.0, 1e15, "\"20 e-\"",
                 "of whole columns, new in every frame, rms"),
        optional(&NoiseSettings::fixed_row_e, "fixed_row", "e-", 0.0, 1e15, "\"20 e-\"",
                 "of whole rows, the same in all frames, rms"),
        optional(&NoiseSettings::fixed_column_e, "fixed_column", "e-", 0.0, 1e15, "\"20 e-\"",
                 "of whole columns, the same in all frames, rms")};
  }
};

struct AdcSettings {
  int bits = 14;
  std::optional<double> electrons_per_count{};  ///< else the full well fills the range
  double offset_counts = 0.0;
  Rounding rounding = Rounding::nearest;

  static constexpr auto fields() {
    return std::tuple{required(&AdcSettings::bits, "bits", 1, 32, "14", "bits of a count"),
                      optional(&AdcSettings::electrons_per_count, "electrons_per_count", "e-", 1e-30, 1e30,
                               "\"420 e-\"", "else the full well fills the range"),
                      optional(&AdcSettings::offset_counts, "offset", -1e10, 1e10, "200.0", "counts without signal"),
                      optional(&AdcSettings::rounding, "rounding", "\"down\"", "nearest (halves upwards), or down")};
  }
};

struct SensorSettings;

/// A table of a sensor file: its name, what it is about, and where its values are kept.
template <class T>
struct SensorTable {
  std::string_view name, doc;
  std::optional<T> SensorSettings::*values;
};

/// A table is its member and its row in tables().
struct SensorSettings {
  std::optional<FrameSettings> frame;
  std::optional<SceneSettings> scene;
  std::optional<CountCamera> counts;
  std::optional<PathSettings> path;
  std::optional<AtmosphereSettings> atmosphere;  ///< in place of path
  std::optional<OpticsSettings> optics;
  std::optional<OpticalAxis> axis;
  std::optional<Distortion> distortion;
  std::optional<VeilingGlare> glare;
  std::optional<Ghost> ghost;
  std::optional<Vignetting> vignetting;
  std::optional<Narcissus> narcissus;
  std::optional<DetectorSettings> detector;
  std::optional<ThermalSettings> thermal;  ///< beside detector = pixel_settings(thermal)
  std::optional<Microscan> microscan;
  std::optional<Shutter> shutter;
  std::optional<Lag> lag;
  std::optional<NonuniformitySettings> nonuniformity;
  std::optional<Defects> defects;
  std::optional<Blinking> blinking;
  std::optional<Blooming> blooming;
  std::optional<NoiseSettings> noise;
  std::optional<Flicker> flicker;
  std::optional<FlickerOctaves> frame_flicker;
  std::optional<Noise3d> noise_3d;
  std::optional<Nonlinearity> nonlinearity;
  std::optional<AdcSettings> adc;
  std::optional<CorrectionSettings> correction;
  std::optional<AutomaticGain> agc;

  /// Reading, schema, `config kinds`, the live page and tests follow from these rows.
  static constexpr auto tables() {
    return std::tuple{
        SensorTable{"frame", "time from frame to frame", &SensorSettings::frame},
        SensorTable{"scene", "what the values of a scene stand for", &SensorSettings::scene},
        SensorTable{"camera_counts", "the camera that wrote a scene of raw counts", &SensorSettings::counts},
        SensorTable{"path", "what lies between scene and aperture", &SensorSettings::path},
        SensorTable{"atmosphere", "the air between scene and aperture, by a band model; in place of [path]",
                    &SensorSettings::atmosphere},
        SensorTable{"optics", "what the optics let through and emit", &SensorSettings::optics},
        SensorTable{"optical_axis", "where the optical axis meets the detector", &SensorSettings::axis},
        SensorTable{"distortion", "radial distortion of the scene", &SensorSettings::distortion},
        SensorTable{"veiling_glare", "light scattered over the whole image", &SensorSettings::glare},
        SensorTable{"ghost", "the image mirrored through the axis", &SensorSettings::ghost},
        SensorTable{"vignetting", "fall of the light towards the corners", &SensorSettings::vignetting},
        SensorTable{"narcissus", "the detector's own cold in the background", &SensorSettings::narcissus},
        SensorTable{"detector", "from photons to electrons", &SensorSettings::detector},
        SensorTable{"microscan", "frames between the pixels, put together", &SensorSettings::microscan},
        SensorTable{"shutter", "when the rows of a frame are exposed", &SensorSettings::shutter},
        SensorTable{"lag", "time constant of a bolometer over a sequence", &SensorSettings::lag},
        SensorTable{"nonuniformity", "what differs from pixel to pixel", &SensorSettings::nonuniformity},
        SensorTable{"defects", "dead and hot pixels", &SensorSettings::defects},
        SensorTable{"blinking", "pixels that come and go", &SensorSettings::blinking},
        SensorTable{"blooming", "where charge above the full well goes", &SensorSettings::blooming},
        SensorTable{"noise", "seed, shot noise, noise of rows and columns", &SensorSettings::noise},
        SensorTable{"flicker", "1/f noise of the readout", &SensorSettings::flicker},
        SensorTable{"frame_flicker", "1/f noise of every pixel from frame to frame", &SensorSettings::frame_flicker},
        SensorTable{"noise_3d", "the seven components of 3-D noise", &SensorSettings::noise_3d},
        SensorTable{"nonlinearity", "response that is not proportional to the charge", &SensorSettings::nonlinearity},
        SensorTable{"adc", "from electrons to counts", &SensorSettings::adc},
        SensorTable{"correction", "two-point correction and replacement of bad pixels", &SensorSettings::correction},
        SensorTable{"agc", "from counts to display levels", &SensorSettings::agc}};
  }
};

/// Calls visit(table) for every SensorTable.
template <class Visit>
void for_each_table(Visit visit) {
  std::apply([&](const auto&... table) { (visit(table), ...); }, SensorSettings::tables());
}

/// What a thermal detector has in common with a photon detector: active area and, as quantum efficiency, absorptance.
DetectorSettings pixel_settings(const ThermalSettings& thermal, bool square = true);

/// What the detector answers to. This alone decides whether a sensor is a thermal one: its curves
/// (SpectralCamera::flux) and its pixel (Pixel::flux) take it from here.
inline Flux flux_of(const SensorSettings& settings) { return settings.thermal ? Flux::watts : Flux::photons; }

/// What [optics] and [detector] say of the camera's own emission.
CameraEmission emission_of(const SensorSettings& settings);

/// Of a thermal camera with frame_time whose shutter closes now and then.
ShutterEvents shutter_events(const SensorSettings& settings);

/// The tables that a sensor file may hold, for mtf::io::load_config. Those of a thermal detector have a condition.
std::vector<mtf::TableInfo> sensor_tables();

/// The settings of the tables that a sensor file holds. Throws UsageError for a [lag] of a thermal detector whose time
/// constant is given twice or not at all.
SensorSettings sensor_settings(const std::vector<mtf::SettingsTable>& tables);

}  // namespace radiometry
