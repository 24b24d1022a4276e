// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public headers of calib; what is not named here is internal (mtf/mtf.h).

// Edges and slanted-edge measurement.
#include "calib/edge/step_response.h"
#include "calib/find/find_edges.h"
#include "calib/find/roi_file.h"
#include "calib/iso12233/iso12233.h"
#include "calib/measure/measure.h"

// Fits.
#include "calib/fit/fit.h"
#include "calib/series/series_fit.h"
