// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images of edges and of point sources as Python gives them: a file, an image that was read, or an array.

#include <pybind11/pybind11.h>

#include <optional>
#include <string>
#include <vector>

#include "apps/edges/edge_input.h"
#include "apps/python/arrays.h"
#include "apps/python/images.h"

namespace apps::python {

struct EdgeImage {
  std::string name;
  std::optional<mtf::io::ImageFile> file;  ///< without one, `name` is a file that is still to be read
  bool on_disk = false;                    ///< `name` is a file
};

/// `image`: a text, an ImageFile, or an array, which messages call `name`. Throws UsageError as plane_of.
EdgeImage edge_image(const pybind11::object& image, const std::string& name);

/// How images are read and edges found, by names of EdgeInput.
EdgeInput edge_input_of(const pybind11::dict& words);

/// Its planes, with their regions where these are wanted.
std::vector<EdgePlane> planes_of(EdgeImage&& image, const EdgeInput& input, Regions regions = Regions::wanted);

}  // namespace apps::python
