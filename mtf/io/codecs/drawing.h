// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is drawn over the preview of an image: lines and words.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace mtf::io {

using Colour = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// A line through points in pixels of the image, (0, 0) its outer corner.
struct Stroke {
  std::vector<std::array<double, 2>> points;
  Colour colour{};
};

/// Words in ASCII. (x, y) is a place on their base line, in pixels of the image: the left end for an alignment of 0,
/// the middle for 0.5, the right end for 1. Capital letters are 9 pixels of the picture high, times `size`.
struct Caption {
  double x = 0.0, y = 0.0;
  std::string text;
  Colour colour{};
  double size = 1.0, alignment = 0.0;
};

struct Drawing {
  int zoom = 1;               ///< the picture is this many times the image a side, 1 to 16
  bool false_colour = false;  ///< grey values as colours from black through red and yellow to white (inferno)
  std::vector<Stroke> strokes;
  std::vector<Caption> captions;
};

}  // namespace mtf::io
