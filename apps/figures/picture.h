// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures of images for the eye: panels side by side, each with a caption above it and a bar of grey values below it
// that states range and unit. They are not data: what `mtf simulate` writes as PNG or TIFF holds values only.

#include <list>
#include <span>
#include <string>
#include <vector>

#include "mtf/image.h"

namespace apps {

struct Panel {
  std::string caption;  ///< ASCII
  mtf::ImageView<const float> image;
  int zoom = 1;              ///< a pixel becomes a square of so many pixels a side
  double low = 0, high = 1;  ///< the values shown in black and in white; values beyond are clipped
  std::string quantity{};    ///< of the bar, with unit: "radiance [W/m2]"; ASCII
};

/// Words at the two ends of a panel's bar, "2.5" or, where values are clipped, "2.5 and below: 0.3 %" of the pixels.
struct BarEnds {
  std::string low, high;
};
BarEnds bar_ends(const Panel& panel);

/// Throws UsageError for the file of `--picture` that is no PNG; "" is none.
void require_picture_name(const std::string& file);

/// What `--picture` draws: two panels a row in false colours, scene and image, in powers of a thousand of their units.
/// A hundredth of the pixels is shown in black, and up to three hundredths in white: hot spots would take all colours.
class PairedPicture {
 public:
  struct Caption {
    std::string name, pixels;  ///< "radiance", "samples"
  };
  /// The image is enlarged to fill `width`, by a whole factor; pixels without a finite value are black.
  void add(const Caption& caption, mtf::ImageView<const float> image, const std::string& unit, std::int64_t width);
  void write(const std::string& path) const;

 private:
  std::list<mtf::Image> images_;
  std::vector<Panel> panels_;
};

/// Writes the panels as one PNG, whole or not at all; in false colours instead of grey where that is asked for. Rows of
/// `columns` panels; 0: all in one row.
void write_picture(const std::string& path, std::span<const Panel> panels, bool false_colour = false,
                   std::size_t columns = 0);

}  // namespace apps
