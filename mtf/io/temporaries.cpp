// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/temporaries.h"

#include <dirent.h>
#include <fcntl.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <climits>
#include <csignal>
#include <ctime>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

namespace mtf::io {
namespace {

constexpr std::string_view kMark = ".tmp.";
constexpr std::time_t kUntouched_s = 24 * 3600;

/// File systems that several machines may have mounted: their locks can be of one machine each.
bool is_shared(int descriptor) {
  constexpr std::array<long, 10> kShared{
      NFS_SUPER_MAGIC, SMB_SUPER_MAGIC,  CIFS_SUPER_MAGIC,        SMB2_SUPER_MAGIC,      CEPH_SUPER_MAGIC,
      AFS_SUPER_MAGIC, FUSE_SUPER_MAGIC, 0x0bd00bd0 /* Lustre */, 0x47504653 /* GPFS */, 0x19830326 /* BeeGFS */};
  struct statfs system {};
  return ::fstatfs(descriptor, &system) != 0 ||
         std::find(kShared.begin(), kShared.end(), static_cast<long>(system.f_type)) != kShared.end();
}

/// The process of "1234" or "1234.5"; nothing for a name that no AtomicFile has made.
std::optional<pid_t> process_of(std::string_view ending) {
  pid_t process = 0;
  int attempt = 0;
  const char* const end = ending.data() + ending.size();
  auto read = std::from_chars(ending.data(), end, process);
  if (read.ec == std::errc{} && read.ptr != end && *read.ptr == '.') read = std::from_chars(read.ptr + 1, end, attempt);
  return read.ec == std::errc{} && read.ptr == end && process > 0 ? std::optional(process) : std::nullopt;
}

bool runs(pid_t process) { return ::kill(process, 0) == 0 || errno != ESRCH; }

void remove_if_dead(const std::string& file, pid_t process) {
  // Of this process' own the lock alone says whether another thread is writing them.
  if (process != ::getpid() && runs(process)) return;
  const int descriptor = ::open(file.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  struct stat opened {};
  struct stat named {};
  const bool dead = ::fstat(descriptor, &opened) == 0 && S_ISREG(opened.st_mode) &&
                    (!is_shared(descriptor) || std::time(nullptr) - opened.st_mtime > kUntouched_s) &&
                    ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  // With the lock held a file of that name is still this one unless it was renamed before.
  if (dead && ::lstat(file.c_str(), &named) == 0 && named.st_ino == opened.st_ino && named.st_dev == opened.st_dev)
    ::unlink(file.c_str());
  ::close(descriptor);
}

struct Temporary {
  std::string name;
  pid_t process = 0;
};

/// Files with names of temporaries in a folder ("" or with its slash), as it was when this process first asked: a
/// sequence writes thousands of files, and what is to be found was left before.
const std::vector<Temporary>& temporaries_in(const std::string& folder) {
  static std::map<std::string, std::vector<Temporary>> known;
  static std::mutex lock;
  const std::lock_guard guard(lock);
  const auto [at, is_new] = known.try_emplace(folder);
  if (!is_new) return at->second;
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(::opendir(folder.empty() ? "." : folder.c_str()), &::closedir);
  while (const dirent* entry = entries ? ::readdir(entries.get()) : nullptr) {
    const std::string_view name = entry->d_name;
    const std::size_t mark = name.rfind(kMark);
    if (mark == std::string_view::npos) continue;
    if (const auto process = process_of(name.substr(mark + kMark.size())))
      at->second.push_back({std::string(name), *process});
  }
  return at->second;
}

}  // namespace

std::string temporary_stem(const std::string& target) {
  const std::size_t name = target.rfind('/') + 1;  // 0 without a folder
  return target.substr(0, std::min<std::size_t>(target.size(), name + NAME_MAX - 32)) + std::string(kMark);
}

bool claim_temporary(int descriptor) noexcept {
  while (::flock(descriptor, LOCK_EX) != 0 && errno == EINTR) {
  }
  struct stat status {};
  return ::fstat(descriptor, &status) != 0 || status.st_nlink > 0;
}

void remove_dead_temporaries(const std::string& target) {
  const std::string stem = temporary_stem(target), folder = stem.substr(0, stem.rfind('/') + 1);
  const std::string_view start = std::string_view(stem).substr(folder.size());
  for (const auto& [name, process] : temporaries_in(folder))
    if (name.rfind(kMark) + kMark.size() == start.size() && name.starts_with(start))
      remove_if_dead(folder + name, process);
}

}  // namespace mtf::io
