// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light of a design along the range to its target: the same for all designs with the same air, band and scene,
// which share it. It is worked out on panels of at most an octave of range, at the 7 points of a Chebyshev series of
// degree 6 in ln(range), and only on panels that are asked for; a panel on which the logarithms of the numbers need
// more is halved. Colours change little: every second of the points has one, unless the path blurs. Tables of paths
// have a kink at each of their ranges, where panels end.

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "apps/sensor/sensor_air.h"
#include "apps/study/design/variant_sensor.h"

namespace study {

/// What arrives at the aperture.
struct LightAtRange {
  double scene = 0.0, path = 0.0;  ///< BandRadiances
  double contrast_share = 1.0;     ///< of a small temperature difference of the scene
};

/// What the OTF of a range takes from its air.
struct ColourAtRange {
  std::shared_ptr<const mtf::ElectronRate> rate;
  mtf::PathAir<double> air;
};

/// The points of a panel.
struct RangePanel {
  double lo_m = 0.0, hi_m = 0.0;
  std::vector<double> range_m{};                ///< rising
  std::array<std::vector<double>, 3> series{};  ///< of each of the numbers of LightAtRange, or of its logarithm
  std::array<bool, 3> logarithm{};
  double error = 0.0;                   ///< relative, of the worst of them
  std::vector<ColourAtRange> colour{};  ///< at all of the points or every second; empty until it is asked for

  /// The weights with which what is known at the points of the colours counts at a range between them.
  std::vector<double> weights(double range_m) const;
};

/// What the series through values at the points of a panel leaves.
double panel_error(std::vector<double> values);

class LightCourse {
 public:
  /// `own`: the numbers of the design behind its own air. `tolerance`: of a panel. The variant has to outlive it, and
  /// is one whose air can be followed.
  LightCourse(const VariantSensor& variant, const radiometry::Conditions& conditions,
              std::span<const radiometry::Override<double>> numbers, const radiometry::SpectralNumbers<double>& own,
              double tolerance);
  LightCourse(const LightCourse&) = delete;
  LightCourse& operator=(const LightCourse&) = delete;

  const radiometry::Reach& reach() const { return air_.reach; }
  /// True where the OTF of the design changes with the range: by the path of components, or by the wavelengths that the
  /// air lets through.
  bool moves_otf() const { return moves_otf_; }

  LightAtRange at(double range_m) const;  ///< 0 m: without air
  ColourAtRange colour_at(double range_m) const;
  /// The numbers of a design behind that light, NETDs being those at the aperture.
  radiometry::SpectralNumbers<double> numbers(const LightAtRange& light) const;

  /// The panel of a range above 0, with the colours of its points where they are asked for.
  const RangePanel& panel(double range_m, bool colours);
  /// As at(), between the points of the panel.
  LightAtRange between(double range_m);
  /// Of between(), relative: what the panel leaves, and how far two tables differ there of which one lacks the nearest
  /// range.
  double error(double range_m);

 private:
  LightAtRange behind(const radiometry::Path& path, double range_m) const;
  RangePanel made(double lo_m, double hi_m) const;

  const VariantSensor* variant_;
  double temperature_k_;
  std::vector<radiometry::Override<double>> own_overrides_;
  radiometry::Overrides<double> overrides_;
  radiometry::SpectralNumbers<double> own_;  ///< per_k: without air
  apps::AirCourse air_;
  double extinction_per_km_, tolerance_;
  std::shared_ptr<const mtf::ElectronRate> own_rate_;
  bool moves_otf_ = false;
  std::map<std::pair<double, double>, RangePanel> panels_{};  ///< by their ends
};

// The light of a design: the integrals over the band for its budget, how much each wavelength counts in the OTF of the
// band, and the path that components take. All follow from the air between scene and sensor, which a study may change
// from design to design.

struct DesignLight {
  radiometry::SpectralNumbers<double> numbers;
  std::shared_ptr<const mtf::ElectronRate> rate;  ///< of Band::rate; nothing where wavelengths need no weights
  mtf::PathAir<double> air;                       ///< of System::air
  std::shared_ptr<LightCourse> course{};          ///< along the range; null where no range is asked for, or none exists
};

/// What of it a study needs.
struct LightNeeds {
  bool numbers = false, otf = false, ranges = false;
};

/// The light of a variant with numbers overridden; the variant's own where none of them changes it. Throws UsageError
/// as spectral_numbers and apps::electron_rate.
DesignLight light_of(const VariantSensor& variant, const Study& study,
                     std::span<const radiometry::Override<double>> numbers, const LightNeeds& needs);

/// Keeps the light of the last design, which neighbours often share.
class KeptLight {
 public:
  const DesignLight& at(const VariantSensor& variant, const Study& study,
                        std::span<const radiometry::Override<double>> overrides, const LightNeeds& needs);

 private:
  std::vector<radiometry::Override<double>> spectral_;  ///< those of the last design that its light depends on
  std::optional<DesignLight> light_;
};

}  // namespace study
