// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/stage.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <ctime>
#include <filesystem>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"

namespace mtf::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kStageMark = ".mtf-new";

bool is_there(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

void make_folder(const std::string& path, const std::string& shown) {
  if (::mkdir(path.c_str(), 0777) != 0 && errno != EEXIST) fail_to_write(shown, errno);
}

/// The folders of "a/b/name" below `root`.
void make_folders(const std::string& root, const std::string& name) {
  for (std::size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1))
    make_folder(root + "/" + name.substr(0, slash), without_stages(root + "/" + name.substr(0, slash)));
}

/// Files and empty folders below a folder, sorted; folders end with a slash.
std::vector<std::string> names_below(const std::string& root) {
  std::vector<std::string> names;
  if (!is_there(root)) return names;
  try {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
      const bool folder = entry.is_directory() && !entry.is_symlink();
      if (folder && !fs::is_empty(entry.path())) continue;
      names.push_back(entry.path().string().substr(root.size() + 1) + (folder ? "/" : ""));
    }
  } catch (const fs::filesystem_error& failed) {  // half of the names would be half of the files
    throw RuntimeError("cannot read " + root + ": " + failed.code().message());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

std::string text_of(int descriptor) {
  std::array<char, 320> bytes{};
  const ssize_t size = ::pread(descriptor, bytes.data(), bytes.size(), 0);
  return std::string(bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
}

/// Of another machine, which may live although its lock is not seen here.
bool may_be_elsewhere(int lock) {
  constexpr std::time_t kLatest_s = 24 * 3600;
  const std::string text = text_of(lock);
  struct stat status {};
  return is_shared(lock) && !text.empty() && text.find(" on " + host_name() + "\n") == std::string::npos &&
         ::fstat(lock, &status) == 0 && std::time(nullptr) - status.st_mtime < kLatest_s;
}

}  // namespace

bool is_stage(const std::string& name) { return name.starts_with('.') && name.ends_with(kStageMark); }

std::string without_stages(std::string text) {
  const std::string inner = std::string(kStageMark) + "/new/";
  for (std::size_t at = text.find(inner); at != std::string::npos; at = text.find(inner)) {
    const std::size_t begin = text.rfind('/', at) + 1;
    text.erase(begin, at + inner.size() - begin);
    // What is in the current folder is named without it.
    if (begin >= 2 && text.compare(begin - 2, 2, "./") == 0 &&
        (begin == 2 || (text[begin - 3] != '/' && text[begin - 3] != '.')))
      text.erase(begin - 2, 2);
  }
  return text;
}

Stage::Stage(std::string folder, const std::string& name, bool fresh, const std::string& shown)
    : folder_(std::move(folder)), fresh_(fresh) {
  constexpr std::size_t kLongest = NAME_MAX - 16;
  stage_ = folder_ + "/" + (name.empty() ? "" : "." + name.substr(0, kLongest)) + std::string(kStageMark);
  open(shown);
  try {
    if (is_there(stage_ + "/ready")) {  // of a process that was killed while it moved them
      move();
      finish();
    }
    for (const char* part : {"new", "gone", "old"}) remove_tree((stage_ + "/" + part).c_str());
    make_folder(stage_ + "/new", shown);
  } catch (...) {
    close();
    throw;
  }
}

void Stage::open(const std::string& shown) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    const Unstopped making;
    make_folder(stage_, shown);
    const std::string file = stage_ + "/lock";
    lock_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (lock_ < 0 && errno == ENOENT) continue;  // its last owner has just removed it
    if (lock_ < 0) fail_to_write(shown, errno);
    const bool locked = ::flock(lock_, LOCK_EX | LOCK_NB) == 0;
    if ((!locked && errno == EWOULDBLOCK) || may_be_elsewhere(lock_)) {
      const std::string who = text_of(lock_);
      ::close(lock_);
      lock_ = -1;
      throw RuntimeError(shown + ": another mtf" + (who.empty() ? "" : " (" + who.substr(0, who.find('\n')) + ")") +
                         " is writing there; wait for its end, or choose another place");
    }
    // File systems without locks are trusted: nothing is known of others there.
    struct stat mine {
    }, named{};
    if (::fstat(lock_, &mine) == 0 && ::stat(file.c_str(), &named) == 0 && mine.st_ino == named.st_ino) {
      const std::string who = "process " + std::to_string(::getpid()) + " on " + host_name() + "\n";
      if (::ftruncate(lock_, 0) != 0 || ::pwrite(lock_, who.data(), who.size(), 0) < 0) errno = 0;  // for messages only
      if (!is_there(stage_ + "/ready")) listed_.emplace(stage_, fresh_);
      return;
    }
    ::close(lock_);  // its last owner has removed it meanwhile
    lock_ = -1;
  }
  fail_to_write(shown, EAGAIN);
}

