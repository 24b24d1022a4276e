// SPDX-License-Identifier: Apache-2.0
#pragma once

// A series of images as a table, for through-focus curves and for a lens over its field: what the edges of each image
// say together.

#include <span>
#include <string>

#include "apps/edges/measure_report.h"

namespace apps {

/// A line for all edges of an image and channel, and one for those of its edges that are sagittal and tangential, if
/// any: image,channel,direction,edges,measured,refused_share,mtf50_best,mtf50_best_sd,mtf50_median,mtf50_median_sd,
/// then the same four columns for each of the report's contrasts (mtf20_best, ...), frequency_unit,reason. Edges count
/// as refused where they gave no result; they have no direction. The deviation of the median is that of the edge in the
/// middle, or of the mean of the two there: an upper limit, as nothing is assumed of how alike the edges are. The best
/// of many noisy values is above the best edge.
std::string image_table(const MeasureReport& report);

}  // namespace apps
