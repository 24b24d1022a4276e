// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace mtf {

/// Base of every exception of the toolkit. `what()` is one message a user can act on: where, what, how to fix.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A wrong argument, parameter or configuration: the caller has to change the request (`mtf` exits with 2).
class UsageError : public Error {
 public:
  using Error::Error;
};

/// The data or the machine failed: unreadable or damaged file, disk full, memory refused (`mtf` exits with 1).
class RuntimeError : public Error {
 public:
  using Error::Error;
};

}  // namespace mtf
