// SPDX-License-Identifier: Apache-2.0

// Writes an image, reads it back, compares; a preview goes through the codec module, which the installed package has to
// find by itself. A sensor made of quantities and typed components images it.

#include <cmath>
#include <cstdio>

#include "mtf/components/footprint.h"
#include "mtf/components/jitter.h"
#include "mtf/from_quantities.h"
#include "mtf/image.h"
#include "mtf/io/image_io.h"
#include "mtf/literals.h"
#include "mtf/plan/sensor_plan.h"
#include "mtf/version.h"

namespace {

/// The sum over the pixels, times the samples of a pixel, is the sum over the samples: blur moves light, and loses
/// none.
bool sensor_keeps_the_light() {
  using namespace mtf::literals;
  mtf::System<double> system;
  system.frame = mtf::make_frame({.focal_length = 100_mm, .pitch = 15_um});
  system.add(mtf::Stage::presample, mtf::Footprint<double>{.width = 15_um});
  system.add(mtf::Stage::presample, mtf::Jitter<double>{.rms = 20_urad});

  mtf::Image image(64, 32);
  double before = 0.0, after = 0.0;
  for (std::int64_t i = 0; i < image.size(); ++i) before += image.data()[i] = static_cast<float>(i % 64 / 16);
  const mtf::SceneView scene{image.view(), 3.75_um};
  const mtf::Image seen = mtf::compile_sensor(system, scene, {.tolerance = 1e-4}).run(scene);
  for (std::int64_t i = 0; i < seen.size(); ++i) after += seen.data()[i];
  return seen.width() == 16 && seen.height() == 8 && std::abs(16.0 * after - before) < 1e-3 * before;
}

}  // namespace

int main() {
  mtf::Image image(3, 2);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<float>(i) + 0.25F;

  const mtf::Image& scene = image;
  mtf::io::write_exr("consumer.exr", {{"Y", scene.view()}}, {});
  const mtf::io::ImageFile back = mtf::io::read_image("consumer.exr");
  if (back.planes.size() != 1 || back.planes[0].size() != image.size()) return 1;
  for (std::int64_t i = 0; i < image.size(); ++i)
    if (back.planes[0].data()[i] != image.data()[i]) return 1;

  mtf::io::write_preview_png("consumer.png", {{"Y", scene.view()}}, 0.0, 6.0);
  if (mtf::io::read_info("consumer.png").width != image.width()) return 1;
  if (!sensor_keeps_the_light()) return 1;
  std::printf("mtfkit %s\n", mtf::version);
  return 0;
}
