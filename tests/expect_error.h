// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a test asks of a message: its kind (the type of the exception, or the exit code), its place (file:line:column,
// key or option) and its remedy (a key, unit, value, or the word that tells what to do). The sentence around them may
// change; so parts are short, and capitals do not matter.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string>
#include <string_view>

#include "mtf/error.h"

namespace mtf::test {

inline bool says(std::string_view message, std::string_view part) {
  const auto same = [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); };
  return std::search(message.begin(), message.end(), part.begin(), part.end(), same) != message.end();
}

inline void expect_says(std::string_view message, std::initializer_list<std::string_view> parts) {
  for (const std::string_view part : parts)
    EXPECT_TRUE(says(message, part)) << "'" << part << "' is not in: " << message;
}

/// Message of the Error that `work` throws; "" where it throws none.
template <class Error = mtf::Error, class Work>
std::string message_of(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Expects that `work` throws an Error (UsageError, RuntimeError) whose message says all the parts; returns the
/// message.
template <class Error = UsageError, class Work>
std::string expect_refused(std::initializer_list<std::string_view> parts, Work work) {
  const std::string message = message_of<Error>(work);
  EXPECT_NE(message, "") << "nothing was thrown";
  expect_says(message, parts);
  return message;
}

}  // namespace mtf::test

namespace radiometry::test {
using mtf::test::expect_refused;
}
