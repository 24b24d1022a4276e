// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <memory>
#include <system_error>

#include "mtf/io/stage.h"

namespace mtf::io {
namespace {

constexpr std::size_t buffer_bytes = 256 * 1024;

std::string remedy(int e) {
  if (e == ENOSPC || e == EDQUOT) return "free space or choose another folder";
  if (e == EACCES || e == EPERM || e == EROFS) return "choose a folder you may write to";
  if (e == EFBIG) return "the file system or a limit (ulimit -f) does not allow a file of this size";
  return "choose another file";
}

// Returns 0 or the error number; a short write is continued.
int write_all(int descriptor, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return ENOSPC;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return 0;
}

std::string resolved(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr), &std::free);
  return real ? std::string(real.get()) : path;
}

}  // namespace

std::string folder_of_file(const std::string& path) {
  const auto slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

void fail_to_write(const std::string& path, int error_number) {
  if (error_number == EPIPE) throw BrokenPipe(path + ": its reader has gone");
  throw RuntimeError("cannot write " + path + ": " + std::generic_category().message(error_number) + "; " +
                     remedy(error_number));
}

void sync_folder(const std::string& name) {
  const int folder = ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  static_cast<void>(::fsync(folder));
  ::close(folder);
}

AtomicFile::AtomicFile(const std::string& path) : shown_(without_stages(path)), target_(path) {
  if (path.empty()) throw UsageError("cannot write a file without a name; give the output file a name");
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode))
    throw RuntimeError("cannot write " + shown_ + ": it is a folder; name a file in it");
  if (exists && !S_ISREG(status.st_mode))
    throw RuntimeError("cannot write " + shown_ + ": it is a device or pipe; images need an ordinary file");
  if (exists && ::access(path.c_str(), W_OK) != 0) fail_to_write(shown_, errno);
  if (exists) target_ = resolved(path);

  const std::string folder = folder_of_file(target_);
  struct stat folder_status {};
  const int folder_error = ::stat(folder.c_str(), &folder_status) != 0 ? errno : 0;
  if (folder_error != 0 && folder_error != ENOENT && folder_error != ENOTDIR) fail_to_write(shown_, folder_error);
  if (folder_error != 0 || !S_ISDIR(folder_status.st_mode))
    throw RuntimeError("cannot write " + shown_ + ": folder " + without_stages(folder) +
                       " does not exist; create it or choose another");

  const std::string base = target_.substr(target_.rfind('/') + 1);
  if (base.empty()) throw RuntimeError("cannot write " + shown_ + ": it names a folder; name a file in it");
  if (base.size() > NAME_MAX) fail_to_write(shown_, ENAMETOOLONG);
  remove_dead_temporaries(target_);
  const std::string stem = temporary_stem(target_) + std::to_string(::getpid());
  temporary_ = stem;
  // Another thread may be writing the same target.
  for (int attempt = 1; attempt <= 100; ++attempt) {
    const Unstopped creation;
    listed_.emplace(temporary_);
    descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ >= 0 && claim_temporary(descriptor_)) break;
    const int error_number = descriptor_ >= 0 ? EEXIST : errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
    listed_.reset();
    if (error_number != EEXIST || attempt == 100) fail_to_write(shown_, error_number);
    temporary_ = stem + "." + std::to_string(attempt);
  }
  if (exists) static_cast<void>(::fchmod(descriptor_, status.st_mode & 0777));
  buffer_.reserve(buffer_bytes);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(temporary_.c_str());
  listed_.reset();
}

void AtomicFile::check(int error_number) {
  if (error_ == 0) error_ = error_number;
  if (error_ != 0) fail_to_write(shown_, error_);
}

void AtomicFile::flush() {
  check(0);
  const int error_number = write_all(descriptor_, buffer_.data(), buffer_.size());
  buffer_.clear();
  check(error_number);
}

void AtomicFile::write(const void* data, std::size_t size) {
  if (buffer_.size() + size > buffer_bytes) flush();
  if (size >= buffer_bytes) {
    check(write_all(descriptor_, static_cast<const char*>(data), size));
  } else {
    const char* bytes = static_cast<const char*>(data);
    buffer_.insert(buffer_.end(), bytes, bytes + size);
  }
  position_ += size;
}

void AtomicFile::seek(std::uint64_t position) {
  if (position == position_) return;
  flush();
  if (::lseek(descriptor_, static_cast<off_t>(position), SEEK_SET) < 0) check(errno);
  position_ = position;
}

bool AtomicFile::keep_as(const std::string& path) {
  flush();
  if (::fsync(descriptor_) != 0) check(errno);
  struct stat own {
  }, other{};
  if (::fstat(descriptor_, &own) != 0) check(errno);
  // A rename of one name of a file to another name of it would do nothing and leave both.
  if (::stat(path.c_str(), &other) == 0 && own.st_dev == other.st_dev && own.st_ino == other.st_ino) return true;
  const std::string second = temporary_stem(target_) + std::to_string(::getpid()) + ".0";
  ::unlink(second.c_str());
  if (::link(temporary_.c_str(), second.c_str()) != 0) return false;
  if (::rename(second.c_str(), path.c_str()) != 0) {
    const int error_number = errno;
    ::unlink(second.c_str());
    fail_to_write(path, error_number);
  }
  sync_folder(folder_of_file(path));
  return true;
}

void AtomicFile::commit() {
  flush();
  if (::fsync(descriptor_) != 0) check(errno);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) check(errno);
  listed_.reset();
  ::close(descriptor_);
  descriptor_ = -1;
  sync_folder(folder_of_file(target_));
}

void write_text_file(const std::string& path, std::string_view text) {
  struct stat status {};
  const bool direct = ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
  if (!direct) {
    AtomicFile file(path);
    file.write(text.data(), text.size());
    file.commit();
    return;
  }
  // A standard stream is there already: to open a pipe again would wait for a reader that may have gone.
  int descriptor = -1;
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat opened {};
    const bool same = ::fstat(stream, &opened) == 0 && opened.st_dev == status.st_dev && opened.st_ino == status.st_ino;
    if (descriptor < 0 && same) descriptor = ::dup(stream);
  }
  if (descriptor < 0) descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) fail_to_write(path, errno);
  const int error_number = write_all(descriptor, text.data(), text.size());
  ::close(descriptor);
  if (error_number != 0) fail_to_write(path, error_number);
}

}  // namespace mtf::io
