// SPDX-License-Identifier: Apache-2.0

// The command as a whole: help, version, exit codes, messages, signals, standard streams.

#include <gtest/gtest.h>

#include <vector>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/apps/study/small_study.h"

namespace apps_test {
namespace {

void add_scene(const Scratch& scratch) {
  mtf::Image scene(96, 64);
  for (std::int64_t y = 0; y < 64; ++y)
    for (std::int64_t x = 0; x < 96; ++x) scene.at(x, y) = 4.0F + static_cast<float>((x / 8 + y / 8) % 2);
  for (const char* name : {"scene.exr", "frame.0001.exr", "frame.0002.exr"})
    mtf::io::write_exr((scratch / name).string(), {{"Y", scene.view()}}, {});
}

std::vector<std::string> examples_of(const std::string& help) {
  std::vector<std::string> commands;
  std::size_t at = help.find("Examples:\n");
  if (at == std::string::npos) return commands;
  at = help.find('\n', at) + 1;
  while (help.compare(at, 6, "  mtf ") == 0) {
    const std::size_t end = help.find('\n', at);
    commands.push_back(help.substr(at + 2, end - at - 2));
    if (end == std::string::npos) break;
    at = end + 1;
  }
  return commands;
}

/// edge.png, and sensor.toml with its jitter to be fitted.
void add_edge(const Scratch& scratch) {
  const Result demo = scratch.run("mtf demo -o demo --tolerance 1e-3");
  const mtf::io::ImageFile edge = mtf::io::read_image((scratch / "demo/edge.exr").string());
  mtf::io::write_integer((scratch / "edge.png").string(), {{"Y", edge.planes.front().view()}}, {2e-4, 0.0}, {});
  std::filesystem::copy_file(scratch / "demo/fit.toml", scratch / "sensor.toml",
                             std::filesystem::copy_options::overwrite_existing);
}

/// sensor.toml: a camera with a chain.
void add_camera(const Scratch& scratch) {
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  std::filesystem::copy_file(scratch / "demo/camera.toml", scratch / "sensor.toml",
                             std::filesystem::copy_options::overwrite_existing);
}

/// sensor.toml: the same camera without air.
void add_clear_camera(const Scratch& scratch) {
  add_camera(scratch);
  ASSERT_EQ(scratch.run("sed -i '/^\\[path\\]/,/^$/d' sensor.toml").status, 0);
}

/// The folder `sweep`, as `mtf sweep` leaves it.
void add_sweep(const Scratch& scratch) {
  const Result made =
      scratch.run(MTFKIT_PYTHON " '" MTFKIT_SOURCE_DIR "/tests/report/make_sweep.py' sweep --points 25");
  ASSERT_EQ(made.status, 0) << made.err;
}

/// What a lens program exports of two fields, and of one.
void add_listings(const Scratch& scratch) {
  for (const char* name : {"lens", "axis", "corner"})
    write_file(scratch / (std::string(name) + ".txt"),
               std::string("Listing of Zernike Standard Coefficient Data\nField : ") +
                   (name == std::string("axis") ? "0" : "7") +
                   ".0 (deg)\nWavelength : 4.0 um\nZ 1 0 : 1\nZ 2 0 : p\nZ 3 0 : p\nZ 4 0.1 : p^2\n");
}

class HelpOf : public testing::TestWithParam<const char*> {};

TEST_P(HelpOf, EndsWithTwoExamplesThatRun) {
  const Scratch scratch;
  scratch.add_sensor();
  add_scene(scratch);
  if (GetParam() == std::string("measure") || GetParam() == std::string("fit")) add_edge(scratch);
  if (GetParam() == std::string("config import")) add_listings(scratch);
  if (GetParam() == std::string("budget")) add_camera(scratch);
  if (GetParam() == std::string("range")) add_clear_camera(scratch);
  if (GetParam() == std::string("report")) add_sweep(scratch);
  if (GetParam() == std::string("sweep")) study_test::add_study(scratch);
  if (GetParam() == std::string("optimize"))
    write_file(scratch / "study.toml",
               "schema = 1\nsensor = \"sensor.toml\"\nobjectives = [\"maximize mtf_nyquist\", \"minimize pitch\"]\n"
               "[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"8 um\", \"20 um\"]\n");
  const Result help = scratch.run(std::string("mtf ") + GetParam() + " --help");
  ASSERT_EQ(help.status, 0);
  EXPECT_EQ(help.err, "");
  const auto commands = examples_of(help.out);
  ASSERT_EQ(commands.size(), 2U) << help.out;
  EXPECT_TRUE(help.out.ends_with("  " + commands[1] + "\n")) << help.out;
  for (const std::string& command : commands) {
    const Result result = scratch.run(command);
    EXPECT_EQ(result.status, 0) << command << "\n" << result.out << result.err;
  }
}

std::string test_name(const testing::TestParamInfo<const char*>& parameter) {
  std::string name = std::string("mtf ") + parameter.param;
  for (char& c : name) c = c == ' ' ? '_' : c;
  return name;
}

INSTANTIATE_TEST_SUITE_P(Every, HelpOf,
                         testing::Values("", "demo", "info", "config", "config init", "config check", "config explain",
                                         "config import", "config kinds", "curve", "budget", "simulate", "bench",
                                         "check", "devices", "report", "help"),
                         test_name);
#ifdef MTFKIT_HAVE_CALIB
INSTANTIATE_TEST_SUITE_P(Calib, HelpOf, testing::Values("measure", "fit", "optimize"), test_name);
#endif
#ifdef MTFKIT_HAVE_STUDY
INSTANTIATE_TEST_SUITE_P(Study, HelpOf, testing::Values("range", "sweep"), test_name);
#endif

TEST(Command, VersionNamesTheFftLibraryAndItsLicence) {
  const Scratch scratch;
  const Result result = scratch.run("mtf --version");
  EXPECT_EQ(result.status, 0);
  EXPECT_TRUE(result.out.starts_with("mtf 0.")) << result.out;
  expect_says(result.out, {"\ncommit: ", "\ncompiler: ", "\nFFT: fftw 3.", " (GPL)\n"});
}

TEST(Command, GlobalOptionsWorkOnEitherSide) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string plain = scratch.run("mtf curve sensor.toml").out;
  ASSERT_NE(plain, "");
  EXPECT_EQ(scratch.run("mtf --threads 2 --quiet --progress none curve sensor.toml").out, plain);
  EXPECT_EQ(scratch.run("mtf curve sensor.toml --threads 2 --progress=json --quiet").out, plain);
  const Result noted = scratch.run("mtf config init -o a.toml");
  const Result quiet = scratch.run("mtf config init --quiet -o b.toml");
  EXPECT_NE(noted.err, "");
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(quiet.status, 0);
}

TEST(Command, UsageErrorsSayWhatWasMeant) {
  const Scratch scratch;
  scratch.add_sensor();
  struct Case {
    const char *arguments, *message;
  };
  for (const Case& c : {Case{"", "demo, info, config, curve, budget, atmosphere, simulate"},
                        {"crve", "did you mean curve?"},
                        {"config chek sensor.toml", "did you mean check?"},
                        {"config", "init, check, explain"},
                        {"curve --fromat json sensor.toml", "did you mean --format?"},
                        {"curve sensor.toml --thread 2", "did you mean --threads?"},
                        {"curve sensor.toml --format jsn", "did you mean json?"},
                        {"simulate a b -o c --nan propgate", "did you mean propagate?"},
                        {"simulate sensor.toml scene.exr", "--out"},
                        {"simulate a b -o c --tolerance 2", "--tolerance"},
                        {"simulate a b -o c --range 5:1", "--range"},
                        {"simulate a b -o c --part -1", "--part"},
                        {"curve sensor.toml another.toml", "'another.toml'"},
                        {"curve", "sensor"},
                        {"curve ''", "sensor"},
                        {"''", "''"},
                        {"curve sensor.toml --threads 99999999999999999999", "--threads"},
                        {"info", "file"},
                        {"demo -o ''", "--out"}}) {
    const Result result = scratch.run(std::string("mtf ") + c.arguments);
    EXPECT_EQ(result.status, 2) << c.arguments;
    EXPECT_EQ(result.out, "") << c.arguments;
    EXPECT_EQ(lines(result.err), 1U) << result.err;
    EXPECT_TRUE(says(result.err, c.message)) << c.arguments << ": " << result.err;
  }
}

TEST(Command, FilesNamedLikeSubcommandsAreFiles) {
  const Scratch scratch;
  scratch.add_sensor();
  EXPECT_EQ(scratch.run("cp sensor.toml demo && mtf curve demo").status, 0);
  EXPECT_EQ(scratch.run("cp sensor.toml curve && mtf config check curve").status, 0);
}

TEST(Command, ControlCharactersInNamesDoNotBreakLines) {
  const Scratch scratch;
  scratch.add_sensor();
  write_file(scratch / "bad\nname\x1b[31m.toml", read_file(scratch / "sensor.toml") + "foo = 1\n");
  const std::string name = "\"$(printf 'bad\\nname\\033[31m.toml')\"";
  for (const std::string command : {"curve ", "config check ", "info ", "config explain "}) {
    const Result result = scratch.run("mtf " + command + name);
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(lines(result.err), 1U) << command << result.err;
    EXPECT_FALSE(says(result.err, "\x1b")) << result.err;
  }
  EXPECT_EQ(lines(scratch.run("mtf info \"$(printf 'no\\nfile')\"").err), 1U);
}

TEST(Command, AnOutputThatCannotBeWrittenIsAnError) {
  const Scratch scratch;
  scratch.add_sensor();
  for (const char* command : {"mtf curve sensor.toml >/dev/full", "mtf --help >/dev/full", "mtf --version >&-",
                              "mtf curve sensor.toml >&-", "mtf config init >/dev/full"}) {
    const Result result = scratch.run(command);
    EXPECT_EQ(result.status, 1) << command;
    EXPECT_EQ(lines(result.err), 1U) << command << result.err;
  }
  // The reader has gone before the writer starts.
  const Result pipe = scratch.run(
      "mkfifo fifo; { mtf curve sensor.toml --freq 0:60:20000; echo $? >status; } >fifo & : <fifo; wait; cat status");
  EXPECT_EQ(pipe.out, "141\n");  // as a process that the signal ends
  EXPECT_EQ(pipe.err, "");
}

TEST(Command, SignalsEndItWith130AndLeaveNothing) {
  const Scratch scratch;
  scratch.add_sensor();
  for (const char* signal : {"INT", "TERM"}) {
    // Standard output is a pipe that nobody empties: the command is certain to be at work when the signal comes.
    const Result result = scratch.run(
        std::string("mkfifo fifo; sleep 20 <fifo & s=$!; mtf curve sensor.toml --freq 0:60:500000 --format csv >fifo & "
                    "p=$!; sleep 1; kill -") +
        signal + " $p; wait $p; echo $?; kill $s; rm fifo; ls");
    EXPECT_EQ(result.out, "130\nsensor.toml\n") << result.err;
  }
}

}  // namespace
}  // namespace apps_test