Stage::~Stage() { close(); }

void Stage::close() noexcept {
  if (!steps_.empty() || committing_) undo();
  // The lock goes last: whoever comes finds either all of the stage with the lock held, or none.
  if (!is_there(stage_ + "/ready")) {
    for (const char* part : {"new", "gone", "old"}) remove_tree((stage_ + "/" + part).c_str());
    ::unlink((stage_ + "/lock").c_str());
    ::rmdir(stage_.c_str());
  }
  ::close(lock_);
}

std::string Stage::at(const std::string& name) const {
  make_folder(stage_ + "/new", folder_);
  if (name.empty()) return stage_ + "/new";
  make_folders(stage_ + "/new", name);
  return in("new", name);
}

std::vector<std::string> Stage::names() const { return names_below(stage_ + "/new"); }

void Stage::make_ready(const std::vector<std::string>& gone) {
  const std::vector<std::string> written = names();
  make_folder(stage_ + "/gone", folder_);
  make_folder(stage_ + "/old", folder_);
  for (const std::string& name : gone) {
    // Of a folder that is written anew every file goes, too: none of two runs stand together.
    const bool stays = std::find(written.begin(), written.end(), name) != written.end();
    if (stays || !is_there(folder_ + "/" + name)) continue;
    make_folders(stage_ + "/gone", name);
    const int file = ::open(in("gone", name).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) fail_to_write(folder_ + "/" + name, errno);
    ::close(file);
  }
  sync_folder(stage_ + "/gone");
  listed_.reset();
  committing_ = true;
  if (::rename((stage_ + "/new").c_str(), (stage_ + "/ready").c_str()) != 0) fail_to_write(folder_, errno);
  sync_folder(stage_);
}

void Stage::set_aside(const std::string& name) {
  Step& step = steps_.emplace_back(Step{name});
  make_folders(stage_ + "/old", name);
  if (::rename((folder_ + "/" + name).c_str(), in("old", name).c_str()) == 0)
    step.replaced = true;
  else if (errno != ENOENT)
    fail_to_write(folder_ + "/" + name, errno);
}

void Stage::place(const std::string& name) {
  const std::string target = folder_ + "/" + name, from = in("ready", name), old = in("old", name);
  make_folders(folder_, name);
  if (name.ends_with('/')) {
    ::rmdir(from.c_str());
    return;
  }
  Step& step = steps_.emplace_back(Step{name});
  struct stat status {};
  if (::lstat(target.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode))
      throw RuntimeError("cannot write " + target + ": it is a folder; move it, or choose another place");
    if (S_ISREG(status.st_mode)) {
      if (::access(target.c_str(), W_OK) != 0) fail_to_write(target, errno);
      ::chmod(from.c_str(), status.st_mode & 0777);
    }
    make_folders(stage_ + "/old", name);
    // A second name, so that there is a file of that name at all times; without second names, a moment later.
    if (::link(target.c_str(), old.c_str()) != 0 && errno != EEXIST && ::rename(target.c_str(), old.c_str()) != 0)
      fail_to_write(target, errno);
    step.replaced = true;
  }
  if (::rename(from.c_str(), target.c_str()) != 0) fail_to_write(target, errno);
  step.placed = true;
}

void Stage::move() {
  const Unstopped moving;
  for (const std::string& name : names_below(stage_ + "/gone")) {
    set_aside(name);
    ::unlink(in("gone", name).c_str());
  }
  for (const std::string& name : names_below(stage_ + "/ready")) place(name);
  sync_folder(folder_);
}

void Stage::undo() noexcept {
  const Unstopped moving;
  for (; !steps_.empty(); steps_.pop_back()) {
    const Step& step = steps_.back();
    const std::string target = folder_ + "/" + step.name;
    if (step.placed) ::rename(target.c_str(), in("ready", step.name).c_str());
    if (step.replaced && ::rename(in("old", step.name).c_str(), target.c_str()) != 0) stuck_ = true;
  }
  if (committing_ && !stuck_ && ::rename((stage_ + "/ready").c_str(), (stage_ + "/new").c_str()) == 0)
    listed_.emplace(stage_, fresh_);
  committing_ = false;
  sync_folder(folder_);
}

void Stage::finish() noexcept {
  const Unstopped finishing;
  committing_ = false;
  steps_.clear();
  for (const char* part : {"old", "gone", "ready"}) remove_tree((stage_ + "/" + part).c_str());
  fresh_ = false;
  listed_.emplace(stage_);
}

}  // namespace mtf::io
