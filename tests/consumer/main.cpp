// SPDX-License-Identifier: Apache-2.0

// Writes an image, reads it back, compares; a preview goes through the codec module, which the installed package has to
// find by itself.

#include <cstdio>
#include <cstring>
#include <string>

#include "mtf/image.h"
#include "mtf/io/image_io.h"
#include "mtf/version.h"

int main(int argc, char** argv) {
  const bool with_codecs = argc > 1 && std::strcmp(argv[1], "ON") == 0;
  mtf::Image image(3, 2);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<float>(i) + 0.25F;

  const mtf::Image& scene = image;
  mtf::io::write_exr("consumer.exr", {{"Y", scene.view()}}, {});
  const mtf::io::ImageFile back = mtf::io::read_image("consumer.exr");
  if (back.planes.size() != 1 || back.planes[0].size() != image.size()) return 1;
  for (std::int64_t i = 0; i < image.size(); ++i)
    if (back.planes[0].data()[i] != image.data()[i]) return 1;

  if (with_codecs) {
    mtf::io::write_preview_png("consumer.png", {{"Y", scene.view()}}, 0.0, 6.0);
    if (mtf::io::read_info("consumer.png").width != image.width()) return 1;
  }
  std::printf("mtfkit %s\n", mtf::version);
  return 0;
}
