// SPDX-License-Identifier: Apache-2.0

// Manual pages, and completion as bash does it.

#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"

namespace apps_test {
namespace {

struct Help {
  std::vector<std::string> names;     ///< of options and arguments
  std::vector<std::string> commands;  ///< below it
  std::vector<std::string> examples;
};

/// What `mtf ... --help` lists.
Help help_of(const Scratch& scratch, const std::string& command) {
  Help help;
  std::istringstream lines(scratch.run(command + " --help").out);
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.front() != ' ') section = line;
    if (!line.starts_with("  ") || line.size() < 3 || line[2] == ' ') continue;
    std::istringstream words(line);
    std::string first;
    words >> first;
    std::istringstream names(first);
    if (section == "Subcommands:") help.commands.push_back(first);
    if (section == "Options:" || section == "Positionals:")
      for (std::string name; std::getline(names, name, ',');) help.names.push_back(name);
    if (section == "Examples:") help.examples.push_back(line.substr(2));
  }
  return help;
}

/// Text of a page as a terminal shows it, with single spaces.
std::string shown(const Scratch& scratch, const std::string& page) {
  std::istringstream words(scratch.run("groff -man -Tascii -P-cbou -rHY=0 -rLL=2000n " + page).out);
  std::string text;
  for (std::string word; words >> word;) text += word + " ";
  return text;
}

std::string page_of(std::string command) {
  std::replace(command.begin(), command.end(), ' ', '-');
  return command + ".1";
}

TEST(ManPages, EveryCommandHasOneWithAllThatHelpLists) {
  const Scratch scratch;
  if (scratch.run("groff --version").status != 0) GTEST_SKIP() << "no groff";
  ASSERT_EQ(scratch.run("mtf --man .").status, 0);
  std::vector<std::string> commands{"mtf"};
  std::set<std::string> pages;
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const std::string command = commands[i];
    const Help help = help_of(scratch, command);
    EXPECT_FALSE(help.names.empty() || help.examples.empty()) << command;
    pages.insert(page_of(command));
    const std::string page = shown(scratch, page_of(command));
    for (const std::string& name : help.names) EXPECT_TRUE(says(page, name)) << command << " " << name;
    for (const std::string& example : help.examples)
      EXPECT_TRUE(says(page, example)) << command << "\n" << example << "\n" << page;
    for (const std::string& inner : help.commands) {
      commands.push_back(command + " " + inner);
      std::string name = page_of(commands.back());
      EXPECT_TRUE(says(page, name.substr(0, name.size() - 2) + "(1)")) << name;
    }
    for (const char* heading : {" NAME ", " SYNOPSIS ", " DESCRIPTION ", " OPTIONS ", " EXIT STATUS ", " SEE ALSO "})
      EXPECT_TRUE(says(page, heading)) << command << heading;
  }
  EXPECT_GE(commands.size(), 16U);
  std::set<std::string> written;
  for (const auto& entry : fs::directory_iterator(scratch / ".")) written.insert(entry.path().filename().string());
  EXPECT_EQ(written, pages);
}

TEST(ManPages, AreValidAndOfTheDateThatIsAskedFor) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("SOURCE_DATE_EPOCH=86400 mtf --man .").status, 0);
  expect_says(read_file(scratch / "mtf-curve.1"), {" 1970-01-02 "});
  if (scratch.run("groff --version").status != 0) GTEST_SKIP() << "no groff";
  const Result checked = scratch.run("groff -man -ww -z *.1");
  EXPECT_EQ(checked.status, 0);
  EXPECT_EQ(checked.err, "");
  expect_says(shown(scratch, "mtf-curve.1"), {"MTF = |OTF|."});
}

TEST(ManPages, AFolderThatIsNotThereIsAnError) {
  const Scratch scratch;
  expect_error(scratch.run("mtf --man nowhere"), 1, {"nowhere"});
}

/// Files for completion: images with layers and without, and some that are not what they are called.
class Completion : public testing::Test {
 protected:
  Completion() {
    const mtf::Image plane(4, 3);
    mtf::io::write_exr((scratch / "view.exr").string(),
                       {{"left.Y", plane.view()}, {"right.Y", plane.view()}, {"my layer.Y", plane.view()}}, {});
    mtf::io::write_exr((scratch / "my view.exr").string(), {{"up.Y", plane.view()}}, {});
    write_file(scratch / "broken.exr", "v/1\x01 and no more");
    write_file(scratch / "broken.toml", "[frame\n");
    write_file(scratch / "sensor.toml", "schema = 1\n");
    write_file(scratch / "driver", "source '" MTFKIT_SOURCE_DIR
                                   "/apps/help/mtf.bash'\n"
                                   "COMP_WORDS=(\"$@\")\nCOMP_CWORD=$(($# - 1))\n_mtf\n"
                                   "for word in \"${COMPREPLY[@]}\"; do printf '%s|' \"$word\"; done\n");
  }

  /// What bash would offer for the last of the words, which are written for the shell.
  std::string offered(const std::string& words) const {
    const Result result = scratch.run("bash driver " + words);
    EXPECT_EQ(result.status, 0) << words;
    EXPECT_EQ(result.err, "") << words;
    return result.out;
  }

  const Scratch scratch;
};

