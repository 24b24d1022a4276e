// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light of a design: the integrals over the band for its budget, how much each wavelength counts in the OTF of the
// band, and the path that components take. All follow from the air between scene and sensor, which a study may change
// from design to design.

#include <optional>

#include "apps/study/design/light_course.h"

namespace study {

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
