// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/temporaries.h"

#include <dirent.h>
#include <fcntl.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <climits>
#include <csignal>
#include <cstdint>
#include <cstring>
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

/// Whether the temporary of that process is a dead one's; then it is removed where that is asked for.
bool is_dead(const std::string& file, pid_t process, bool remove) {
  // Of this process' own the lock alone says whether another thread is writing them.
  if (process != ::getpid() && runs(process)) return false;
  const int descriptor = ::open(file.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return false;
  struct stat opened {};
  struct stat named {};
  const bool dead = ::fstat(descriptor, &opened) == 0 && S_ISREG(opened.st_mode) &&
                    (!is_shared(descriptor) || std::time(nullptr) - opened.st_mtime > kUntouched_s) &&
                    ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  // With the lock held a file of that name is still this one unless it was renamed before.
  if (dead && remove && ::lstat(file.c_str(), &named) == 0 && named.st_ino == opened.st_ino &&
      named.st_dev == opened.st_dev)
    ::unlink(file.c_str());
  ::close(descriptor);
  return dead;
}

/// The process of a file whose name is one of a temporary.
std::optional<pid_t> process_of_name(std::string_view name) {
  const std::size_t mark = name.rfind(kMark);
  return mark == std::string_view::npos ? std::nullopt : process_of(name.substr(mark + kMark.size()));
}

// A signal handler can neither lock nor allocate: names live in fixed slots, published by an atomic state.
enum SlotState : int { slot_free, slot_filling, slot_active };
struct Slot {
  std::atomic<int> state{slot_free};
  std::atomic<bool> beside_it{false};
  std::array<char, PATH_MAX> name{};
};
std::array<Slot, 32>& slots() {
  static constinit std::array<Slot, 32> all{};
  return all;
}

// Once the process is being stopped no file may be created any more.
std::atomic<bool>& stopping() {
  static constinit std::atomic<bool> value{false};
  return value;
}
std::atomic<int>& at_work() {
  static constinit std::atomic<int> count{0};
  return count;
}

/// All that is in the folder of this descriptor. Several passes: what is removed may hide what comes behind it.
bool empty_folder(int descriptor, int depth) noexcept {
  constexpr int kDeepest = 32;
  constexpr long kLength = 16, kName = 19;  // of linux_dirent64: the length of the entry, and its name
  for (bool removed = true; removed;) {
    removed = false;
    bool left = false;
    if (depth > kDeepest || ::lseek(descriptor, 0, SEEK_SET) != 0) return false;
    alignas(8) std::array<char, 4096> bytes;
    for (long size = 0; (size = ::syscall(SYS_getdents64, descriptor, bytes.data(), bytes.size())) > 0;)
      for (long at = 0; at < size;) {
        const char* const name = bytes.data() + at + kName;
        std::uint16_t length = 0;
        std::memcpy(&length, bytes.data() + at + kLength, sizeof length);
        at += length;
        if (std::strcmp(name, ".") == 0 || std::strcmp(name, "..") == 0) continue;
        bool gone = ::unlinkat(descriptor, name, 0) == 0;
        if (!gone && (errno == EISDIR || errno == EPERM)) {
          const int inner = ::openat(descriptor, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
          if (inner >= 0) {
            empty_folder(inner, depth + 1);
            ::close(inner);
            gone = ::unlinkat(descriptor, name, AT_REMOVEDIR) == 0;
          }
        }
        removed = removed || gone;
        left = left || !gone;
      }
    if (!left && !removed) return true;
  }
  return false;
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
    if (const auto process = process_of_name(name)) at->second.push_back({std::string(name), *process});
  }
  return at->second;
}

/// Guards that this thread holds: one inside another is part of its work.
int& held() {
  static thread_local constinit int count = 0;
  return count;
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
      is_dead(folder + name, process, true);
}

bool is_dead_temporary(const std::string& file) {
  const auto process = process_of_name(std::string_view(file).substr(file.rfind('/') + 1));
  return process && is_dead(file, *process, false);
}

bool is_shared(int descriptor) noexcept {
  constexpr std::array<long, 10> kShared{
      NFS_SUPER_MAGIC, SMB_SUPER_MAGIC,  CIFS_SUPER_MAGIC,        SMB2_SUPER_MAGIC,      CEPH_SUPER_MAGIC,
      AFS_SUPER_MAGIC, FUSE_SUPER_MAGIC, 0x0bd00bd0 /* Lustre */, 0x47504653 /* GPFS */, 0x19830326 /* BeeGFS */};
  struct statfs system {};
  return ::fstatfs(descriptor, &system) != 0 ||
         std::find(kShared.begin(), kShared.end(), static_cast<long>(system.f_type)) != kShared.end();
}

ListedTemporary::ListedTemporary(const std::string& name, bool beside_it) : slot_(-1) {
  if (name.size() >= PATH_MAX) return;
  for (std::size_t i = 0; i < slots().size() && slot_ < 0; ++i) {
    Slot& slot = slots()[i];
    int expected = slot_free;
    if (!slot.state.compare_exchange_strong(expected, slot_filling)) continue;
    std::memcpy(slot.name.data(), name.c_str(), name.size() + 1);
    slot.beside_it = beside_it;
    slot.state = slot_active;
    slot_ = static_cast<int>(i);
  }
}

ListedTemporary::~ListedTemporary() {
  if (slot_ >= 0) slots()[static_cast<std::size_t>(slot_)].state = slot_free;
}

Unstopped::Unstopped() {
  sigset_t stops;
  sigemptyset(&stops);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&stops, signal);
  pthread_sigmask(SIG_BLOCK, &stops, &before_);
  ++at_work();
  if (held()++ > 0 || !stopping()) return;
  --at_work();
  for (;;) ::pause();
}

Unstopped::~Unstopped() {
  --held();
  --at_work();
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void remove_temporaries() noexcept {
  const int saved = errno;
  stopping() = true;
  const timespec moment{0, 1'000'000};
  for (int waited = 0; at_work() > 0 && waited < 200; ++waited) ::nanosleep(&moment, nullptr);
  for (Slot& slot : slots()) {
    if (slot.state != slot_active) continue;
    char* const name = slot.name.data();
    if (::unlink(name) == 0 || (errno != EISDIR && errno != EPERM) || !remove_tree(name) || !slot.beside_it) continue;
    char* const end = std::strrchr(name, '/');
    if (end == nullptr || end == name) continue;
    *end = '\0';
    ::rmdir(name);
  }
  errno = saved;
}

bool remove_tree(const char* folder) noexcept {
  const int descriptor = ::open(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0) return errno == ENOENT;
  const bool empty = empty_folder(descriptor, 0);
  ::close(descriptor);
  return empty && ::rmdir(folder) == 0;
}

}  // namespace mtf::io
