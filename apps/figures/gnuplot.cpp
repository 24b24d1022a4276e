// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/gnuplot.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <string_view>
#include <system_error>

#include "mtf/error.h"
#include "mtf/words.h"

namespace apps {
namespace {

constexpr std::chrono::seconds kPatience{60};

class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    close();
    number_ = other.release();
    return *this;
  }
  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int release() {
    const int number = number_;
    number_ = -1;
    return number;
  }
  int number_;
};

struct Pipe {
  Descriptor read, write;
};

Pipe make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw mtf::RuntimeError("cannot start gnuplot: " + std::generic_category().message(errno));
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

/// The process id, or 0 when there is no gnuplot.
pid_t spawn(const Pipe& in, const Pipe& out, const Pipe& err) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in.read.number(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out.write.number(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.write.number(), STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);

  std::array<std::string, 3> words{"gnuplot", "--default-settings", "-"};
  std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, "gnuplot", &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error == ENOENT || error == EACCES || error == ENOTDIR) return 0;
  if (error != 0) throw mtf::RuntimeError("cannot start gnuplot: " + std::generic_category().message(error));
  return child;
}

/// Reads what is there; closes at the end of the stream.
void drain(Descriptor& from, std::string& to) {
  std::array<char, 65536> bytes{};
  const ssize_t count = ::read(from.number(), bytes.data(), bytes.size());
  if (count > 0)
    to.append(bytes.data(), static_cast<std::size_t>(count));
  else if (count == 0 || errno != EINTR)
    from.close();
}

/// Feeds and empties the pipes at once, so that neither side waits for the other. False when time is up.
bool exchange(std::string_view script, Descriptor& in, Descriptor& out, Descriptor& err, std::string& figure,
              std::string& messages) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  ::fcntl(in.number(), F_SETFL, O_NONBLOCK);
  while (out.number() >= 0 || err.number() >= 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    std::array<pollfd, 3> ends{{{in.number(), POLLOUT, 0}, {out.number(), POLLIN, 0}, {err.number(), POLLIN, 0}}};
    if (::poll(ends.data(), ends.size(), static_cast<int>(left.count())) < 0 && errno != EINTR) return false;
    if (ends[0].revents != 0) {
      const ssize_t count = ::write(in.number(), script.data(), script.size());
      if (count > 0) script.remove_prefix(static_cast<std::size_t>(count));
      if (script.empty() || (count < 0 && errno != EAGAIN && errno != EINTR)) in.close();
    }
    if (ends[1].revents != 0) drain(out, figure);
    if (ends[2].revents != 0) drain(err, messages);
  }
  return true;
}

std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return mtf::printable(text.substr(text.rfind('\n') + 1));
}

}  // namespace

std::optional<std::string> run_gnuplot(const std::string& script) {
  Pipe in = make_pipe(), out = make_pipe(), err = make_pipe();
  const pid_t child = spawn(in, out, err);
  if (child == 0) return std::nullopt;
  in.read.close();
  out.write.close();
  err.write.close();
  std::string figure, messages;
  const bool in_time = exchange(script, in.write, out.read, err.read, figure, messages);
  if (!in_time) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!in_time) throw mtf::RuntimeError("gnuplot did not finish within a minute; the data are in the CSV file");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || figure.empty())
    throw mtf::RuntimeError("gnuplot failed: " + (messages.empty() ? "it drew nothing" : last_line(messages)) +
                            "; the data are in the CSV file");
  return figure;
}

}  // namespace apps
