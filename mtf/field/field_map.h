// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of a system by a table over the field: the interpolant of FieldMap (mtf/field_terms.h) through the values at
// the positions. Smooth (twice differentiable), of fourth or sixth order in the distance of the positions, and exact
// for polynomials of the degree that they determine: fields of third order (coma in r, astigmatism and curvature in
// r^2) are met by few positions. What lies between them is a guess all the same: the interpolant that lacks one of them
// is compared with the value there, for each in turn (Rippa, Adv. Comput. Math. 11, 193 (1999)); the ends of distances,
// to which the others could only be continued, are not left out. Of an image so are samples between their neighbours
// along rows and columns.

#include "mtf/field_terms.h"

namespace mtf {

inline constexpr std::size_t kMostFieldPositions = 2000;

/// The map through source, unit, radial, position and column as given. Throws UsageError for too few or too many
/// positions, two that are alike, all on one line, and distances that are negative or do not begin at the axis.
std::shared_ptr<const FieldMap> make_field_map(FieldMap given);

/// Throws UsageError where positions are too few or too many, two alike, or distances do not begin on the axis; as
/// make_field_map() does.
void require_positions(const FieldMap& map);

/// The same through an image over the detector, of source, columns, rows and column as given; each has two samples at
/// least along both axes, all finite.
std::shared_ptr<const FieldMap> make_field_image(FieldMap given);

/// Of an image, the pixels at which the polynomial through n Chebyshev points along each axis of a box misses a column
/// most: one in each ninth of the box, where it is no less than a tenth of the most. The corners of the box, in samples
/// from the corner of the image, are the middles of the first and of the last of the pixels, 2 at least along an axis.
std::vector<std::array<std::int64_t, 2>> hardest_pixels(const FieldMap& image, std::size_t column, std::size_t n,
                                                        const FieldPoint<double>& low, const FieldPoint<double>& high,
                                                        const std::array<std::int64_t, 2>& pixels);

}  // namespace mtf
