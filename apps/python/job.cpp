// SPDX-License-Identifier: Apache-2.0
#include "apps/python/job.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace apps::python {

namespace py = pybind11;

void run_job(const std::function<void(JobControl&)>& work) {
  JobControl control;
  std::exception_ptr failure;
  std::mutex mutex;
  std::condition_variable finished;
  bool done = false;
  std::thread worker;
  bool interrupted = false;
  {
    const py::gil_scoped_release free;
    worker = std::thread([&] {
      try {
        const mtf::StopScope scope(control.flag());
        work(control);
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      done = true;
      finished.notify_one();
    });
    std::unique_lock lock(mutex);
    constexpr auto kLook = std::chrono::milliseconds(50);
    while (!finished.wait_for(lock, kLook, [&] { return done; })) {
      lock.unlock();
      {
        const py::gil_scoped_acquire held;
        if (!interrupted && PyErr_CheckSignals() != 0) interrupted = true;
        if (interrupted) control.stop();
      }
      lock.lock();
    }
    lock.unlock();
    worker.join();
  }
  // The error of the signal's handler stays set from PyErr_CheckSignals on.
  if (interrupted) throw py::error_already_set();
  if (failure) std::rethrow_exception(failure);
}

void ProgressCall::operator()(double share) const {
  control_.check();
  if (function_.is_none()) return;
  const py::gil_scoped_acquire held;
  function_(share);
}

}  // namespace apps::python
