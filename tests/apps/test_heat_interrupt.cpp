// SPDX-License-Identifier: Apache-2.0

// `mtf heat` that is interrupted or killed: what it leaves, and how it goes on.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "mtf/io/sha256.h"
#include "tests/apps/heat_command_case.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

/// A folder's names, sorted.
std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Terrain of n x n squares in triangles, bumpy enough for every facet to be a class of its own.
std::string bumps(int n) {
  std::ostringstream obj;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      obj << "v " << i << " " << j << " " << 0.8 * std::sin(1.7 * i) * std::cos(2.3 * j) << "\n";
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1, c = a + n + 1;
      obj << "f " << a << " " << a + 1 << " " << c + 1 << "\nf " << a << " " << c + 1 << " " << c << "\n";
    }
  return obj.str();
}

/// A scene of hourly outputs until that day, and a mesh of so many facets that a run of it can be interrupted.
void write_many_days(const Scratch& folder, const std::string& end) {
  std::string text = kScene;
  text = replaced(text, "end = 2026-06-22", "end = " + end);
  text = replaced(text, "step = \"2 h\"", "step = \"1 h\"");
  write_file(folder / "scene.toml", text);
  write_file(folder / "plates.obj", bumps(20));
}

/// `mtf heat scene.toml -o FOLDER`, stopped by a signal as soon as a day stands in the temporary file.
std::string stopped(const std::string& folder, const std::string& signal) {
  return "mtf heat scene.toml -o " + folder +
         " & pid=$!\n"
         "while kill -0 $pid 2>/dev/null; do\n"
         "  [ -n \"$(find " +
         folder + " -name 'temperatures.npy.tmp.*' -size +0 2>/dev/null)\" ] && kill -" + signal +
         " $pid && break\n"
         "  sleep 0.02\ndone\nwait $pid";
}
std::string interrupted(const std::string& folder) { return stopped(folder, "INT"); }

TEST_F(HeatCommand, GoesOnAfterAnInterrupt) {
  write_many_days(scratch_, "2026-07-01");
  const Result whole = scratch_.run("mtf heat scene.toml -o whole");
  ASSERT_EQ(whole.status, 0) << whole.err;
  const Result first = scratch_.run(interrupted("days"));
  ASSERT_EQ(first.status, 130) << first.err;
  ASSERT_NE(first.err.find("the temperatures end at"), std::string::npos) << first.err;
  const nlohmann::json json = nlohmann::json::parse(read_file(scratch_ / "days/heat.json"));
  EXPECT_FALSE(json.at("finished").get<bool>());
  const std::size_t outputs = json.at("outputs").get<std::size_t>();
  EXPECT_LT(outputs, 10U * 24U + 1U);
  EXPECT_EQ(outputs % 24, 1U);  // whole days, and the start
  EXPECT_EQ(lines_of(read_file(scratch_ / "days/times.csv")).size(), outputs + 1);
  for (const std::string& name : names_in(scratch_ / "days")) EXPECT_FALSE(name.starts_with('.')) << name;

  // Inputs that changed are refused, by name, and nothing is lost.
  write_file(scratch_ / "plates.obj", bumps(19));
  expect_error(scratch_.run("mtf heat scene.toml -o days"), 2, {"a mesh is not"});
  write_file(scratch_ / "plates.obj", bumps(20));
  const Result tolerance = scratch_.run("mtf heat scene.toml -o days --tolerance '0.5 K'");
  EXPECT_EQ(tolerance.status, 2);
  const std::string state = read_file(scratch_ / "days/unfinished.bin");
  write_file(scratch_ / "days/unfinished.bin", state.substr(0, state.size() - 8));
  expect_error(scratch_.run("mtf heat scene.toml -o days"), 2, {"damaged"});
  write_file(scratch_ / "days/unfinished.bin", state);
  EXPECT_EQ(nlohmann::json::parse(read_file(scratch_ / "days/heat.json")).at("outputs"), outputs);

  const Result second = scratch_.run("mtf heat scene.toml -o days");
  ASSERT_EQ(second.status, 0) << second.err;
  expect_says(second.err, {"going on after " + std::to_string(outputs) + " outputs"});
  for (const char* name : {"temperatures.npy", "regions.csv", "times.csv", "facets.csv"})
    EXPECT_TRUE(read_file(scratch_ / "days" / name) == read_file(scratch_ / "whole" / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "days/unfinished.bin"));
  const auto one = nlohmann::json::parse(read_file(scratch_ / "whole/heat.json"));
  const auto two = nlohmann::json::parse(read_file(scratch_ / "days/heat.json"));
  EXPECT_TRUE(two.at("finished").get<bool>());
  for (const char* key : {"promised_K", "steps", "residual_K", "materials"}) EXPECT_EQ(one.at(key), two.at(key)) << key;
  EXPECT_EQ(scratch_.run("mtf heat scene.toml -o days").status, 2);  // a finished one asks for --force
}

