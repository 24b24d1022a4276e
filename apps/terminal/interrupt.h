// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the process meets signals, broken pipes and missing standard streams.

namespace apps {

/// SIGINT, SIGTERM and SIGHUP remove the temporaries of unfinished output files and end the process with 130 at once. A
/// reader that goes away shows as a failed write instead of a signal, so that all is put in order first. Call it first
/// thing in main.
void prepare_process();

/// Ends the process as the signal of a broken pipe would have.
[[noreturn]] void end_by_broken_pipe();

/// While it lives, an interrupted process says `text` too: a literal that ends with a new line. One at a time.
class InterruptNote {
 public:
  explicit InterruptNote(const char* text);
  ~InterruptNote();
  InterruptNote(const InterruptNote&) = delete;
  InterruptNote& operator=(const InterruptNote&) = delete;
};

/// After `keep`, when there is something worth keeping, the first signal says `text`, a literal that ends with a new
/// line, and `asked` tells the work to come to its end; the second one ends the process. One at a time.
class StopInGoodOrder {
 public:
  explicit StopInGoodOrder(const char* text);
  ~StopInGoodOrder();
  StopInGoodOrder(const StopInGoodOrder&) = delete;
  StopInGoodOrder& operator=(const StopInGoodOrder&) = delete;

  void keep();
  bool asked() const;

 private:
  const char* text_;
};

}  // namespace apps
