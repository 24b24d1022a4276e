// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/interrupt.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <string_view>

#include "mtf/io/temporaries.h"

namespace apps {
namespace {

std::atomic<const char*> last_note = nullptr;  // global, because a signal handler has no arguments of its own
static_assert(std::atomic<const char*>::is_always_lock_free);

std::atomic<const char*> stop_note = nullptr;  ///< of StopInGoodOrder, after keep
std::atomic<bool> stop_asked = false;

void say(std::string_view text) {
  if (::write(STDERR_FILENO, text.data(), text.size()) < 0) ::_exit(130);
}

// Only async-signal-safe calls. Handlers of these signals block each other.
extern "C" void stop(int) {
  if (const char* text = stop_note; text != nullptr && !stop_asked.exchange(true)) return say(text);
  mtf::io::remove_temporaries();
  say("mtf: interrupted\n");
  if (const char* text = last_note) say(text);
  ::_exit(130);
}

}  // namespace

InterruptNote::InterruptNote(const char* text) { last_note = text; }
InterruptNote::~InterruptNote() { last_note = nullptr; }

StopInGoodOrder::StopInGoodOrder(const char* text) : text_(text) { stop_asked = false; }
StopInGoodOrder::~StopInGoodOrder() { stop_note = nullptr; }
void StopInGoodOrder::keep() { stop_note = text_; }
bool StopInGoodOrder::asked() const { return stop_asked; }

void prepare_process() {
  // A standard stream that is closed would give its number to the next file that is opened, which results or messages
  // would then be written into. Read-only for the outputs: writing has to fail as it would have.
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor)
    if (::fcntl(descriptor, F_GETFD) < 0) static_cast<void>(::open("/dev/null", O_RDONLY));

  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on file sizes shows as a failed write too
  struct sigaction action {};
  action.sa_handler = stop;
  sigemptyset(&action.sa_mask);
  sigaddset(&action.sa_mask, SIGINT);
  sigaddset(&action.sa_mask, SIGTERM);
  sigaddset(&action.sa_mask, SIGHUP);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);
}

void end_by_broken_pipe() {
  std::signal(SIGPIPE, SIG_DFL);
  std::raise(SIGPIPE);
  ::_exit(128 + SIGPIPE);
}

}  // namespace apps
