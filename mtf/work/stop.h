// SPDX-License-Identifier: Apache-2.0
#pragma once

// Work that its caller may end: an interrupt reaches loops at any depth without an argument of every function between.
// While a StopScope lives, parallel_for on its thread, and on the threads that share its pieces, looks at a flag before
// each piece and throws Stopped; loops that run on one thread ask `require_going_on` themselves. Without a scope
// neither costs anything.

#include <atomic>

#include "mtf/error.h"

namespace mtf {

/// The caller asked for an end.
class Stopped : public RuntimeError {
 public:
  Stopped() : RuntimeError("interrupted") {}
};

/// Lets `flag` end the work of this thread while it lives. Scopes nest; the innermost counts.
class StopScope {
 public:
  explicit StopScope(const std::atomic<bool>* flag);
  ~StopScope();
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  const std::atomic<bool>* outer_;
};

/// The flag of this thread, null without a scope: for work that hands pieces to threads of its own.
const std::atomic<bool>* stop_flag();

/// Throws Stopped when the flag of this thread is set.
void require_going_on();

}  // namespace mtf
