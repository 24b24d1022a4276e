// SPDX-License-Identifier: Apache-2.0
#pragma once

// Constants of physics, CODATA 2018: c, h, k and e are exact by the definition of the SI; the others follow from them.

namespace radiometry {

inline constexpr double kLightSpeed_m_s = 299792458.0;
inline constexpr double kPlanck_j_s = 6.62607015e-34;
inline constexpr double kBoltzmann_j_k = 1.380649e-23;
inline constexpr double kElementaryCharge_c = 1.602176634e-19;
inline constexpr double kStefanBoltzmann_w_m2_k4 = 5.670374419184429454e-8;  ///< 2 pi^5 k^4 / (15 h^3 c^2)

/// h c in J um: the energy of a photon is this over its wavelength in um.
inline constexpr double kPhotonEnergy_j_um = 1.986445857148928586e-19;
/// Second radiation constant h c / k in um K, as the sum of two doubles.
inline constexpr double kSecondRadiation_um_k = 0x1.c19e2673871f8p+13;
inline constexpr double kSecondRadiationRest_um_k = 0x1.b3e1a31745406p-44;

}  // namespace radiometry
