// SPDX-License-Identifier: Apache-2.0
#include "mtf/work/stop.h"

namespace mtf {
namespace {

/// Of a thread, for as long as a scope of it lives: state of a call, which no other call sees.
thread_local const std::atomic<bool>* flag_of_thread = nullptr;

}  // namespace

StopScope::StopScope(const std::atomic<bool>* flag) : outer_(flag_of_thread) { flag_of_thread = flag; }

StopScope::~StopScope() { flag_of_thread = outer_; }

const std::atomic<bool>* stop_flag() { return flag_of_thread; }

void require_going_on() {
  if (flag_of_thread != nullptr && flag_of_thread->load(std::memory_order_relaxed)) throw Stopped();
}

}  // namespace mtf
