// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spectral images in OpenEXR, one channel a wavelength (Fichet, Pacanowski and Wilkie, JCGT 10(3), 2021):
//   S0.550,000000nm   radiance (Stokes S0; S1 to S3 where polarised); the decimal mark is a comma
//   T.550,000000nm    reflectance or transmittance;   T.400nm.500nm   re-radiation from one wavelength to another
// with units m or Hz after any SI prefix. Of these S0 is read, sorted by wavelength as numbers. S1 to S3 and T may
// be there at the same wavelengths and are left out; reflectance alone is no scene.
// Units: the attribute emissiveUnits is "W.m^-2.sr^-1" in files of the authors' tools and "W.m^-2.sr^-1.nm^-1" in
// others. Both are taken as densities per nm, for that is what the authors integrate; units that end in um^-1 or m^-1
// are taken by their word.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/image_io.h"

namespace mtf::io {

struct SpectralChannel {
  enum class Kind { stokes, reflectance, reradiation } kind = Kind::stokes;
  int stokes = 0;  ///< 0 to 3
  double wavelength_um = 0.0;
};

/// What a channel name means, by the grammar of the layout; nothing for other names and wavelengths beyond 1e-6 um to
/// 1e12 um.
std::optional<SpectralChannel> parse_spectral_channel(std::string_view name);

/// Which of the channels (indices into `channels`, of which `allowed` count) are the radiance spectrum, by rising
/// wavelength; empty when none is of the layout. Throws UsageError for reflectance alone, sets of S0 to S3 and T at
/// different wavelengths, one wavelength twice, and spectra in several parts.
std::vector<std::size_t> spectral_choice(const std::string& path, const std::vector<ChannelInfo>& channels,
                                         const std::vector<std::size_t>& allowed);

struct SpectralPlanes {
  std::vector<double> wavelength_um;  ///< of the planes
  double factor = 1.0;                ///< value x factor is W m^-2 sr^-1 um^-1
  bool stated = true;                 ///< the file says so; otherwise it is assumed, densities per nm
  std::vector<std::string> warnings;  ///< what was assumed and left out
};

/// Of planes read under these names: nothing unless all are S0 channels or bands whose wavelengths the file lists, and
/// when the file says that its quantity is another one; of other formats than OpenEXR nothing, too, unless spectral
/// radiance is what the file says or what is `asked` for. Throws UsageError for units that are not known.
std::optional<SpectralPlanes> spectral_planes(const std::string& path, const ImageFile& file, bool asked = false);

/// The first of `names` ("depth", "Z") that the file has as a channel, as a whole name or as the part after the last
/// dot, in any case; "" when there is none. Throws UsageError when it occurs in several layers or parts.
std::string find_channel(const std::string& path, const FileInfo& info, const std::vector<std::string>& names);

/// A further plane: the first of `names` that is there. Throws UsageError, with what there is, when none is.
Image read_plane(const std::string& path, const std::vector<std::string>& names);

}  // namespace mtf::io
