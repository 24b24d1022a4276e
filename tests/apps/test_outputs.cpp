// SPDX-License-Identifier: Apache-2.0

// What commands write, and what becomes of that when something is in the way: inputs, other commands, full disks.

#include <gtest/gtest.h>
#include <sys/mount.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/apps/command.h"
#include "tests/apps/plates_case.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

/// A folder's names, sorted.
std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// scene.toml with plates.obj, e.csv (an emissivity) and p.csv (a profile of the air), and lwir.toml; temperatures of
/// it in t.
class Outputs : public testing::Test {
 protected:
  Outputs() {
    const std::string layers =
        "layers = [{ conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", "
        "thickness = \"5 mm\" }]\n";
    write_file(scratch_ / "scene.toml",
               place_and_weather("start = 2026-06-21T10:00:00Z\nend = 2026-06-21T12:00:00Z\nstep = \"1 h\"\n") +
                   "[atmosphere]\nmodel = \"mid_latitude_summer\"\nprofile = \"p.csv\"\n"
                   "[[material]]\nname = \"paint\"\nsolar_absorptance = 0.7\nemissivity = \"e.csv\"\n"
                   "convection = \"mcadams\"\n" +
                   layers +
                   "[[mesh]]\nname = \"plates\"\nfile = \"plates.obj\"\n"
                   "[[region]]\nmesh = \"plates\"\nmaterial = \"paint\"\n"
                   "[camera]\nposition = [\"3 m\", \"-40 m\", \"4 m\"]\nlook_at = [\"0 m\", \"0 m\", \"0.6 m\"]\n");
    write_file(scratch_ / "plates.obj", kGroundAndTarget);
    write_file(scratch_ / "e.csv", "wavelength_um,emissivity\n3,0.8\n14,0.9\n");
    write_file(scratch_ / "p.csv",
               "altitude_m,pressure_hpa,temperature_k,relative_humidity_percent\n0,1013,288,50\n1000,900,282,40\n"
               "5000,540,256,30\n");
    write_file(scratch_ / "lwir.toml", uncooled(""));
  }
  void solve(const std::string& folder) const {
    const Result made = scratch_.run("mtf heat scene.toml -o " + folder + " --tolerance '1 K' --quiet");
    ASSERT_EQ(made.status, 0) << made.err;
  }
  Scratch scratch_;
};

// Whatever the command and the name: nothing that is read is replaced, and it is said before any work is done.
TEST_F(Outputs, NoInputIsReplaced) {
  solve("t");
  fs::create_symlink("t/temperatures.npy", scratch_ / "link.exr");
  fs::create_hard_link(scratch_ / "e.csv", scratch_ / "second.csv");
  fs::create_directory(scratch_ / "o");
  const std::string text = read_file(scratch_ / "scene.toml");
  fs::rename(scratch_ / "e.csv", scratch_ / "o/facets.csv");
  fs::create_symlink("o/facets.csv", scratch_ / "e.csv");
  const std::vector<std::string> inputs{"e.csv",       "p.csv",    "plates.obj", "t/temperatures.npy",
                                        "t/times.csv", "lwir.toml"};
  std::vector<std::string> before;
  for (const std::string& input : inputs) before.push_back(read_file(scratch_ / input));
  std::vector<std::string> commands{
      "mtf render scene.toml lwir.toml --temperatures t -o link.exr",
      "mtf render scene.toml lwir.toml --temperatures t -o x.exr --picture lwir.png",
      "mtf fly scene.toml lwir.toml --temperatures t --frames 0:0 --report second.csv",
      "mtf heat scene.toml -o o --force",
      "mtf curve lwir.toml -o lwir.toml",
      "mtf budget lwir.toml -o lwir.toml",
      "mtf bench lwir.toml x.exr -o b --force",
      "mtf fly scene.toml lwir.toml --temperatures t --frames 0:0 --schedule s.csv --report q.csv",
      "mtf atmosphere scene.toml --table p.csv"};
  for (const std::string& input : inputs)
    commands.push_back("mtf fly scene.toml lwir.toml --temperatures t --frames 0:0 --report " + input);
  write_file(scratch_ / "s.csv", "frame,parameter,value\n0,optics.transmission,q.csv\n");
  write_file(scratch_ / "q.csv", "wavelength_um,transmission\n3,0.8\n15,0.8\n");
  fs::create_directory(scratch_ / "b");
  fs::create_symlink("../lwir.toml", scratch_ / "b/bench.csv");
  fs::create_symlink("lwir.toml", scratch_ / "lwir.png");
  for (const std::string& command : commands) {
    SCOPED_TRACE(command);
    expect_error(scratch_.run(command), 2, {"this run reads"});
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) EXPECT_EQ(read_file(scratch_ / inputs[i]), before[i]) << inputs[i];
  EXPECT_EQ(read_file(scratch_ / "scene.toml"), text);
}

