// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a test asks of a message: its kind (the type of the exception, or the exit code), its place (file:line:column,
// key or option) and its remedy (a key, unit, value, or the word that tells what to do). The sentence around them may
// change; so parts are short, four words at most. A failure is reported at the line of the test that asks. As gtest's
// own EXPECT_ these stand in no namespace: tests of every library use them.

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "mtf/error.h"

inline bool says(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

/// That one of the texts (warnings, notes) says it.
inline bool says(std::span<const std::string> texts, std::string_view part) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) { return says(text, part); });
}

inline void expect_says(std::string_view text, std::initializer_list<std::string_view> parts,
                        const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  for (const std::string_view part : parts)
    if (!says(text, part)) ADD_FAILURE_AT(file, line) << "'" << part << "' is not in: " << text;
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
template <class Error = mtf::UsageError, class Work>
std::string expect_refused(std::initializer_list<std::string_view> parts, Work work,
                           const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  const std::string message = message_of<Error>(work);
  if (message.empty())
    ADD_FAILURE_AT(file, line) << "nothing was thrown";
  else
    expect_says(message, parts, file, line);
  return message;
}
