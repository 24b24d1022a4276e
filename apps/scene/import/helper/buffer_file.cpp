// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/buffer_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <stdexcept>
#include <system_error>

namespace apps::scene {
namespace {

namespace fs = std::filesystem;

// "%20" is a blank: glTF names its buffers by URI (RFC 3986).
std::string percent_decoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned value = 0;
    const bool escape = text[i] == '%' && i + 2 < text.size() &&
                        std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16).ptr == text.data() + i + 3;
    decoded += escape ? static_cast<char>(value) : text[i];
    if (escape) i += 2;
  }
  return decoded;
}

// Whether the name stays in the folder: relative, and never upwards.
bool stays_inside(const fs::path& name) {
  return name.is_relative() && std::ranges::none_of(name, [](const fs::path& part) { return part == ".."; });
}

// Ordinary files only: the descriptor, or -1. Opening a pipe would wait for its other end but for O_NONBLOCK.
int open_ordinary(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  struct stat status {};
  if (descriptor >= 0 && ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) return descriptor;
  if (descriptor >= 0) ::close(descriptor);
  return -1;
}

}  // namespace

std::string read_all(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) throw std::runtime_error("it cannot be read");
  std::string content(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t have = 0;
  while (have < content.size()) {
    const ssize_t count = ::read(descriptor, content.data() + have, content.size() - have);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw std::runtime_error("it cannot be read: " + std::generic_category().message(errno));
    if (count == 0) break;
    have += static_cast<std::size_t>(count);
  }
  content.resize(have);
  return content;
}

std::optional<std::string> buffer_file(const fs::path& folder, std::string_view uri) {
  if (folder.empty()) return std::nullopt;
  for (const std::string& name : {std::string(uri), percent_decoded(uri)}) {
    const int descriptor = stays_inside(name) ? open_ordinary(folder / name) : -1;
    if (descriptor < 0) continue;
    std::string content = read_all(descriptor);
    ::close(descriptor);
    return content;
  }
  return std::nullopt;
}

}  // namespace apps::scene
