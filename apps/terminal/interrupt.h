// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the process meets signals, broken pipes and missing standard streams.

namespace apps {

/// SIGINT, SIGTERM and SIGHUP remove the temporaries of unfinished output files and end the process with 130 at once. A
/// reader that goes away shows as a failed write instead of a signal. Call it first thing in main.
void prepare_process();

/// While it lives, an interrupted process says `text` too: a literal that ends with a new line. One at a time.
class InterruptNote {
 public:
  explicit InterruptNote(const char* text);
  ~InterruptNote();
  InterruptNote(const InterruptNote&) = delete;
  InterruptNote& operator=(const InterruptNote&) = delete;
};

}  // namespace apps
