// SPDX-License-Identifier: Apache-2.0
#pragma once

// Output files that appear whole or not at all: bytes go to `name.tmp.<pid>` in the same folder; `commit` flushes,
// syncs and renames. Without a commit (exception, early return) the temporary is removed and the old file stays. One
// that a killed process left is removed when the file is written again (temporaries.h).

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/temporaries.h"

namespace mtf::io {

/// One file being written. Movable neither nor copyable: the temporary is on the list of `remove_temporaries`.
/// A symbolic link is followed (its target is replaced); an existing file keeps its permissions.
class AtomicFile {
 public:
  /// Creates the temporary. Throws RuntimeError naming the folder that is missing or not writable, and when `path` is a
  /// folder or a device.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends at the current position (buffered). Throws RuntimeError with the reason (disk full, ...); the failure is
  /// kept and `commit` reports it again, so a library that swallows exceptions cannot hide it.
  void write(const void* data, std::size_t size);
  void seek(std::uint64_t position);
  std::uint64_t position() const { return position_; }

  /// Descriptor for code that writes by itself; what it wrote has to be complete before `commit`.
  int descriptor() const { return descriptor_; }
  /// Reports an error number of such code, 0 for none: throws as `write` does.
  void check(int error_number);

  /// Gives what has been written so far a second name, `path` on the same file system, which stays when the process is
  /// killed; what stood there is replaced. The bytes are on the disk when this returns. Later ones are written to the
  /// same file. False where the file system gives no second names.
  bool keep_as(const std::string& path);

  /// Flush, fsync, rename, fsync of the folder. Throws RuntimeError and removes the temporary when any of it fails.
  void commit();

 private:
  void flush();

  std::string shown_;   // as the user named it, for messages
  std::string target_;  // after symbolic links
  std::string temporary_;
  std::vector<char> buffer_;
  std::uint64_t position_ = 0;
  int descriptor_ = -1;
  std::optional<ListedTemporary> listed_;
  int error_ = 0;
};

/// Writes a whole text file in one go. A device or pipe such as /dev/stdout is written directly. Throws RuntimeError.
void write_text_file(const std::string& path, std::string_view text);

/// Nobody reads what is written to a pipe any more: no fault of anybody, and the end of the command without a word.
class BrokenPipe : public RuntimeError {
 public:
  using RuntimeError::RuntimeError;
};

/// Throws RuntimeError that `path` cannot be written, with the reason and the remedy for that error number.
[[noreturn]] void fail_to_write(const std::string& path, int error_number);

/// "." for a file in the current folder.
std::string folder_of_file(const std::string& path);

/// The names in a folder are written to the disk; a file system that cannot sync folders has done what it can.
void sync_folder(const std::string& name);

}  // namespace mtf::io
