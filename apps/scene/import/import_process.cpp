// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/import_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <system_error>
#include <utility>
#include <vector>

#include "mtf/error.h"

namespace apps::scene {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void refuse(int error_number) {
  throw mtf::RuntimeError("cannot start the process that reads mesh files: " +
                          std::generic_category().message(error_number));
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(std::exchange(number_, -1));
  }

 private:
  int number_;
};

/// Killed and waited for at the latest when it goes out of scope.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  ~Child() {
    if (id_ > 0) kill();
    if (id_ > 0) wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void kill() const { ::kill(id_, SIGKILL); }
  /// The status as waitpid gives it.
  int wait() {
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
  }

 private:
  pid_t id_;
};

/// Standard input and output as given, errors nowhere, no other descriptor; signals as a fresh process has them.
pid_t spawn(const std::filesystem::path& program, std::vector<std::string> words, int in, int out) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t set;
  sigemptyset(&set);
  posix_spawnattr_setsigmask(&attributes, &set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU}) sigaddset(&set, signal);
  posix_spawnattr_setsigdefault(&attributes, &set);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) refuse(error);
  return child;
}

/// All that comes until the other end is closed, but not more than `most` bytes.
ImportEnd receive(int descriptor, Clock::time_point deadline, std::uint64_t most, std::string& bytes) {
  std::vector<char> piece(std::size_t{1} << 18U);
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return ImportEnd::too_long;
    pollfd end{descriptor, POLLIN, 0};
    const int ready = ::poll(&end, 1, static_cast<int>(std::min<std::int64_t>(left.count(), 1 << 30)));
    if (ready < 0 && errno != EINTR) return ImportEnd::crashed;
    if (ready <= 0) continue;
    const ssize_t count = ::read(descriptor, piece.data(), piece.size());
    if (count == 0) return ImportEnd::sent;
    if (count < 0 && errno != EINTR) return ImportEnd::crashed;
    if (count < 0) continue;
    if (static_cast<std::uint64_t>(count) > most - bytes.size()) return ImportEnd::too_large;
    bytes.append(piece.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

ImportRun run_import(const ImportRequest& request) {
  const std::filesystem::path program = import_program();
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) refuse(errno);
  const Descriptor out(ends[0]);
  Descriptor in(ends[1]);
  Child child(spawn(program,
                    {program.string(), request.extension, request.folder.string(), std::to_string(request.memory_bytes),
                     std::to_string(request.cpu_s), std::to_string(request.output_bytes)},
                    request.descriptor, in.number()));
  in.close();

  ImportRun run;
  const auto deadline = Clock::now() + std::chrono::seconds(import_patience * request.cpu_s);
  run.end = receive(out.number(), deadline, request.output_bytes, run.bytes);
  if (run.end != ImportEnd::sent) child.kill();
  const int status = child.wait();
  if (run.end == ImportEnd::sent && WIFSIGNALED(status))
    run.end = WTERMSIG(status) == SIGXCPU ? ImportEnd::too_long : ImportEnd::crashed;
  if (run.end == ImportEnd::sent && (!WIFEXITED(status) || WEXITSTATUS(status) != 0)) run.end = ImportEnd::crashed;
  return run;
}

}  // namespace apps::scene
