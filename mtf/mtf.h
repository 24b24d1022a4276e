// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public headers of mtf: components multiply to a system, a plan filters images by it. What is not named here is
// internal: it is installed where these headers need it, and may change without notice. Files need mtfkit::io.

// A system: quantities, frame, factors.
#include "mtf/band.h"
#include "mtf/border.h"
#include "mtf/component.h"
#include "mtf/error.h"
#include "mtf/frame.h"
#include "mtf/from_quantities.h"
#include "mtf/grid.h"
#include "mtf/image.h"
#include "mtf/literals.h"
#include "mtf/quantity.h"
#include "mtf/settings.h"
#include "mtf/system.h"
#include "mtf/units.h"

// Factors of the OTF, all of them public; field.h and conformance.h for those of your own.
#include "mtf/components/all.h"
#include "mtf/components/conformance/conformance.h"
#include "mtf/components/electronics.h"
#include "mtf/components/field.h"

// Figures, plans, devices, images larger than the memory.
#include "mtf/device/device.h"
#include "mtf/metrics/resolution.h"
#include "mtf/plan/plan.h"
#include "mtf/plan/sensor_plan.h"
#include "mtf/tiles/tiles.h"

// Files.
#include "mtf/io/atomic_file.h"
#include "mtf/io/config/config.h"
#include "mtf/io/config/round_trip.h"
#include "mtf/io/config/schedule.h"
#include "mtf/io/csv/air_profile_csv.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/csv/spectrum_csv.h"
#include "mtf/io/exr/spectral_exr.h"
#include "mtf/io/image_io.h"
#include "mtf/io/scene.h"
#include "mtf/io/tile_store.h"
