// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>

#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/codecs_parts.h"
#include "mtf/version.h"

namespace mtf::io::module {

int write_all(int descriptor, const void* data, std::size_t size) {
  const char* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(descriptor, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return ENOSPC;
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
  return 0;
}

}  // namespace mtf::io::module

extern "C" __attribute__((visibility("default"))) const mtf::io::Codecs* mtfkit_codecs_table() {
  namespace module = mtf::io::module;
  static const mtf::io::Codecs table{{mtf::version, mtf::git_commit},
                                     module::tiff_header,
                                     module::decode_png,
                                     module::decode_tiff,
                                     module::decode_jpeg,
                                     module::encode_png,
                                     module::encode_tiff};
  module::silence_tiff();
  return &table;
}