// A process that is killed cannot tidy up: its temporaries stay until the same files are written again.
TEST_F(HeatCommand, AKilledRunLeavesNothingHalfWritten) {
  write_many_days(scratch_, "2026-07-01");
  ASSERT_EQ(scratch_.run(stopped("fresh", "KILL")).status, 137);
  EXPECT_EQ(names_in(scratch_ / "fresh"), std::vector<std::string>{".mtf-new"});

  // What an interrupted run finished is there still when the one that goes on is killed, and can be gone on from.
  ASSERT_EQ(scratch_.run(interrupted("days")).status, 130);
  const std::string state = read_file(scratch_ / "days/unfinished.bin"), times = read_file(scratch_ / "days/times.csv");
  ASSERT_EQ(scratch_.run(stopped("days", "KILL")).status, 137);
  EXPECT_TRUE(read_file(scratch_ / "days/unfinished.bin") == state);
  EXPECT_EQ(read_file(scratch_ / "days/times.csv"), times);
  expect_says(scratch_.run("mtf heat scene.toml -o days --rays 64").err, {"interrupted, and an option"});

  write_many_days(scratch_, "2026-06-22");
  const Result again = scratch_.run("mtf heat scene.toml -o fresh");  // as good as empty
  ASSERT_EQ(again.status, 0) << again.err;
  for (const std::string& name : names_in(scratch_ / "fresh")) EXPECT_FALSE(name.starts_with('.')) << name;
}

/// `mtf heat scene.toml -o FOLDER --save-every 0`, killed as soon as it has saved a day, another one than in the file
/// `unlike`.
std::string killed(const std::string& folder, const std::string& unlike = "/dev/null") {
  return "mtf heat scene.toml -o " + folder +
         " --save-every 0 & pid=$!\n"
         "while kill -0 $pid 2>/dev/null; do\n"
         "  [ -s " +
         folder + "/unfinished.bin ] && ! cmp -s " + folder + "/unfinished.bin " + unlike +
         " && kill -KILL $pid && break\n  sleep 0.01\ndone\nwait $pid";
}

// Killed in a day, twice, and once after files were written: nothing of what was saved is solved again.
TEST_F(HeatCommand, GoesOnAfterItWasKilled) {
  write_many_days(scratch_, "2026-07-11");
  const Result whole = scratch_.run("mtf heat scene.toml -o whole");
  ASSERT_EQ(whole.status, 0) << whole.err;
  ASSERT_EQ(scratch_.run(killed("days")).status, 137);
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "days/temperatures.npy"));
  EXPECT_TRUE(std::filesystem::exists(scratch_ / "days/unfinished.npy"));

  // A scene that changed is refused, and nothing is lost.
  const std::string scene = read_file(scratch_ / "scene.toml"), state = read_file(scratch_ / "days/unfinished.bin");
  write_file(scratch_ / "scene.toml", scene + "# another\n");
  expect_error(scratch_.run("mtf heat scene.toml -o days"), 2, {"scene file is not"});
  write_file(scratch_ / "scene.toml", scene);
  EXPECT_TRUE(read_file(scratch_ / "days/unfinished.bin") == state);

  write_file(scratch_ / "first.bin", state);
  ASSERT_EQ(scratch_.run(killed("days", "first.bin")).status, 137);
  EXPECT_FALSE(read_file(scratch_ / "days/unfinished.bin") == state);
  // (What a killed process left is no sign that the next one has begun.)
  ASSERT_EQ(scratch_.run("rm -rf days/.mtf-new; " + interrupted("days")).status, 130);
  const Result last = scratch_.run("mtf heat scene.toml -o days");
  ASSERT_EQ(last.status, 0) << last.err;
  expect_says(last.err, {"going on after "});
  for (const char* name : {"temperatures.npy", "regions.csv", "times.csv", "facets.csv"})
    EXPECT_TRUE(read_file(scratch_ / "days" / name) == read_file(scratch_ / "whole" / name)) << name;
  for (const std::string& name : names_in(scratch_ / "days")) {
    EXPECT_FALSE(name.starts_with('.')) << name;
    EXPECT_FALSE(says(name, "unfinished")) << name;
  }
  const auto one = nlohmann::json::parse(read_file(scratch_ / "whole/heat.json"));
  const auto two = nlohmann::json::parse(read_file(scratch_ / "days/heat.json"));
  for (const char* key : {"promised_K", "steps", "residual_K", "materials"}) EXPECT_EQ(one.at(key), two.at(key)) << key;
}

