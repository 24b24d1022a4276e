// SPDX-License-Identifier: Apache-2.0
#pragma once

// Planes of a scene become *weighted radiance* at the aperture, photons s^-1 m^-2 sr^-1 or, for a thermal detector,
// W m^-2 sr^-1:
//   L = integral over the band of R(lambda) L(lambda) dlambda,  L(lambda) in photons or in watts: SceneBand::flux
// with R the product of the curves that the light passes: transmission of the path where it is the same for all pixels,
// of the optics and filters, quantum efficiency. That is BandRadiances::scene of signal.h; it is linear in the light,
// so it may pass the OTF before the camera equation makes electrons of it.
//   temperature         L = E(T) + E'(T_surroundings), E with R x emissivity, E' with R x (1 - emissivity)
//   spectral radiance   a straight line in wavelength between the channels, 0 beyond the first and the last one; a
//                       single channel is a constant over the band
//   band radiance       says nothing of the spectrum. It is taken as that of a blackbody of `source_k` or, without one,
//                       as constant per wavelength in that flux (as BandResponse::electron_nodes does), over the band
//                       of SceneBand, and 0 outside: L = factor x radiance.
// NaN stays NaN and +infinity stays. Pixels below 0 (temperatures in K too) are refused, or taken as 0 when asked.
// A refusal is a UsageError with the number of pixels and the first one, thrown before a pixel is changed.

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "mtf/image.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/spectral_signal.h"

namespace radiometry {

/// The band of a scene and the curves between scene and electrons, at most 8 with those of a call (emissivity; spectral
/// channel and photons per joule).
struct SceneBand {
  Interval band;
  std::vector<Spectrum> curves;
  Flux flux = Flux::photons;  ///< of the weighted radiance
};

/// The curves of the camera alone: for paths that differ from pixel to pixel (path_planes.h), or none.
SceneBand scene_band(const SpectralCamera& camera);
/// The same with a path in front of the camera that is the same for all pixels. The path also adds
/// weighted_path_radiance: always take both.
SceneBand scene_band(const SpectralCamera& camera, const Path& path);
/// What a path adds, weighted by the camera's curves: BandRadiances::path.
double weighted_path_radiance(const SpectralCamera& camera, const Path& path);

enum class Negative {
  refuse,
  clamp  ///< to 0
};
inline constexpr std::array<std::string_view, 2> kNegativeNames{"refuse", "clamp"};
constexpr std::span<const std::string_view> words(Negative) { return kNegativeNames; }

struct PlaneOptions {
  Negative negative = Negative::refuse;
  int threads = 1;  ///< 0: all cores
};

/// The emissivity of the surfaces of a scene. `plane`, where it has pixels, takes the place of the curve: it has the
/// size of the scene, and its values, in [0, 1], are the same at all wavelengths.
struct SurfaceFinish {
  Spectrum emissivity = constant_spectrum("blackbody", 1.0);
  mtf::ImageView<const float> plane{};
  double surroundings_k = 0.0;  ///< temperature of what is reflected
};

/// Temperatures in K become radiance, in place; relative error 1e-7 beyond the rounding of floats, 0 K gives exactly
/// what is reflected. Throws UsageError as BandResponse does and for emissivities outside [0, 1].
void radiance_of_temperature(mtf::ImageView<float> plane, const SceneBand& scene, const SurfaceFinish& finish = {},
                             const PlaneOptions& options = {});

/// The same for a plane that comes in pieces, with one emissivity for all pixels: what is made once for all
/// temperatures from lo_k to hi_k. Temperatures below 0 become 0.
class TemperatureRadiance {
 public:
  /// Throws UsageError as radiance_of_temperature.
  TemperatureRadiance(const SceneBand& scene, const Spectrum& emissivity, double surroundings_k, double lo_k,
                      double hi_k);
  void apply(mtf::ImageView<float> plane, int threads = 1) const;

 private:
  RadianceTable table_;
  double reflected_;
};

/// L for one unit of radiance in the band, W or photons s^-1, m^-2 sr^-1, of the spectral shape said above. Throws
/// UsageError when a blackbody of `source_k` radiates nothing there.
double light_per_radiance(Flux given, const SceneBand& scene, std::optional<double> source_k);

/// For spectral radiance in W m^-2 sr^-1 um^-1 at rising wavelengths: L = sum of weight x channel. `used` is what
/// channels, band and curves have in common; UsageError (with the ranges) when that is nothing.
struct ChannelWeights {
  std::vector<double> weight;
  Interval used;
};
ChannelWeights channel_weights(const SceneBand& scene, std::span<const double> wavelength_um);

/// The same with a factor: what part of L comes from the wavelengths around each, as integrals of hat x R x shape. The
/// shape is a blackbody's radiance at `source_k` or, without one, 1 per um: for curves that multiply the
/// light, such as the transmission of a path at these wavelengths.
ChannelWeights shape_weights(const SceneBand& scene, std::span<const double> wavelength_um,
                             std::optional<double> source_k);

/// Band radiance, or counts of a linear camera, become L in place: factor x value.
void radiance_of_band(mtf::ImageView<float> plane, double factor, const PlaneOptions& options = {});

/// Channels become L: `out` = sum of weight x channel; it may be one of them. Throws UsageError for other sizes or
/// another number of weights.
void radiance_of_channels(std::span<const mtf::ImageView<const float>> channels, std::span<const double> weight,
                          mtf::ImageView<float> out, const PlaneOptions& options = {});

}  // namespace radiometry
