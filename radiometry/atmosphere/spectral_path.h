// SPDX-License-Identifier: Apache-2.0
#pragma once

// Transmission and thermal radiance of a line of sight by wavenumber nu (cm^-1):
//   lines of a gas      tau = exp(-(C(nu) W)^a)   (Pierluissi and Maragoudakis, AFGL-TR-86-0272 (1986): a band model of
//                       20 cm^-1), W with the exponents n, m of its band
//   continua, aerosol   tau = exp(-k(nu) W)
//   transmission        product of all of them
//   radiance            sum over the layers, from the sensor on, of B(nu, T) (tau_before - tau_behind), T the layer's
//                       mean temperature: emission alone, nothing scattered into the line, nothing of what lies at its
//                       end
// from 650 to 3500 cm^-1 every 5, from 3520 to 25000 every 20 (15.38 to 0.4 um); radiance up to 3500 (2.857 um).
// One layer is B (1 - tau) exactly. Constants are CODATA 2018.
//
// Derivatives, for S = ceres::Jet<double, N>: the law has an infinite slope at W = 0, so below a range of 1 m slopes
// are those at 1 m (values are right at any range). Include radiometry/atmosphere/derivatives.h to use other scalars
// than double.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "radiometry/atmosphere/sight.h"
#include "radiometry/light/path.h"

namespace radiometry::atmosphere {

inline constexpr double kShortest_um = 0.4, kLongest_um = 1e4 / 650.0;
inline constexpr double kShortestEmission_um = 1e4 / 3500.0;

enum class Component {
  water_lines,
  water_continuum,
  carbon_dioxide,
  ozone,
  nitrous_oxide,
  carbon_monoxide,
  methane,
  oxygen,
  nitrogen,
  nitric_acid,
  trace_gases,  ///< NO, SO2, NO2, NH3
  molecular,    ///< scattering by air
  aerosol,
  rain
};
inline constexpr std::size_t kComponents = 14;
inline constexpr std::array<std::string_view, kComponents> kComponentNames{
    "water_lines", "water_continuum", "carbon_dioxide", "ozone",       "nitrous_oxide", "carbon_monoxide", "methane",
    "oxygen",      "nitrogen",        "nitric_acid",    "trace_gases", "molecular",     "aerosol",         "rain"};
constexpr std::span<const std::string_view> words(Component) { return kComponentNames; }

/// What was not computed, and how much any transmission of the result may be too large for it.
struct LeftOut {
  std::string what;
  double bound = 0.0;
};

struct SpectralOptions {
  Interval band{kShortest_um, kLongest_um};  ///< wavelengths wanted: the result has the samples inside and one beyond
                                             ///< each end, where the model goes on
  bool components = false;                   ///< transmission by component too
  double tolerance = 0.0;  ///< absorbers, and layers at the end of the line, may be left out that together change no
                           ///< transmission by more than this
};

template <class S>
struct SpectralPath {
  std::vector<double> wavenumber_cm;  ///< rising, cm^-1
  std::vector<S> transmission;
  std::vector<S> radiance;                            ///< W m^-2 sr^-1 per cm^-1, of the wavenumbers up to 3500 alone
  std::array<std::vector<S>, kComponents> component;  ///< transmissions, empty unless asked for
  SightNumbers<S> sight;
  std::vector<LeftOut> left_out;
};

/// Throws UsageError as require_valid and sight_numbers do, and for a band not inside the model's or not rising.
template <class S>
SpectralPath<S> spectral_path(const Air<S>& air, const Sight<S>& sight, const SpectralOptions& options = {});

/// The same as curves of the wavelength: transmission, and radiance in W m^-2 sr^-1 um^-1, 0 below 2.857 um (where
/// nothing is known of it: see limits_of).
Path path_of(const SpectralPath<double>& path, const std::string& source);

/// Optical depth of what the aerosol scatters along a line, the mean over the wavelengths of a band: extinction less
/// absorption. Throws UsageError as spectral_path.
double scattering_depth(Air<double> air, const Sight<double>& sight, const Interval& band);

/// What a user of this band and air has to be told: no radiance (scattered sunlight, at night little) below 2.857 um;
/// bands narrower than 20 cm^-1; fog and rain, which scatter thermal radiation; fog that one sees far through;
/// temperature, vapour and humidity beyond what the coefficients were fitted to; a line of one altitude that is longer
/// than one can see there. A rule, a semicolon, and what breaks it.
std::vector<std::string> limits_of(const Air<double>& air, const Interval& band,
                                   const std::optional<Sight<double>>& sight = std::nullopt);

}  // namespace radiometry::atmosphere