// One of them writes it, the other says so; no file of theirs is lost or mixed.
TEST_F(Outputs, OfTwoCommandsIntoOneFolderOneIsRefused) {
  for (int round = 0; round < 3; ++round) {
    const Result both = scratch_.run(
        "rm -rf f; for i in 1 2; do ( mtf heat scene.toml -o f --quiet >log$i 2>&1; echo $? >>log$i ) & done; wait; "
        "tail -qn1 log1 log2 | sort | tr '\\n' ' '; cat log1 log2");
    EXPECT_TRUE(both.out.starts_with("0 1 ") || both.out.starts_with("0 2 ")) << both.out;
    EXPECT_TRUE(both.out.find("f: another mtf") != std::string::npos ||
                both.out.find("f is not empty") != std::string::npos)
        << both.out;
    EXPECT_EQ(names_in(scratch_ / "f"),
              (std::vector<std::string>{"facets.csv", "heat.json", "regions.csv", "regions.svg", "regions.svg.csv",
                                        "scene.png", "temperatures.npy", "times.csv"}));
  }
}

// A folder of any name: results are kept, and the report says it with the bytes that are no UTF-8 replaced.
TEST_F(Outputs, NamesThatAreNoUtf8LoseNoResult) {
  const std::string name = "d\xe9t\xe9";
  ASSERT_EQ(scratch_.run("mkdir '" + name + "'; mv *.toml *.csv *.obj '" + name + "'").status, 0);
  const Result made = scratch_.run("mtf heat '" + name + "/scene.toml' -o '" + name + "/t' --tolerance '1 K'");
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string report = read_file(scratch_ / (name + "/t/heat.json"));
  expect_says(report, {"d\xef\xbf\xbdt\xef\xbf\xbd/scene.toml"});
  EXPECT_TRUE(nlohmann::json::accept(report));
  for (const std::string command :
       {"mtf render 'D/scene.toml' 'D/lwir.toml' --temperatures 'D/t' -o 'D/x.exr' --format json",
        "mtf fly 'D/scene.toml' 'D/lwir.toml' --temperatures 'D/t' --frames 0:0 --report 'D/f.json' --format json",
        "mtf curve 'D/lwir.toml' --format json", "mtf budget 'D/lwir.toml' --format json",
        "mtf config check 'D/lwir.toml' --format json", "mtf info 'D/x.exr' --format json"}) {
    std::string text = command;
    for (std::size_t at = text.find("'D"); at != std::string::npos; at = text.find("'D"))
      text.replace(at, 2, "'" + name);
    const Result shown = scratch_.run(text);
    EXPECT_EQ(shown.status, 0) << command << shown.err;
    EXPECT_TRUE(nlohmann::json::accept(shown.out)) << command << shown.out;
  }
}

