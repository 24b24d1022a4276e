// SPDX-License-Identifier: Apache-2.0
#pragma once

// What holds for every page of `mtf characterize`.

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>

namespace apps_test {

inline std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// Names and titles occur once, every number is explained, charts have ticks along both axes and stay within them.
inline void expect_whole_page(const std::string& page) {
  using Matches = std::sregex_iterator;
  for (const char* const once : {" id=\"([^\"]*)\"", "(?:class=\"title\"[^>]*|<h[123])>([^<]*)<"}) {
    std::set<std::string> seen;
    const std::regex pattern(once);
    for (auto it = Matches(page.begin(), page.end(), pattern); it != Matches(); ++it)
      EXPECT_TRUE(seen.insert((*it)[1]).second) << (*it)[0];
  }
  const std::regex number("<code class=\"number\">([^<]*)</code>(<br><span class=\"why\">[A-Z])?");
  for (auto it = Matches(page.begin(), page.end(), number); it != Matches(); ++it)
    EXPECT_TRUE((*it)[2].matched) << (*it)[1] << " has no words";
  EXPECT_EQ(count_of(page, "no numbers to draw"), 0U);
  EXPECT_FALSE(std::regex_search(page, std::regex("\\bnan\\b")));
  const std::regex point("[ML]([0-9.]+) ([0-9.]+)");
  for (std::size_t at = page.find("<svg "); at != std::string::npos; at = page.find("<svg ", at + 1)) {
    const std::string chart = page.substr(at, page.find("</svg>", at) - at);
    const std::string name = chart.substr(0, chart.find("role=")) + chart.substr(chart.find("aria-label"), 60);
    EXPECT_GE(count_of(chart, "class=\"tick\" text-anchor=\"middle\""), 2U) << name;
    EXPECT_GE(count_of(chart, "class=\"tick\" text-anchor=\"end\""), 2U) << name;
    for (auto it = Matches(chart.begin(), chart.end(), point); it != Matches(); ++it) {
      const double x = std::stod((*it)[1]), y = std::stod((*it)[2]);
      EXPECT_TRUE(x >= 84.0 && x <= 530.0 && y >= 34.0 && y <= 328.0) << name << ": " << x << ", " << y;
    }
    EXPECT_EQ(count_of(chart, "<rect class=\"band\""), count_of(chart, "<path class=\"band ")) << name;
  }
}

}  // namespace apps_test
