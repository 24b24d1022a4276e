// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene file together with [scene] of the sensor file: planes of physical values on a known sample grid.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mtf/io/config/config.h"
#include "mtf/io/image_io.h"
#include "mtf/plan/plan.h"

namespace mtf::io {

struct Scene {
  std::vector<std::string> names;     ///< channels, as read
  std::vector<Image> planes;          ///< physical values
  std::vector<double> wavelength_um;  ///< of the planes, rising, of a spectral file (spectral_exr.h); else empty
  SampleGrid grid;
  Quantity quantity{};
  std::vector<std::string> warnings;  ///< assumptions and doubts, each with its reason
  FileInfo info;
  ChosenEncoding encoding;  ///< undone first; done already to `planes`, as the scaling
  IntegerScaling scaling;   ///< value = gain x file + offset
  /// Samples that the table of the encoding does not cover and that are NaN in `planes`, as a sentence; "" for none.
  std::string undecoded;
};

/// The spacing of the samples along x and y at the focal plane that a file states (attribute mtf:pixelPitch), if any.
std::optional<std::array<double, 2>> stated_pitch_um(const FileInfo& info);

/// Whether steps of x by y are of the shape of pixels that the file states, or it states none.
bool fits_aspect(const FileInfo& info, double step_x, double step_y);
/// "its pixels are 2 times as wide as they are high, as it states"; "" for square ones and where nothing is stated.
std::string aspect_note(const FileInfo& info);

/// Reads `path`. The sample spacing comes from the file (attribute mtf:pixelPitch) or [scene], and has to be of the
/// shape of pixels that the file states; integer files need gain, offset and quantity, float TIFF needs quantity, PNG
/// and TIFF that say that their values follow a curve need encoding; EXR is linear, and without a stated quantity taken
/// as radiance, with a warning; spectral EXR is spectral_radiance, in W m-2 sr-1 um-1. Throws UsageError naming the key
/// to add, RuntimeError for unreadable files.
Scene load_scene(const SensorConfig& config, const std::string& path, const ReadOptions& options);

/// The same of a file that has been read; `path` is what messages call it.
Scene physical_scene(const SensorConfig& config, const std::string& path, ImageFile file);

/// The same of a file whose pixels are read in windows: all but the planes, which are still to be made physical.
Scene describe_scene(const SensorConfig& config, const std::string& path, const ImageFile& file);
/// Stored values of the scene's file to its quantity. Returns how many have no value in the table of the encoding: NaN.
std::int64_t make_physical(const Scene& scene, ImageView<float> image);

/// Throws UsageError for a scene with samples that the table of its encoding does not cover.
void require_decoded(const Scene& scene);

/// The blur that is in the samples according to [scene] aperture.
SceneAperture scene_aperture(const SceneDefaults& defaults, const SampleGrid& grid);

/// Doubts about sampling: fewer than 2 samples per pitch along an axis, with the reason. Empty when fine.
std::vector<std::string> sampling_warnings(const System<double>& system, const SampleGrid& grid);

}  // namespace mtf::io