// The new set is written while the old one stands.
TEST_F(Outputs, ForceThatFailsLeavesTheOldSet) {
  fs::create_directory(scratch_ / "disk");
  if (::mount("none", (scratch_ / "disk").c_str(), "tmpfs", 0, "size=400k") != 0) GTEST_SKIP() << "no right to mount";
  write_file(scratch_ / "disk/mine", "mine");
  const Result first = scratch_.run("mtf heat scene.toml -o disk --force --quiet");
  EXPECT_EQ(first.status, 0) << first.err;
  const std::vector<std::string> before = names_in(scratch_ / "disk");
  const std::string report = read_file(scratch_ / "disk/heat.json");
  const Result second =
      scratch_.run("head -c 1000000 /dev/zero >disk/full 2>/dev/null; mtf heat scene.toml -o disk --force");
  expect_error(second, 1, {"No space left"});
  EXPECT_FALSE(says(second.err, "mtf-new")) << second.err;
  fs::remove(scratch_ / "disk/full");
  EXPECT_EQ(names_in(scratch_ / "disk"), before);
  EXPECT_EQ(read_file(scratch_ / "disk/heat.json"), report);
  EXPECT_EQ(read_file(scratch_ / "disk/mine"), "mine");
  ::umount((scratch_ / "disk").c_str());
}

TEST_F(Outputs, TheCurrentFolderAndLinksToFoldersAreOutputsToo) {
  fs::create_directory(scratch_ / "here");
  fs::create_symlink("here", scratch_ / "link");
  ASSERT_EQ(
      scratch_.run("cd here && mtf heat ../scene.toml -o . --quiet && ls | wc -l >../count && [ -e heat.json ]").status,
      0);
  EXPECT_EQ(read_file(scratch_ / "count"), "8\n");
  EXPECT_EQ(scratch_.run("mtf heat scene.toml -o link --quiet").status, 2);
  ASSERT_EQ(scratch_.run("mtf heat scene.toml -o link/ --force --quiet").status, 0);
  EXPECT_TRUE(fs::is_symlink(scratch_ / "link"));
  EXPECT_EQ(names_in(scratch_ / "here").size(), 8U);
  // A file that is a link: what it points to is replaced.
  write_file(scratch_ / "real.csv", "old");
  fs::create_symlink("real.csv", scratch_ / "point.csv");
  ASSERT_EQ(scratch_.run("mtf curve lwir.toml --format csv -o point.csv").status, 0);
  EXPECT_TRUE(fs::is_symlink(scratch_ / "point.csv"));
  EXPECT_TRUE(read_file(scratch_ / "real.csv").starts_with("frequency"));
}

// A pipe or a device in place of a file is refused at once: opening a pipe would wait for ever.
TEST_F(Outputs, NoInputIsAPipeOrADevice) {
  write_file(scratch_ / "study.toml",
             "schema = 1\nsensor = \"pipe\"\nobjectives = [\"maximize mtf_nyquist\"]\n[[axis]]\nparameter = "
             "\"optics.f_number\"\nvalues = [1.2, 2.0]\n");
  write_file(scratch_ / "curve.toml", uncooled("[[presample]]\nkind = \"curve\"\nfile = \"pipe\"\n"));
  write_file(scratch_ / "efficiency.toml", [] {
    std::string text = uncooled("");
    return replaced(text, "absorptance = 0.8", "absorptance = \"pipe\"");
  }());
  std::string piped = read_file(scratch_ / "scene.toml");
  write_file(scratch_ / "mesh.toml", std::string(piped).replace(piped.find("plates.obj"), 10, "pipe.obj"));
  write_file(scratch_ / "table.toml", std::string(piped).replace(piped.find("e.csv"), 5, "pipe"));
  ASSERT_EQ(scratch_.run("mkfifo pipe pipe.obj; mkdir t; mkfifo t/temperatures.npy t/times.csv").status, 0);
  for (const char* command :
       {"mtf sweep study.toml -o out", "mtf optimize study.toml", "mtf curve pipe", "mtf curve curve.toml",
        "mtf budget efficiency.toml", "mtf simulate lwir.toml pipe -o x.exr", "mtf info pipe", "mtf measure pipe",
        "mtf fit lwir.toml pipe", "mtf heat pipe -o out", "mtf heat mesh.toml -o out", "mtf heat table.toml -o out",
        "mtf render scene.toml lwir.toml --temperatures t -o x.exr",
        "mtf render scene.toml lwir.toml --temperatures t/temperatures.npy -o x.exr", "mtf report pipe",
        "mtf simulate lwir.toml x.exr -o y.exr --schedule pipe", "mtf fly scene.toml pipe --frames 0:0",
        "mtf atmosphere pipe", "mtf config check pipe"}) {
    const Result result = scratch_.run(std::string("timeout 10 ") + command);
    EXPECT_TRUE(result.status == 1 || result.status == 2) << command << ": " << result.status << result.err;
    EXPECT_FALSE(fs::exists(scratch_ / "out")) << command;
  }
}

