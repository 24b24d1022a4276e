// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>

#include "mtf/error.h"

namespace radiometry::test {

/// Expects that `work` throws a UsageError whose message holds all the parts.
template <class Work>
void expect_refused(std::initializer_list<std::string_view> parts, Work work) {
  try {
    work();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const mtf::UsageError& error) {
    for (const std::string_view part : parts)
      EXPECT_NE(std::string_view(error.what()).find(part), std::string_view::npos)
          << "'" << part << "' is not in: " << error.what();
  }
}

}  // namespace radiometry::test