TEST_F(Completion, OffersCommandsAndOptions) {
  EXPECT_EQ(offered("mtf cu"), "curve|");
  EXPECT_EQ(offered("mtf config ''"), "init|check|explain|kinds|schema|import|");
  EXPECT_EQ(offered("mtf --quiet --threads 2 sim"), "simulate|");
  EXPECT_EQ(offered("mtf curve --un"), "--unit|");
  EXPECT_EQ(offered("mtf curve sensor.toml --th"), "--threads|");
  EXPECT_EQ(offered("mtf curve sensor.toml --comp"), "");
  for (const char* command : {"mtf", "mtf curve", "mtf config kinds", "mtf simulate"}) {
    const std::string options = "|" + offered(std::string(command) + " -");
    for (const std::string& name : help_of(scratch, command).names) {
      const bool is_long = name.starts_with("--");
      EXPECT_TRUE(!is_long || options.find("|" + name + "|") != std::string::npos) << command << " " << name;
    }
  }
}

TEST_F(Completion, OffersValues) {
  EXPECT_EQ(offered("mtf curve --unit cy/m"), "cy/mm|cy/mrad|");
  EXPECT_EQ(offered("mtf curve --unit = cy/p"), "cy/px|");
  EXPECT_EQ(offered("mtf curve --unit ="), "cy/mm|cy/mrad|cy/px|");
  EXPECT_EQ(offered("mtf --progress pl"), "plain|");
  EXPECT_EQ(offered("mtf config kinds jit"), "jitter|");
  EXPECT_EQ(offered("mtf config kinds vig"), "vignetting|");
  EXPECT_EQ(offered("mtf config init st"), "study|");
  EXPECT_EQ(offered("mtf help cu"), "curve|");
  EXPECT_EQ(offered("mtf config schema st"), "study|");
  EXPECT_EQ(offered("mtf atmosphere --model trop"), "tropical|");
  EXPECT_EQ(offered("mtf render --channel dep"), "depth=|");
  EXPECT_EQ(offered("mtf curve sensor.toml --plot as"), "ascii|");
}

TEST_F(Completion, OffersLayersAndChannelsOfTheImageOnTheLine) {
  EXPECT_EQ(offered("mtf info view.exr --layer ''"), "left|my\\ layer|right|");
  EXPECT_EQ(offered("mtf simulate sensor.toml view.exr --layer = le"), "left|");
  EXPECT_EQ(offered("mtf info 'my\\ view.exr' --layer ''"), "up|");
  EXPECT_EQ(offered("mtf info '\"my view.exr\"' --channel ''"), "up.Y|");
  EXPECT_EQ(offered("mtf info view.exr --part ''"), "0|");
}

TEST_F(Completion, LeavesFilesToTheShell) {
  EXPECT_EQ(offered("mtf curve sens"), "sensor.toml|");
  EXPECT_EQ(offered("mtf curve --freq 0 : 60 : 13 sens"), "sensor.toml|");
  EXPECT_EQ(offered("mtf curve -o my"), "my view.exr|");
  EXPECT_EQ(offered("mtf curve sensor.toml --plot bro"), "broken.exr|broken.toml|");
}

TEST_F(Completion, SaysNothingOfBrokenInputAndWritesNothing) {
  const auto files = [&] { return scratch.run("ls -laR --time-style=full-iso").out; };
  ASSERT_EQ(scratch.run("mkfifo pipe.exr").status, 0);
  const std::string before = files();
  for (const char* words :
       {"simulate broken.toml broken.exr --layer ''", "info broken.exr --channel ''", "info pipe.exr --layer ''",
        "info /dev/zero --layer ''", "info . --layer ''", "info missing.exr --layer ''", "info sensor.toml --part ''",
        "curve --unit none", "no-such-command --layer ''", "curve --freq ''", "-- config nothing ''"}) {
    const Result result = scratch.run(std::string("mtf --complete ") + words);
    EXPECT_EQ(result.status, 0) << words;
    EXPECT_EQ(result.out.find_first_not_of('\n'), std::string::npos) << words << ": " << result.out;
    EXPECT_EQ(result.err, "") << words;
  }
  EXPECT_EQ(scratch.run("mtf --complete").out, "");
  EXPECT_EQ(files(), before);
  EXPECT_EQ(offered("mtf info broken.exr --layer zz"), "");
}

TEST(Help, IsACommandToo) {
  const Scratch scratch;
  for (const std::string command : {"", " curve", " config", " config kinds", " scene demo", " help"}) {
    const Result asked = scratch.run("mtf help" + command);
    EXPECT_EQ(asked.status, 0) << asked.err;
    EXPECT_EQ(asked.out, scratch.run("mtf" + command + " --help").out);
  }
  EXPECT_EQ(scratch.run("mtf --quiet help curve").out, scratch.run("mtf curve --help").out);
  expect_error(scratch.run("mtf help curv"), 2, {"'curv'", "did you mean curve?"});
  expect_error(scratch.run("mtf help config kind"), 2, {"mtf config", "'kind'", "did you mean kinds?"});
  expect_error(scratch.run("mtf help curve sensor.toml"), 2, {"mtf curve", "'sensor.toml'"});
}

TEST(Help, ListsNothingThatIsForTheShellAndTheBuildOnly) {
  const Scratch scratch;
  const std::string help = scratch.run("mtf --help").out;
  ASSERT_NE(help, "");
  EXPECT_FALSE(says(help, "--complete")) << help;
  EXPECT_FALSE(says(help, "--man")) << help;
}

}  // namespace
}  // namespace apps_test