/// unfinished.bin with another head or another first number of the checkpoint (the windows that are finished), and the
/// hash that belongs to it.
std::string rewritten(const std::string& state, const std::function<void(nlohmann::json&)>& change,
                      std::optional<std::uint64_t> windows = {}) {
  const std::size_t magic = state.find('\n') + 1, begin = magic + 64, line = state.find('\n', begin);
  nlohmann::json head = nlohmann::json::parse(state.substr(begin, line - begin));
  change(head);
  std::string body = state.substr(line + 1);
  if (windows) std::memcpy(body.data(), &*windows, sizeof *windows);
  const std::string all = head.dump() + "\n" + body;
  return state.substr(0, magic) + mtf::io::sha256_hex(all) + all;
}

// Whatever a bad disk or somebody made of the state: it is refused, nothing crashes or takes memory for it, and it is
// still there. The whole file is covered by its hash, the sizes in it are compared with the scene.
TEST_F(HeatCommand, AStateThatIsNotItsOwnIsRefused) {
  write_many_days(scratch_, "2026-07-01");
  ASSERT_EQ(scratch_.run(interrupted("days")).status, 130);
  const std::string state = read_file(scratch_ / "days/unfinished.bin");
  const auto expect_refused = [&](const std::string& bytes, const std::string& what) {
    write_file(scratch_ / "days/unfinished.bin", bytes);
    const Result result = scratch_.run("ulimit -v 4000000; mtf heat scene.toml -o days");
    EXPECT_TRUE(result.status == 1 || result.status == 2) << what << ": " << result.status;
    EXPECT_TRUE(says(result.err, "damaged")) << what << ": " << result.err;
    EXPECT_TRUE(says(result.err, "--anew")) << what << ": " << result.err;
    EXPECT_TRUE(read_file(scratch_ / "days/unfinished.bin") == bytes) << what;
  };
  const auto none = [](nlohmann::json&) {};
  std::string flipped = state;
  flipped[state.find("times_s") + 12] ^= 1;
  expect_refused(flipped, "a time");
  flipped = state;
  flipped[state.size() / 2] ^= 1;
  expect_refused(flipped, "the checkpoint");
  expect_refused(rewritten(state, [](nlohmann::json& head) { head["regions"] = nlohmann::json::array(); }),
                 "no regions");
  expect_refused(rewritten(state, [](nlohmann::json& head) { head["times_s"].push_back(1e9); }), "more times");
  expect_refused(rewritten(state, [](nlohmann::json& head) { head["regions"] = 5; }), "no list");
  for (const std::uint64_t windows :
       {std::uint64_t{0}, std::uint64_t{1000}, std::uint64_t{1} << 40U, ~std::uint64_t{0}})
    expect_refused(rewritten(state, none, windows), std::to_string(windows) + " windows");
  for (std::size_t cut = 100; cut < state.size(); cut += state.size() / 7)
    expect_refused(state.substr(0, cut), "cut at " + std::to_string(cut));
  write_file(scratch_ / "days/unfinished.bin", rewritten(state, none));
  EXPECT_EQ(scratch_.run("mtf heat scene.toml -o days").status, 0);
}

// A limit on the size of files stands for a disk that is full.
TEST_F(HeatCommand, ADiskWithoutRoomIsNamed) {
  write_many_days(scratch_, "2026-06-25");
  expect_error(scratch_.run("ulimit -f 128; mtf heat scene.toml -o out"), 1, {"cannot write out/temperatures.npy"});
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "out"));
}

TEST_F(HeatCommand, BeginsAnewAfterAnInterruptWhereThatIsAskedFor) {
  write_many_days(scratch_, "2026-08-20");
  // Before anything is finished no folder stays.
  EXPECT_EQ(scratch_.run("timeout --preserve-status -s INT 0.3 mtf heat scene.toml -o early").status, 130);
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "early"));
  ASSERT_EQ(scratch_.run(interrupted("days")).status, 130);
  write_file(scratch_ / "scene.toml", kScene);
  write_file(scratch_ / "plates.obj", kPlates);
  EXPECT_EQ(scratch_.run("mtf heat scene.toml -o days").status, 2);
  ASSERT_EQ(scratch_.run("mtf heat scene.toml -o days --anew").status, 0);
  EXPECT_TRUE(nlohmann::json::parse(read_file(scratch_ / "days/heat.json")).at("finished").get<bool>());
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "days/unfinished.bin"));
}

}  // namespace
}  // namespace apps_test
