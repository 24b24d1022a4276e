// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/camera.h"

#include <cmath>
#include <string>

#include "mtf/error.h"
#include "mtf/units.h"
#include "mtf/work/usable_memory.h"

namespace radiometry::render {
namespace {

using scene::operator-, scene::operator*;

constexpr std::int64_t kMostSamples = std::int64_t{1} << 28;
constexpr double kBytesASample = 28.0;  // of a picture alone (measured, 4000 x 4000 samples)

/// Sliders of the format reach pictures that fill any machine.
void require_memory(double samples) {
  const mtf::UsableMemory memory = mtf::usable_memory();
  if (samples * kBytesASample <= memory.bytes) return;
  throw mtf::UsageError("camera: " + mtf::format_double(samples) + " samples need " +
                        mtf::format_double(samples * kBytesASample) + " bytes, " + memory.whose + " " +
                        mtf::format_double(memory.bytes) + "; take fewer samples a pitch or a smaller format");
}

void require_positive(double value, const char* what) {
  if (!(value > 0.0 && std::isfinite(value)))
    throw mtf::UsageError(std::string("camera: ") + what + " of " + mtf::format_double(value) +
                          "; it has to be above 0 and finite");
}

std::int64_t samples_of(std::int64_t pixels, double samples_per_pitch) {
  const double samples = static_cast<double>(pixels) * samples_per_pitch;
  return static_cast<std::int64_t>(std::ceil(samples * (1.0 - 1e-12)));
}

}  // namespace

Camera camera_of(const Lens& lens, const Pose& pose) {
  require_positive(lens.focal_length_mm, "a focal length in mm");
  require_positive(lens.pitch_x_um, "a pitch in um");
  require_positive(lens.pitch_y_um, "a pitch in um");
  require_positive(lens.samples_per_pitch, "a number of samples a pitch");
  if (lens.columns < 1 || lens.rows < 1)
    throw mtf::UsageError("camera: a format of " + std::to_string(lens.columns) + " x " + std::to_string(lens.rows) +
                          " pixels; it needs at least one");
  const double wanted = static_cast<double>(lens.columns) * static_cast<double>(lens.rows) * lens.samples_per_pitch *
                        lens.samples_per_pitch;
  if (!(wanted <= static_cast<double>(kMostSamples)))
    throw mtf::UsageError("camera: " + mtf::format_double(wanted) + " samples are more than " +
                          std::to_string(kMostSamples) + "; take fewer samples a pitch or a smaller format");
  require_memory(wanted);
  const Vector forward = pose.look_at - pose.position;
  const auto parallel = [&](const Vector& up) {
    return !(scene::length(scene::cross(forward, up)) > 1e-9 * scene::length(forward) * scene::length(up));
  };
  const bool vertical = pose.up[0] == 0.0 && pose.up[1] == 0.0;
  const Vector up = vertical && parallel(pose.up) ? Vector{0.0, 1.0, 0.0} : pose.up, across = scene::cross(forward, up);
  if (!scene::finite(pose.position) || !scene::finite(forward) || !scene::finite(pose.up))
    throw mtf::UsageError("camera: a coordinate of position, look_at or up is not finite");
  const double far = scene::length(forward), aside = scene::length(across);
  if (!(far > 0.0)) throw mtf::UsageError("camera: it looks at its own position; move look_at");
  if (parallel(up)) throw mtf::UsageError("camera: it looks along `up`; choose another up");
  Camera camera{.position = pose.position, .ahead = (1.0 / far) * forward, .right = (1.0 / aside) * across};
  camera.down = scene::cross(camera.ahead, camera.right);
  camera.width = samples_of(lens.columns, lens.samples_per_pitch);
  camera.height = samples_of(lens.rows, lens.samples_per_pitch);
  const double tangent = 1e-3 / (lens.focal_length_mm * lens.samples_per_pitch);
  camera.step_x = lens.pitch_x_um * tangent;
  camera.step_y = lens.pitch_y_um * tangent;
  camera.axis_x = 0.5 * static_cast<double>(lens.columns) * lens.samples_per_pitch;
  camera.axis_y = 0.5 * static_cast<double>(lens.rows) * lens.samples_per_pitch;
  return camera;
}

}  // namespace radiometry::render
