// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images of edges as the command line describes them: linear planes, no data as NaN, and the regions to measure.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "apps/options.h"
#include "calib/measure/measure.h"
#include "mtf/io/codecs/stated_encoding.h"
#include "mtf/io/image_io.h"

namespace apps {

struct EdgeRegion {
  calib::Roi roi;
  std::string name;  ///< of a region file; "" = none
};

/// What made the stored values linear, and the file's scale in linear units.
struct Linearisation {
  std::string encoding;                       ///< as of --encoding
  std::string encoding_source;                ///< who says so (mtf::io::ChosenEncoding)
  mtf::io::StatedEncoding stated;             ///< what the file states
  std::string storage;                        ///< of the file, "8-bit"
  bool integer = false;                       ///< stored as whole numbers
  double full_scale = 1.0;                    ///< largest stored value
  std::optional<double> dark_end, light_end;  ///< linear values where the scale ends; absent for floating point
  double dct_rounding_sd = 0.0;  ///< of a JPEG: largest error of a pixel in counts, rms (mtf/io/codecs/encoding.h)
  std::string mosaic;            ///< pattern of a colour filter mosaic; "" = none
  std::string mask;              ///< file; "" = none
};

struct EdgePlane {
  std::string image;    ///< the file
  std::string channel;  ///< "" when there is only one
  mtf::Image plane;
  std::optional<std::array<double, 2>> stated_pitch_um{};  ///< along x and y, of the file; absent: it states none
  std::vector<EdgeRegion> regions;                         ///< given or found; empty: `reason`
  std::string reason;
  std::string warning;                      ///< "" = none
  std::vector<std::string> notes;           ///< what the file states and holds beside it, and which edges are left out
  std::size_t left_out = 0, not_tried = 0;  ///< of the edges that were found (calib/find/find_edges.h)
  calib::MeasureOptions options;            ///< noise, quantum and clipping of these values
  Linearisation linearisation;
};

/// Whether regions are taken from the command line or searched; a point source is its whole image.
enum class Regions { wanted, none };

/// The planes of one image. Throws UsageError for colour without a choice and a mosaic or mask that does not fit,
/// RuntimeError for files that cannot be read. Given regions may leave the image.
std::vector<EdgePlane> load_edge_planes(const std::string& image, const EdgeInput& input,
                                        Regions regions = Regions::wanted);

/// The same of an image that has been read; `image` is what messages call it.
std::vector<EdgePlane> edge_planes_of(mtf::io::ImageFile file, const std::string& image, const EdgeInput& input,
                                      Regions regions = Regions::wanted);

/// Every file that the input names, for outputs not to replace.
std::vector<std::string> files_of(const EdgeInput& input);

}  // namespace apps
