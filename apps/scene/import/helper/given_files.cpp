// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/given_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace apps::scene {
namespace {

namespace fs = std::filesystem;

class Bytes : public Assimp::IOStream {
 public:
  explicit Bytes(std::string content) : content_(std::move(content)) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (content_.size() - at_) / size);
    std::memcpy(to, content_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    // From the end Assimp means "that many bytes before it".
    const std::size_t start = origin == aiOrigin_CUR ? at_ : 0;
    if (offset > content_.size() - start) return aiReturn_FAILURE;
    at_ = origin == aiOrigin_END ? content_.size() - offset : start + offset;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return content_.size(); }
  void Flush() override {}

 private:
  std::string content_;
  std::size_t at_ = 0;
};

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
  return name.is_relative() &&
         std::none_of(name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

// Ordinary files only: the descriptor, or -1. Opening a pipe would wait for its other end but for O_NONBLOCK.
int open_ordinary(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  struct stat status {};
  if (descriptor >= 0 && ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) return descriptor;
  if (descriptor >= 0) ::close(descriptor);
  return -1;
}

int open_buffer(const fs::path& folder, const char* file) {
  if (folder.empty()) return -1;
  for (const std::string& name : {std::string(file), percent_decoded(file)}) {
    const int descriptor = stays_inside(name) ? open_ordinary(folder / name) : -1;
    if (descriptor >= 0) return descriptor;
  }
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

GivenFiles::GivenFiles(std::string name, std::string content, fs::path folder)
    : name_(std::move(name)), content_(std::move(content)), folder_(std::move(folder)) {}

bool GivenFiles::Exists(const char* file) const {
  if (file == name_) return true;
  const int descriptor = open_buffer(folder_, file);
  if (descriptor >= 0) ::close(descriptor);
  return descriptor >= 0;
}

Assimp::IOStream* GivenFiles::Open(const char* file, const char*) {
  if (file == name_) return new Bytes(content_);
  const int descriptor = open_buffer(folder_, file);
  if (descriptor < 0) return nullptr;
  std::string content = read_all(descriptor);
  ::close(descriptor);
  return new Bytes(std::move(content));
}

void GivenFiles::Close(Assimp::IOStream* stream) { delete stream; }

}  // namespace apps::scene
