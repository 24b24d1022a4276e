// SPDX-License-Identifier: Apache-2.0

// `mtf characterize` of EMVA's own descriptors: the numbers of the reference implementation on a real camera's frames,
// and refusals.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/apps/command.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

/// The crop of EMVA's reference set 001 as its authors lay out theirs: 300 frames and a descriptor, with a decimal
/// comma.
constexpr const char* kMakeSet = R"(
import json, os, sys
import numpy as np
source = sys.argv[1]
frames = np.load(source + '.npz')['frames']
os.mkdir('images')
for k, frame in enumerate(frames):
    np.save(f'images/f{k}.npy', frame)
with open('EMVA1288_Data.txt', 'w', encoding='latin1') as out:
    print('# Dr. J\u00e4hne\nv 3.0\nn 12 96 64\nl Vendor Basler AG', file=out)
    for level in json.load(open(source + '.json'))['levels']:
        photons = f"{level['photons']}".replace('.', ',') if level['kind'] == 'b' else ''
        print(level['kind'], level['exposure_ns'], photons, file=out)
        for k in range(level['frames']):
            print(f"i images\\f{level['first'] + k}.npy", file=out, end='\r\n')
)";

struct Expected {
  const char* name;
  double value;
};
/// Of the reference implementation (commit 2ed0b40) on these frames.
constexpr std::array kReference{Expected{"K", 0.280239977},
                                Expected{"R", 0.126325071},
                                Expected{"eta", 45.07746267},
                                Expected{"sigma_y.dark", 3.061446266},
                                Expected{"sigma_d", 10.87569941},
                                Expected{"mu_p.min", 25.34387061},
                                Expected{"mu_e.min", 11.42437381},
                                Expected{"mu_p.sat", 31858.0},
                                Expected{"mu_e.sat", 14360.77806},
                                Expected{"DR", 1257.029776},
                                Expected{"SNR_max", 119.8364638},
                                Expected{"LE_min", -0.6626770135},
                                Expected{"LE_max", 0.4877104192},
                                Expected{"mu_I.mean", 33.48386153},
                                Expected{"mu_I.var", 126.0836513},
                                Expected{"DSNU_row", 0.2789452911},
                                Expected{"DSNU_column", 0.07875281228},
                                Expected{"PRNU", 0.2496537315},
                                Expected{"PRNU_row", 0.04519757508},
                                Expected{"PRNU_column", 0.02571724284},
                                Expected{"PRNU_pixel", 0.24417778}};

TEST(Emva1288Command, ARealCameraHasTheNumbersOfTheReferenceImplementation) {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const fs::path crop = fs::path(chosen ? chosen : MTFKIT_SOURCE_DIR "/../shared") / "data/characterise/data";
  if (!fs::is_directory(crop)) GTEST_SKIP() << "no shared data";
  const Scratch scratch;
  write_file(scratch / "make.py", kMakeSet);
  const Result made = scratch.run(MTFKIT_PYTHON " make.py '" + (crop / "emva_ref001_crop").string() + "'");
  if (made.status != 0) GTEST_SKIP() << "no numpy: " << made.err;
  const Result run = scratch.run("mtf characterize EMVA1288_Data.txt --method emva1288 -o camera --format json");
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, read_file(scratch / "camera/result.json"));
  EXPECT_FALSE(fs::exists(scratch / "camera/sensor.toml"));
  const Json document = Json::parse(run.out);
  const auto number = [&](const std::string& name) {
    for (const Json& one : document.at("numbers"))
      if (one.at("name") == name) return one;
    throw std::runtime_error(name);
  };
  for (const auto& [name, value] : kReference) {
    EXPECT_NEAR(number(name).at("value").get<double>(), value, 1e-6 * std::abs(value)) << name;
    EXPECT_GT(number(name).at("sd").get<double>(), 0.0) << name;
  }
  for (const char* const name : {"DSNU", "DSNU_pixel"}) {  // where the reference implementation has NaN
    EXPECT_TRUE(number(name).at("value").is_null());
    expect_says(number(name).at("why").get<std::string>(), {"variance is negative"});
  }
  // Temporal row noise, which the standard takes for a pattern.
  expect_says(number("DSNU_row").at("note").get<std::string>(), {"fixed part is 0 .. 0.2"});
  expect_says(document.at("biases").get<std::string>(), {"does not describe the frames"});
  const Result table = scratch.run("mtf characterize EMVA1288_Data.txt --method emva1288");
  expect_says(table.out, {"0.2802 +- 0.001", "note: DSNU_row", "50 levels with light, stacks of two frames"});
  // The method of this toolkit reads the same file; no gain of it describes this camera.
  const Result fit = scratch.run("mtf characterize EMVA1288_Data.txt -o fit");
  EXPECT_EQ(fit.status, 3) << fit.err;
  EXPECT_TRUE(fs::exists(scratch / "fit/sensor.toml"));
  // The frames are a part of the sensor that its descriptor speaks of.
  write_file(scratch / "EMVA1288_Data.txt",
             replaced(read_file(scratch / "EMVA1288_Data.txt"), "n 12 96 64", "n 12 1000 800"));
  for (const char* const method : {"", " --method emva1288"})
    expect_error(scratch.run(std::string("mtf characterize EMVA1288_Data.txt") + method), 2,
                 {"EMVA1288_Data.txt", "line n", "1000 x 800", "96 x 64"});
}

TEST(Emva1288Command, BadDescriptorsAreRefusedByTheirLines) {
  const Scratch scratch;
  for (const char* const name : {"a.png", "b.png"}) write_file(scratch / name, "");
  const auto refused = [&](const std::string& text, std::initializer_list<std::string_view> parts) {
    write_file(scratch / "set.txt", text);
    for (const char* const method : {"", " --method emva1288"})
      expect_error(scratch.run(std::string("mtf characterize set.txt") + method), 2, parts);
  };
  const std::string head = "# set\nv 3.0\nn 12 32 24\n", frames = "i a.png\ni b.png\n",
                    level = "b 40000 120\n" + frames;
  refused(head + level + "x 3\n", {"set.txt:7", "'x 3'", "v, n, l, b, d, i"});
  refused(head + level + "bb 40000 120\n", {"set.txt:7", "'bb 40000 120'"});
  refused(head + "b 40000\n" + frames, {"set.txt:4", "b 40000 120"});
  refused(head + "b 40000 12O\n" + frames, {"set.txt:4", "b 40000 120"});
  refused(head + "b 40000 0\n" + frames, {"set.txt:4", "opens with d"});
  refused(head + "d -1\n" + frames, {"set.txt:4", "d 40000"});
  refused(head + "n 8 32 24\n", {"set.txt:4", "second line n"});
  refused("n 99 32 24\n", {"set.txt:1", "1 to 31 bits"});
  refused("n 12 32.5 24\n", {"set.txt:1", "whole numbers from 1"});
  refused(level, {"set.txt:3", "n 12 640 480"});
  refused(head, {"set.txt:3", "no stack"});
  refused(head + frames, {"set.txt:4", "before the first stack"});
  refused(head + "b 40000 120\ni a.png\nd 40000\n" + frames, {"set.txt:6", "set.txt:4", "has 1 frame"});
  refused(head + level + "i images\\c.png\n", {"set.txt:7", "no file images/c.png"});
}

}  // namespace
}  // namespace apps_test