// 28 bytes a sample of a picture, 40 of a frame of a flight: 16000 x 16000 samples.
TEST_F(Outputs, MemoryIsSaidBeforeItIsUsed) {
  solve("t");
  const std::string text = uncooled("");
  write_file(scratch_ / "large.toml", std::string(text).replace(text.find("[64, 48]"), 8, "[8000, 8000]"));
  const std::string limit = "ulimit -v 4000000; ";
  for (const auto& [command, bytes] :
       {std::pair{"mtf render scene.toml large.toml --temperatures t -o x.exr", "6.68 GiB"},
        {"mtf fly scene.toml large.toml --temperatures t --frames 0:0", "9.54 GiB"}})
    expect_error(scratch_.run(limit + command), 2, {"16000 x 16000 samples", bytes, "ulimit -v leaves 3."});
  const Result said = scratch_.run("mtf render scene.toml large.toml --temperatures t --time never -o x.exr");
  if (said.err.find("note: pictures of") == std::string::npos) GTEST_SKIP() << "the machine has less than 7 GiB";
  expect_says(said.err, {"note:", "16000 x 16000 samples", "6.68 GiB"});
}

// The limits of a container are files below /sys/fs/cgroup: others stand there in a view of the files of its own.
TEST_F(Outputs, TheLimitOfAContainerCounts) {
  const std::string text = uncooled("");
  write_file(scratch_ / "large.toml", std::string(text).replace(text.find("[64, 48]"), 8, "[2400, 2400]"));
  solve("t");
  const std::string inside =
      "mount -t tmpfs none /sys/fs/cgroup && mkdir /sys/fs/cgroup/memory && echo 536870912 | tee "
      "/sys/fs/cgroup/memory.max >/sys/fs/cgroup/memory/memory.limit_in_bytes && ";
  const auto contained = [&](const std::string& command) {
    return scratch_.run("unshare -m sh -c '" + inside + command + "'");
  };
  if (contained("true").status != 0) GTEST_SKIP() << "no right to mount";
  expect_error(contained("mtf render scene.toml large.toml --temperatures t -o x.exr"), 2, {"615 MiB", "512 MiB"});
  const Result bench = contained("mtf bench scene.toml -o b --tolerance 1K");
  expect_says(read_file(scratch_ / "b/heat_bench.json"), {"\"memory_bytes\": 536870912"});
}

TEST_F(Outputs, AReaderThatGoesAwayEndsAnyCommandWithoutAWord) {
  solve("t");
  for (const char* command :
       {"mtf curve lwir.toml --freq 0:60:20000", "mtf --help", "mtf heat scene.toml -o t --force", "mtf config kinds",
        "mtf curve lwir.toml -o /dev/stdout --freq 0:60:20000", "mtf config schema scene"}) {
    const Result piped = scratch_.run("rm -f fifo; mkfifo fifo; { " + std::string(command) +
                                      "; echo $? >status; } >fifo 2>err & : <fifo; wait; cat status err");
    EXPECT_EQ(piped.out, "141\n") << command;
  }
  EXPECT_EQ(names_in(scratch_ / "t").size(), 8U);  // the results are there
}

}  // namespace
}  // namespace apps_test
