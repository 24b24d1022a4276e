// SPDX-License-Identifier: Apache-2.0
#pragma once

// Edges after flat frames: numbers that the nominal marks fit = true are fitted to raw images of edges, which the same
// camera took at the same settings, as `mtf measure` and `mtf fit` do it, with what the frames have told:
//   values     counts through the inverse of the response: x = offset + K e is linear in the light
//   clipped    at the counts where pixels are full, else at the end of the converter
//   left out   pixels that are defects in the flat frames
//   noise      of a pixel of one frame about the array's mean, V(x) = floor + K (x - offset) + (prnu (x - offset))^2,
//   in
//              place of what the edge shows of it, where the two agree within a quarter
//   crosstalk  is one more unknown, whose prior is the side from the covariances of flat frames. Charge that diffuses
//              before it is collected leaves no covariance, but blurs edges: a second fit without the prior gives what
//              the edges alone make of it

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/characterize/find_camera.h"
#include "calib/fit/fit.h"
#include "mtf/io/image_io.h"

namespace apps {

struct EdgePicture {
  std::string name;
  mtf::io::ImageFile image;
  bool on_disk = true;  ///< `name` is a file
};

struct CameraEdges {
  calib::FitResult fit;
  std::string sensor_text{};  ///< of the camera with the fitted numbers; "" where none were fitted
  Json report{};              ///< "edges" of result.json: as of `mtf fit`, and "shared"
  std::string table{};        ///< as of `mtf fit`, and what frames and edges share
  std::string words{};        ///< the same in a sentence
  bool misfit() const { return fit.status == calib::FitStatus::converged_model_wrong; }
};

/// `destination`: of the sensor file. `progress` as of calib::FitOptions. Throws UsageError for images that are no raw
/// frames or hold values beyond the bits, and as fit_parameters() and calib::fit().
CameraEdges fit_camera_edges(const FoundCamera& found, const StacksFile& stacks, std::vector<EdgePicture> pictures,
                             const std::string& destination, int threads, const std::function<bool(double)>& progress);

}  // namespace apps
