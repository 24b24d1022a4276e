// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public headers of the libraries of apps (mtfkit::sensors, simulate, study); what is not named here is internal
// (mtf/mtf.h).

// Sensors of files, images of them, trade studies.
#include "apps/sensor/otf_curves.h"
#include "apps/simulate/live_simulation.h"
#include "apps/simulate/simulate.h"
#include "apps/study/optimum/optimize.h"
#include "apps/study/rows/sweep_rows.h"
#include "apps/study/study.h"
