// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/image_output.h"

namespace apps {

Written deliver(const SimulateOptions& options, const std::string& file, const std::vector<std::string>& names,
                SimulatedImage& image, const IntegerRange& range) {
  Written written;
  if (!file.empty()) {
    written = write_sensor_image(file, names, image.planes, image.metadata, range);
  } else if (options.sink) {
    std::vector<mtf::ImageView<const float>> views;
    for (const mtf::Image& plane : image.planes) views.push_back(std::as_const(plane).view());
    const mtf::Region whole{0, 0, views.front().width, views.front().height};
    options.sink({image.frame, whole, names, views, image.metadata});
  } else {
    return written;
  }
  if (!options.keep_images) image.planes.clear();
  return written;
}

}  // namespace apps
