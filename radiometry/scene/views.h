// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a surface sees: the share of its hemisphere, weighted by the cosine to the normal, that ends in each ring of the
// sky, on the ground beyond the scene, and on other surfaces. In the terms of radiative exchange these are the view
// factors from the surface to the rings, the ground and the facets,
//   F = 1/(A pi) integral over A and over the solid angle of the target of cos(theta) dOmega dA,
// and they sum to 1.
//
// Rings divide the upper hemisphere into equal steps of the zenith angle, from the zenith to the horizon. A ray that
// leaves the scene above the horizon sees its ring; one that leaves below sees the ground.
//
// Rays start at points spread over the surface, in directions spread by the cosine law: R4, the additive recurrence of
// Roberts ("The unreasonable effectiveness of quasirandom sequences", 2018), rotated by a hash of the receiver. What a
// surface would see of each ring without obstacles is known in closed form (ZenithRings); rays only measure which
// part of a ring is hidden (post-stratification, Cochran, Sampling Techniques, 1977, section 5A.9). Of a ring
// that no ray went to, as much is hidden as of the nearest one that has rays. So the view of a surface without
// obstacles is exact, and shares sum to 1 to rounding.
//
// The rms error of a share F from n rays is at most about sqrt(F (1 - F) / n), that of independent rays; for facing
// unit squares (F = .2) 64 rays give .033, 256 .014, 1024 .006, 4096 .0022. table_error.h measures it for a scene.

#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/scene/rays.h"

namespace radiometry::scene {

// Zenith rings: the sky divided at equal steps of the zenith angle, and what a tilted plane sees of them.

/// The view factor from a small plane whose normal is tilted from the zenith (cosine of the tilt `cos_tilt`) to the
/// part of the sky within the angle `zenith_rad` of the zenith, up to a right angle; what lies behind the plane is not
/// seen. It is that of a sphere that subtends this angle (Juul, "View factors in radiation between two parallel
/// oriented cylinders and spheres", and Howell, Catalog of Radiation Heat Transfer Configuration Factors, B-17):
///   cos(b) sin^2(t)                                                                              b <= pi/2 - t
///   1/2 - asin(cos t / sin b) / pi
///     + [cos(b) sin^2(t) acos(-cot t cot b) - cos(t) sqrt(sin^2 t - cos^2 b)] / pi               between
///   0                                                                                            b >= pi/2 + t
double cap_share(double cos_tilt, double zenith_rad);

/// The rings of a table: 90 deg / rings wide each.
class ZenithRings {
 public:
  explicit ZenithRings(int rings);
  int rings() const { return static_cast<int>(cosine_.size()); }
  /// The zone of a direction of length 1 with this upward component: its ring, or rings() for below the horizon.
  int zone(double up) const;
  /// View factors from a plane to the zones, rings first, then the ground; they sum to 1. Times `weight` onto `zones`.
  void add_shares(double cos_tilt, double weight, std::span<double> zones) const;

 private:
  std::vector<double> zenith_rad_, cosine_;  // outer limit of each ring
};

struct ViewOptions {
  int rings = 9;  ///< 1 to 90
  int rays = 64;  ///< of each receiver
  /// Of every receiver its own number instead, where receivers do not all matter as much; empty: `rays`.
  std::span<const int> rays_of{};
  std::uint64_t seed = 0;  ///< another one gives an independent set of rays
  int threads = 0;         ///< 0: all cores; the result does not depend on it
  /// The rays of a receiver belong to its first side in place of its number in the list, so that they are the same
  /// whatever other receivers there are.
  bool rays_of_side = false;
};

/// Rows of a sparse matrix: row i has the entries [first[i], first[i + 1]), columns rising.
struct SparseRows {
  std::vector<std::uint64_t> first{0};
  std::vector<std::uint32_t> column{};
  std::vector<double> value{};

  std::size_t rows() const { return first.size() - 1; }
};

/// Row after row, one for each receiver: sky[i * rings + r] + ... + ground[i] + surfaces[i] sum to 1.
struct Views {
  int rings = 0;
  std::vector<double> sky{};       ///< ring r has zenith angles from 90 deg r / rings to 90 deg (r + 1) / rings
  std::vector<double> ground{};    ///< leaves the scene below the horizon
  std::vector<double> surfaces{};  ///< ends on facets of the scene
  std::vector<double> rays{};      ///< that the row comes from
  SparseRows patches{};            ///< of `surfaces`, by patch; no rows where no patches were asked for

  std::size_t size() const { return ground.size(); }
  /// Of a receiver, all rings together.
  double sky_share(std::size_t i) const;
};

/// Throws mtf::UsageError for options out of range.
Views views(const Rays& rays, const Receivers& receivers, const ViewOptions& options = {});

/// The same with the shares of patches, which are groups of sides: `patch_of[index(side)]` for all sides of all facets,
/// below `patches`, or kNone for the inside of a solid: a ray that ends there started on a facet that another solid
/// covers, and counts as the view of its own patch, with which no heat is exchanged. A set of sides is seen from all
/// its sides, by area.
Views views(const Rays& rays, const Receivers& receivers, std::span<const std::uint32_t> patch_of, std::size_t patches,
            const ViewOptions& options = {});

/// Views of sets of receivers from those of their members, by area, without new rays: row i belongs to set `set_of[i]`
/// of `sets`, and what is seen of patch j becomes part of `patch_of[j]`, below `patches`. So that rays need to be
/// traced once, with each receiver a patch of its own, before it is known what is merged. Throws mtf::UsageError when
/// sizes do not fit each other or a set has no member.
Views combined_views(const Views& views, std::span<const double> area_m2, std::span<const std::uint32_t> set_of,
                     std::size_t sets, std::span<const std::uint32_t> patch_of, std::size_t patches);

/// A patch for every side: sides of receiver i belong to `patch_of_receiver[i]`. A side that no receiver has belongs to
/// the patch of the other side of its facet; the back of a closed shell that no receiver has is the inside of a solid,
/// kNone. Throws mtf::UsageError that names a facet of which neither side is received.
std::vector<std::uint32_t> patches_of_sides(const Facets& facets, const Receivers& receivers,
                                            std::span<const std::uint32_t> patch_of_receiver);

}  // namespace radiometry::scene
