// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public headers of apps/scene: files of 3-D scenes, their temperatures and pictures, flights; what is not named
// here is internal (mtf/mtf.h).

#include "apps/scene/fly/flight.h"
#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/import/import_mesh.h"
#include "apps/scene/render/picture_scene.h"
#include "apps/scene/scene_file/scene_file.h"
