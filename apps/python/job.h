// SPDX-License-Identifier: Apache-2.0
#pragma once

// Work that takes long, so that Ctrl-C ends it. It runs in a thread of its own while the one that called it, without
// the interpreter lock, looks for signals twenty times a second; the work asks `stopped()` where it can end.

#include <atomic>
#include <functional>

#include "mtf/error.h"

namespace apps::python {

/// The work was interrupted: never seen by users, who get KeyboardInterrupt.
class Interrupted : public mtf::RuntimeError {
 public:
  Interrupted() : RuntimeError("interrupted") {}
};

class JobControl {
 public:
  bool stopped() const { return stop_.load(std::memory_order_relaxed); }
  /// Throws Interrupted.
  void check() const {
    if (stopped()) throw Interrupted();
  }
  void stop() { stop_.store(true, std::memory_order_relaxed); }

 private:
  std::atomic<bool> stop_{false};
};

/// Runs `work`, called and to be called with the interpreter lock held. Throws what it throws; where a signal came,
/// the Python error of its handler.
void run_job(const std::function<void(JobControl&)>& work);

/// Hands the share of the work that is done to a Python function, which is called with the lock; an exception in it
/// ends the work and is what run_job throws.
class ProgressCall {
 public:
  ProgressCall(const void* function, JobControl& control);
  void operator()(double share) const;

 private:
  const void* function_;  // a Python object that the caller keeps, or null
  JobControl& control_;
};

}  // namespace apps::python
