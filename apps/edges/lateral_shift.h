// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lateral colour: how far the edge of one plane of an image lies from the same edge in another plane. Magnification
// that depends on the wavelength, a prism error or planes that are out of register shift an edge along its normal.
//
// An edge is the same in both planes where the normals agree within 2 degrees, and where its middle lies beside the
// other one, at most 5 pixels away. The location is the one about which the phase of the OTF is least (EdgeMeasurement,
// calib/measure/measure.h), so that a displacement comes out whole; an asymmetric blur (coma) of one plane alone counts
// as a displacement in part.

#include <span>
#include <string>

#include "apps/edges/measure_report.h"

namespace apps {

/// Sets `shift` of the measured edges of one image, planes of which follow one another. The reference is the green
/// plane (a name whose last part begins with G), else the first; its own edges have no shift, nor have edges without a
/// partner there.
void add_lateral_shifts(std::span<MeasuredEdge> edges);

/// A table of the shifts; "" where there are none.
std::string lateral_shift_table(const MeasureReport& report);

/// Columns of CSV: lateral_shift_px, lateral_shift_px_sd, lateral_shift_from; "" where no edge has a shift, and then
/// edges have none of the columns.
std::string lateral_shift_header(const MeasureReport& report);
std::string lateral_shift_columns(const MeasuredEdge& edge);

}  // namespace apps
