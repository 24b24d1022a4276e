// SPDX-License-Identifier: Apache-2.0
#pragma once

// Work that takes long, so that Ctrl-C ends it. It runs in a thread of its own while the one that called it, without
// the interpreter lock, looks for signals twenty times a second. The parallel loops of the libraries end by themselves
// then (mtf/work/stop.h); work between them asks `stopped()` where it can end.

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>

#include "mtf/work/stop.h"

namespace apps::python {

class JobControl {
 public:
  bool stopped() const { return stop_.load(std::memory_order_relaxed); }
  /// Throws mtf::Stopped, which users never see: they get KeyboardInterrupt.
  void check() const {
    if (stopped()) throw mtf::Stopped();
  }
  void stop() { stop_.store(true, std::memory_order_relaxed); }
  const std::atomic<bool>* flag() const { return &stop_; }

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
  ProgressCall(const pybind11::object& function, JobControl& control) : function_(function), control_(control) {}
  void operator()(double share) const;

 private:
  pybind11::handle function_;  // of an object that the caller keeps, None for no function
  JobControl& control_;
};

}  // namespace apps::python
