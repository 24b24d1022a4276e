// SPDX-License-Identifier: Apache-2.0
#pragma once

// The image with its edges drawn upon it, for the eye: regions, edges and their MTF50, and below the image what the
// colours and grey values stand for, with a scale of the image's pixels.

#include <span>
#include <string>

#include "apps/edges/measure_report.h"
#include "mtf/image.h"

namespace apps {

/// Writes a PNG, whole or not at all.
void write_annotated_image(const std::string& path, const mtf::Image& image, std::span<const MeasuredEdge> edges);

}  // namespace apps
