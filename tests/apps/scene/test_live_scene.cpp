// SPDX-License-Identifier: Apache-2.0

// The scene's file in the live view: numbers change, comments stay, no edit names a file; and scenes that are worked
// out in the background.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/live/space/scene_rows.h"
#include "apps/live/space/solved_scenes.h"
#include "mtf/work/stop.h"
#include "tests/apps/scene/scene_folder.h"
#include "tests/expect_error.h"

namespace apps::live {
namespace {

using scene::test::scene_text;
using scene::test::SceneFolder;

using Values = std::vector<std::pair<std::string, std::string>>;

std::string after(const SceneFolder& folder, const Values& values) {
  std::vector<Edit> edits;
  for (const auto& [name, value] : values) edits.push_back({Edit::Kind::set, name, value});
  return edited_scene(scene_text(), folder.file("scene.toml"), edits);
}

std::string refusal_of(const SceneFolder& folder, const Values& values, std::size_t index = 0) {
  try {
    after(folder, values);
  } catch (const RefusedEdit& error) {
    EXPECT_EQ(error.list(), "scene");
    EXPECT_EQ(error.index(), index);
    return error.what();
  }
  return "";
}

nlohmann::json read(const Json& json) { return nlohmann::json::parse(json_document(json)); }

nlohmann::json row_named(const nlohmann::json& model, const std::string& name) {
  for (const auto& table : model["tables"])
    for (const auto& row : table["rows"])
      if (row["name"] == name) return row;
  return {};
}

TEST(LiveScene, OneValueChangesAndAllElseStays) {
  const SceneFolder folder;
  const std::string text = scene_text();
  EXPECT_EQ(after(folder, {}), text);
  const std::string engine = after(folder, {{"material.armour.inside.temperature", "90 degC"}});
  const scene::SceneFile hot = folder.parse(engine).scene;
  EXPECT_DOUBLE_EQ(hot.materials[0].inside.temperature.value.front(), 363.15);
  EXPECT_TRUE(hot.materials[0].inside.temperature.constant());
  // One line differs.
  const auto [a, b] = std::mismatch(text.begin(), text.end(), engine.begin());
  EXPECT_EQ(std::count(a, text.end(), '\n'), std::count(b, engine.end(), '\n'));
  const std::string back = after(folder, {{"material.armour.inside.temperature", "90 degC"},
                                          {"material.armour.inside.temperature", "engine.csv"}});
  EXPECT_EQ(back, text) << "the schedule of the start";
}

TEST(LiveScene, WeatherOfAFileIsChangedByKeysThatAreAdded) {
  const SceneFolder folder;
  const std::string text =
      after(folder, {{"weather.wind_speed_factor", "0.5"}, {"weather.air_temperature_offset", "-5 K"}});
  expect_says(text, {"wind_speed_factor = 0.5\nair_temperature_offset = \"-5 K\"\n"});
  const scene::SceneFile file = folder.parse(text).scene;
  EXPECT_EQ(file.weather.change.wind_speed_factor, 0.5);
  EXPECT_EQ(file.weather.change.air_temperature_offset_k, -5.0);
}

TEST(LiveScene, AKeyIsNoLongerGiven) {
  const SceneFolder folder;
  const std::vector<Edit> edits{{Edit::Kind::set, "weather.solar_factor", "0.5"},
                                {Edit::Kind::unset, "weather.solar_factor", ""}};
  EXPECT_EQ(edited_scene(scene_text(), folder.file("scene.toml"), edits), scene_text());
  const std::vector<Edit> needed{{Edit::Kind::unset, "material.armour.solar_absorptance", ""}};
  EXPECT_THROW(edited_scene(scene_text(), folder.file("scene.toml"), needed), RefusedEdit);
}

TEST(LiveScene, WhatIsRefused) {
  const SceneFolder folder;
  for (const char* value : {"/etc/passwd", "other.csv", "../engine.csv", "", "hot", "90", "90 mm"})
    EXPECT_NE(refusal_of(folder, {{"material.armour.inside.temperature", value}}), "") << value;
  EXPECT_NE(refusal_of(folder, {{"material.armour.emissivity", "bands.csv"}}), "") << "another file";
  EXPECT_TRUE(says(after(folder, {{"material.armour.emissivity", "90 %"}}), "emissivity = 0.9\n")) << "no file";
  EXPECT_NE(refusal_of(folder, {{"weather.file", "engine.csv"}}), "");
  EXPECT_NE(refusal_of(folder, {{"mesh.vehicle.file", "/etc/passwd"}}), "");
  expect_says(refusal_of(folder, {{"weather.wind_speed_factor", "2.0"}, {"weather.solar_factor", "-1"}}, 1),
              {"outside [0, 1.5]"});
  EXPECT_NE(refusal_of(folder, {{"weather.solar_factor", "nan"}}), "");
  EXPECT_NE(refusal_of(folder, {{"weather.solar_factor", "1.0\"\n[mesh]"}}), "");
}

TEST(LiveScene, RowsHaveSlidersInTheUnitOfTheFile) {
  const auto model = read(scene_json(scene_text()));
  const auto wind = row_named(model, "weather.wind_speed_factor");
  EXPECT_FALSE(wind["given"]);
  EXPECT_EQ(wind["number"], 1.0);
  const auto thickness = row_named(model, "material.armour.layers[0].thickness");
  EXPECT_EQ(thickness["text"], "20 mm");
  EXPECT_EQ(thickness["unit"], "mm");
  EXPECT_EQ(thickness["number"], 20.0);
  EXPECT_NEAR(thickness["max"].get<double>(), 1e5, 1e-6);
  EXPECT_TRUE(thickness["log"]);
  const auto engine = row_named(model, "material.armour.inside.temperature");
  EXPECT_EQ(engine["text"], "engine.csv");
  EXPECT_EQ(engine["unit"], "degC");
  EXPECT_NEAR(engine["min"].get<double>(), -273.15, 1e-9);
  EXPECT_LT(engine["low"].get<double>(), engine["number"].get<double>());
  const auto film =
      read(scene_json("[[material]]\nname = \"a\"\nconvection = { h0 = \"5 W/m2/K\", h1 = \"3.8 W/m2/K/(m/s)\" }\n"
                      "refractive_index = 1.5\n"));
  EXPECT_EQ(row_named(film, "material.a.convection.h0")["number"], 5.0);
  EXPECT_EQ(row_named(film, "material.a.convection.h1")["unit"], "W/m2/K/(m/s)");
  EXPECT_EQ(row_named(film, "material.a.refractive_index")["number"], 1.5);
  // A constant keeps its keys in place of changes.
  const auto constant = read(scene_json("[weather]\nwind_speed = \"3 m/s\"\n"));
  EXPECT_EQ(row_named(constant, "weather.wind_speed")["number"], 3.0);
  EXPECT_TRUE(row_named(constant, "weather.wind_speed_factor").is_null());
  EXPECT_TRUE(scene_json("this is no TOML").at("tables").empty());
}

/// Finds until the scene is there.
std::shared_ptr<SolvedScene> wait_for(SolvedScenes& scenes, const std::string& text, const std::string& tab = "tab") {
  for (int i = 0; i < 10000; ++i) {
    if (auto found = scenes.find(text, tab); found.scene) return found.scene;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return nullptr;
}

std::shared_ptr<SolvedScene> scene_of(const std::string& text) {
  auto made = std::make_shared<SolvedScene>();
  made->file.text = text;
  return made;
}

TEST(SolvedScenes, AreMadeBesideAndKept) {
  std::atomic<int> made{0};
  SolvedScenes scenes("a", scene_of("a"), [&](const std::string& text, const SolveProgress& progress) {
    progress("rays", 0.25);
    ++made;
    if (text == "bad") throw mtf::UsageError("no such weather");
    return scene_of(text);
  });
  EXPECT_EQ(scenes.find("", "tab").scene, scenes.start());
  EXPECT_EQ(scenes.find("a", "tab").scene, scenes.start());
  const auto found = scenes.find("b", "tab");
  EXPECT_FALSE(found.scene);
  EXPECT_FALSE(found.waiting.empty());
  const auto b = wait_for(scenes, "b");
  ASSERT_TRUE(b);
  EXPECT_EQ(b->file.text, "b");
  ASSERT_TRUE(wait_for(scenes, "c"));
  EXPECT_EQ(wait_for(scenes, "b"), b) << "kept";
  EXPECT_EQ(made, 2);
  EXPECT_THROW(wait_for(scenes, "bad"), mtf::UsageError);
  EXPECT_THROW(scenes.find("bad", "tab"), mtf::UsageError) << "and again, without trying";
  EXPECT_EQ(made, 3);
  EXPECT_TRUE(wait_for(scenes, "d"));
}

TEST(SolvedScenes, OneThatNobodyAsksForEnds) {
  std::atomic<bool> stopped{false}, begun{false};
  SolvedScenes scenes("a", scene_of("a"), [&](const std::string& text, const SolveProgress&) {
    begun = true;
    try {
      while (text == "long") {
        mtf::require_going_on();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    } catch (const mtf::Stopped&) {
      stopped = true;
      throw;
    }
    return scene_of(text);
  });
  EXPECT_FALSE(scenes.find("long", "tab").scene);
  while (!begun) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(says(scenes.find("b", "other").waiting, "waits for another")) << "a page still asks for the first";
  EXPECT_FALSE(stopped);
  EXPECT_TRUE(wait_for(scenes, "b")) << "that page wants another one";
  for (int i = 0; i < 1000 && !stopped; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(stopped);
}

}  // namespace
}  // namespace apps::live
