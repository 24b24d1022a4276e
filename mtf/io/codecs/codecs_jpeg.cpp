// SPDX-License-Identifier: Apache-2.0
#include <turbojpeg.h>

#include <memory>

#include "mtf/io/codecs/codecs_parts.h"
#include "mtf/io/codecs/jpeg_scan.h"

namespace mtf::io::module {

// The luminance plane as it is stored. Of damaged data libjpeg makes some image, with a warning: here that is an error.
std::vector<Image> decode_jpeg(const std::string& path, const RasterHeader& header) {
  std::vector<unsigned char> file;
  require_same(scan_jpeg(path, &file), header, path, "JPEG");
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), &tjDestroy);
  std::vector<unsigned char> pixels(static_cast<std::size_t>(header.width * header.height));
  const int width = static_cast<int>(header.width), height = static_cast<int>(header.height);
  if (tjDecompress2(decoder.get(), file.data(), file.size(), pixels.data(), width, width, height, TJPF_GRAY,
                    TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT) != 0)
    undecodable(path, "JPEG", tjGetErrorStr2(decoder.get()));
  std::vector<Image> planes = empty_planes(header);
  place({pixels.data(), 0, 0, header.width, header.height, header.width, 1}, header, planes);
  return planes;
}

}  // namespace mtf::io::module
