// SPDX-License-Identifier: Apache-2.0
// Paths of cameras from CSV files.

#include "apps/scene/scene_file/scene_sections.h"

#include <gtest/gtest.h>

#include "mtf/error.h"
#include "tests/expect_error.h"

namespace apps::scene {
namespace {

const std::string kHead = "time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n";

std::string refusal(const std::string& text) {
  return message_of<mtf::UsageError>([&] { parse_camera_path(text, "flight.csv"); });
}

TEST(CameraPath, GoesAlongStraightLines) {
  const CameraPath path = parse_camera_path(
      "# a dive\ntime (min),look_x (m),look_y (m),look_z (m),x (km),y (m),z (m)\n0,0,0,1,2,-8,400\n"
      "0.5,10,0,1,1,-4,100\n",
      "flight.csv");
  const CameraPlace place = path.at(7.5);  // a quarter of the way
  EXPECT_NEAR(place.position_m[0], 1750.0, 1e-9);
  EXPECT_NEAR(place.position_m[1], -7.0, 1e-12);
  EXPECT_NEAR(place.position_m[2], 325.0, 1e-12);
  EXPECT_NEAR(place.look_at_m[0], 2.5, 1e-12);
  EXPECT_EQ(path.at(30.0).position_m[2], 100.0);
  EXPECT_THROW(path.at(30.1), mtf::UsageError);
  EXPECT_THROW(path.at(-0.1), mtf::UsageError);
}

TEST(CameraPath, SaysWhatIsWrongWithItsLine) {
  const std::string first = "0,0,0,9,9,0,0\n";
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {kHead, "no records"},
           {kHead + "0,0,0,9,0,0,9\n", "flight.csv:2: error: the camera"},
           {kHead + first + "0,1,0,9,0,0,0\n", "flight.csv:3: error: the time"},
           {kHead + first + "1,9000,0,9,0,0,0\n", "flight.csv:3: error: the camera jumps"},
           {kHead + first + "1,,0,9,0,0,0\n", "flight.csv:3: error: x is missing"},
           {kHead + "2026-06-21T00:00:00Z,0,0,9,9,0,0\n", "is no number"},
           {"time,x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n2026-06-21T00:00:00Z,0,0,9,9,0,0\n",
            "from the first frame"},
           {"time (s),x (m),y (m),z (m),look_x (m),look_y (m)\n0,0,0,9,9,0\n", "no column look_z"},
           {"time (s),x (s),y (m),z (m),look_x (m),look_y (m),look_z (m)\n" + first, "x is a length"}})
    EXPECT_TRUE(says(refusal(text), words)) << text << refusal(text);
}

}  // namespace
}  // namespace apps::scene
