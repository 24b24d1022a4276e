// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/config/config.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace mtf::io {
namespace {

// Line 1 to 8 of every file below; what is tested starts on line 9.
const std::string kHead =
    "schema = 1\n"
    "[frame]\n"
    "focal_length = \"100 mm\"\n"
    "pitch = \"15 um\"\n"
    "[optics]\n"
    "f_number = 2.0\n"
    "wavelength = \"4 um\"\n"
    "\n";

std::vector<std::string> messages(const std::string& text, bool errors = true) {
  std::vector<std::string> lines;
  for (const Diagnostic& d : parse_config(text, "s.toml").diagnostics)
    if (d.error == errors) lines.push_back(format_diagnostic(d, "s.toml"));
  return lines;
}

/// Exactly one error, which begins with `start` and holds every one of `parts`.
void expect_one(const std::string& text, const std::string& start, const std::vector<std::string>& parts = {}) {
  const auto lines = messages(text);
  ASSERT_EQ(lines.size(), 1u) << text << (lines.empty() ? "" : lines[0] + "\n" + lines.back());
  EXPECT_TRUE(lines[0].starts_with(start)) << lines[0] << "\nexpected " << start;
  for (const auto& part : parts) EXPECT_TRUE(says(lines[0], part)) << lines[0] << "\nlacks " << part;
  EXPECT_FALSE(says(lines[0], "\n")) << lines[0];
}

std::string head_with(const std::string& from, const std::string& to) {
  std::string text = kHead;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, from.size(), to);
}

TEST(ConfigErrors, NoneInTheHead) { EXPECT_TRUE(messages(kHead).empty()) << messages(kHead)[0]; }

TEST(ConfigErrors, FrameOutOfRange) {
  for (const std::string bad : {"-100 mm", "0 mm"})
    expect_one(head_with("100 mm", bad), "s.toml:3:16: error: frame.focal_length: ", {" mm is outside [1e-06, 1e+07]"});
  for (const std::string bad : {"-15 um", "0 um"})
    expect_one(head_with("15 um", bad), "s.toml:4:9: error: frame.pitch: ", {" um is outside [1e-06, 1e+06]"});
  for (const std::string bad : {"-4 um", "0 um"})
    expect_one(head_with("4 um", bad), "s.toml:7:14: error: optics.wavelength: ", {"is outside [0.01, 1e+05]"});
  expect_one(head_with("2.0", "-2.0"), "s.toml:6:12: error: optics.f_number: -2", {"is outside [0.1, 10000]"});
  for (const std::string bad : {"1.0", "-0.1", "7"})
    expect_one(head_with("f_number", "obscuration = " + bad + "\nf_number"),
               "s.toml:6:15: error: optics.obscuration: ", {"is outside [0, 1)"});
  expect_one(head_with("[optics]", "format = [640, 0]\n[optics]"),
             "s.toml:5:10: error: frame.format: [640, 0] has to be");
  expect_one(head_with("[optics]", "format = [99999999999, 1]\n[optics]"), "s.toml:5:10: error: frame.format: ");
}

TEST(ConfigErrors, UnknownKeysAndKinds) {
  expect_one(kHead + "[scene]\nsampel = \"3 um\"\n", "s.toml:10:1: error: scene.sampel: unknown key in [scene]",
             {"did you mean \"sample\"?", "known: ", "ifov", "border_value"});
  expect_one(head_with("pitch", "pich"), "s.toml:4:1: error: frame.pich: unknown key", {"did you mean \"pitch\"?"});
  expect_one(head_with("wavelength", "wavlength"), "s.toml:7:1: error: optics.wavlength",
             {"did you mean \"wavelength\"?"});
  expect_one(kHead + "[sceen]\n", "s.toml:9:2: error: sceen: unknown key", {"did you mean \"scene\"?"});
  expect_one(kHead + "[[presample]]\nkind = \"jiter\"\nrms = \"1 um\"\n",
             "s.toml:10:8: error: presample[0].kind: unknown kind \"jiter\"",
             {"did you mean \"jitter\"?", "footprint"});
  expect_one(kHead + "[[presample]]\nkind = \"diffraction\"\n[[presample]]\nkind = \"jitter\"\nrmz = \"1 um\"\n",
             "s.toml:13:1: error: presample[1].rmz:",
             {"unknown key", "[[presample]] jitter", "did you mean \"rms\"?", "rms_x, rms_y"});
  expect_one(kHead + "[[presample]]\nrms = \"1 um\"\n", "s.toml:9:1: error: presample[0].kind: missing", {"jitter"});
  expect_one(kHead + "[scene]\nborder = \"mirror\"\n", "s.toml:10:10: error: scene.border: unknown word \"mirror\"",
             {"reflect, replicate, constant, periodic"});
}

TEST(ConfigErrors, Utf16SaysSoAndHowToSave) {
  const auto wide = [](const std::string& mark, bool low_first) {
    std::string text = mark;
    for (const char c : kHead) text += low_first ? std::string{c, '\0'} : std::string{'\0', c};
    return text;
  };
  for (const std::string& text : {wide("\xFF\xFE", true), wide("\xFE\xFF", false), wide("", true), wide("", false)})
    expect_one(text, "s.toml:1:1: error: the text is UTF-16; save it as UTF-8", {"iconv -f UTF-16 -t UTF-8"});
  EXPECT_TRUE(messages("\xEF\xBB\xBF" + kHead).empty());  // the mark of UTF-8 is none of the text
}

TEST(ConfigErrors, Units) {
  expect_one(head_with("\"15 um\"", "15"), "s.toml:4:9: error: frame.pitch: 15", {"no unit", "\"15 um\""});
  // 0.15 was meant in metres: the example is a typical value, never the number that stood there.
  expect_one(head_with("\"100 mm\"", "0.15"), "s.toml:3:16: error: frame.focal_length: 0.15 has no unit",
             {"write it with its unit, such as \"100 mm\""});
  expect_one(head_with("15 um", "15 furlong"),
             "s.toml:4:9: error: frame.pitch:", {"unknown unit \"furlong\"", "\"15 um\""});
  expect_one(head_with("15 um", "15 umm"), "s.toml:4:9: error: ", {"did you mean \"um\"?"});
  expect_one(head_with("15 um", "15 urad"), "s.toml:4:9: error: frame.pitch: ", {"does not fit"});
  expect_one(head_with("15 um", "15"), "s.toml:4:9: error: frame.pitch: \"15\": no unit");
  expect_one(head_with("15 um", "1e400 um"), "s.toml:4:9: error: frame.pitch: ", {"out of range"});
  expect_one(head_with("15 um", "nan um"), "s.toml:4:9: error: frame.pitch: ", {"not finite"});
  expect_one(head_with("15 um", "1e305 km"), "s.toml:4:9: error: frame.pitch: ", {"out of range"});
  expect_one(head_with("\"15 um\"", "true"), "s.toml:4:9: error: frame.pitch:", {"number with unit"});
  expect_one(head_with("2.0", "\"2.0\""), "s.toml:6:12: error: optics.f_number: \"2.0\" is a string",
             {"f_number = 2.0 without quotes"});
  expect_one(head_with("2.0", "\"2 um\""), "s.toml:6:12: error: optics.f_number:", {"\"2 um\"", "plain number"});
  for (const std::string bad : {"nan", "inf", "-inf"})
    expect_one(head_with("2.0", bad), "s.toml:6:12: error: optics.f_number: ", {bad + " is not finite"});
  expect_one(head_with("2.0", "1e400"), "s.toml:6:", {"not valid TOML", "1e400"});
}

TEST(ConfigErrors, QuotesThatAreMissing) {
  const auto expect_hint = [](const std::string& written, const std::string& quoted) {
    expect_one(head_with("\"15 um\"", written), "s.toml:4:", {"not valid TOML", "stand in quotes: \"" + quoted + "\""});
  };
  expect_hint("15 um", "15 um");
  expect_hint("15um  # of the detector", "15um");
  expect_hint("infrared", "infrared");
  expect_hint("thermal\r", "thermal");
  expect_hint("true_colour", "true_colour");
  expect_hint("15 µm", "15 µm");
  expect_hint("+15 um", "+15 um");
  for (const std::string other : {"1e400", "15 um\"", "", "=", "1..5", "[1, 2", "1 2", "True", "15 b = 2", "#", "# um"})
    for (const std::string& line : messages(head_with("\"15 um\"", other)))
      EXPECT_FALSE(says(line, "stand in quotes")) << line;
  expect_one(kHead + "[a]\nb = true\nb = true", "s.toml:11:", {"not valid TOML"});
  EXPECT_FALSE(says(messages(kHead + "[a]\nb = true\nb = true")[0], "stand in quotes"));
  EXPECT_FALSE(says(messages(kHead + "[a]\nb = \"1 um\"\nb = \"1 um\"")[0], "stand in quotes"));
}

TEST(ConfigErrors, StructureOfTheFile) {
  expect_one("schema = 1\n[frame\n", "s.toml:2:", {"not valid TOML"});
  expect_one(kHead + "[scene]\ngain = 1\ngain = 2\n", "s.toml:11:", {"not valid TOML"});
  expect_one(head_with("schema = 1", "schema = 3"), "s.toml:1:10: error: schema: 3", {"schema = 1 to 2"});
  expect_one(head_with("schema = 1", "schema = \"1\""), "s.toml:1:10: error: schema: ");
  expect_one(head_with("schema = 1", ""), "s.toml: error: schema: missing; write schema = 2");
  expect_one("schema = 1\n", "s.toml: error: frame: missing; write [frame]");
  expect_one("schema = 1\nframe = 3\n", "s.toml:2:9: error: frame:", {"a table"});
  expect_one(head_with("focal_length = \"100 mm\"\n", ""), "s.toml:2:1: error: frame.focal_length: missing");
  expect_one(kHead + "[presample]\nkind = \"jitter\"\n", "s.toml:9:1: error: presample:", {"a list", "[[presample]]"});
  expect_one(std::string("x = ") + std::string(200, '['), "s.toml:1:37: error: nested too deep");
  std::string dots = "a";
  for (int i = 0; i < 300000; ++i) dots += ".a";
  expect_one(dots + " = 1", "s.toml:1:34: error: nested too deep");
  expect_one("[" + dots + "]", "s.toml:1:35: error: nested too deep");
  expect_one("# " + std::string(1 << 20, '.'), "s.toml: error: the file has ", {"at most 1 MiB"});
  EXPECT_TRUE(messages(kHead + "# " + dots.substr(0, 1000) + "\nname = \"" + dots.substr(0, 100) + "\"\n").size() == 1u)
      << "name inside [optics] is the one error; dots in comments and strings are none";
}

TEST(ConfigErrors, Pairs) {
  expect_one(head_with("pitch", "pitch_x"), "s.toml:4:11: error: frame.pitch_x: given without pitch_y");
  expect_one(head_with("[optics]", "pitch_y = \"15 um\"\n[optics]"),
             "s.toml:5:11: error: frame.pitch_y:", {"with pitch"});
  const std::string jitter = kHead + "[[presample]]\nkind = \"jitter\"\n";
  expect_one(jitter + "rms_x = \"1 um\"\n", "s.toml:11:9: error: presample[0].rms_x: given without rms_y");
  expect_one(jitter + "rms = \"1 um\"\nrms_y = \"1 um\"\n", "s.toml:12:9: error: presample[0].rms_y:", {"with rms"});
  expect_one(jitter + "rms_x = \"1 um\"\nrms_y = \"-1 um\"\n",
             "s.toml:12:9: error: presample[0].rms_y: -1 um is outside [0, 1e+09]");
  expect_one(jitter, "s.toml:9:1: error: presample[0].rms: missing; write for example rms = \"8 urad\"");
}

TEST(ConfigErrors, Scene) {
  const std::string scene = kHead + "[scene]\n";
  expect_one(scene + "sample = \"0 um\"\n", "s.toml:10:10: error: scene.sample: 0 um is outside (0, 1e+06]");
  expect_one(scene + "sample = \"1 um\"\nifov = \"1 urad\"\n",
             "s.toml:11:8: error: scene.ifov:", {"already by sample"});
  expect_one(scene + "gsd = \"1 m\"\n", "s.toml:10:7: error: scene.gsd: given without range");
  expect_one(scene + "sample_y = \"1 um\"\n", "s.toml:10:12: error: scene.sample_y: given without sample_x");
  expect_one(scene + "gain = 0\n", "s.toml:10:8: error: scene.gain: 0 would");
  expect_one(scene + "border_value = 1.0\n", "s.toml:10:16: error: scene.border_value: needs border = \"constant\"");
  expect_one(scene + "aperture_size = \"1 um\"\n", "s.toml:10:17: error: scene.aperture_size: needs aperture");
  expect_one(scene + "aperture = \"gaussian\"\n", "s.toml:9:1: error: scene.aperture_size: missing");
  expect_one(scene + "aperture = \"curve\"\n", "s.toml:9:1: error: scene.aperture_file: missing");
  expect_one(scene + "aperture = \"box\"\naperture_gain_limit = 1.0\n",
             "s.toml:11:23: error: scene.aperture_gain_limit: 1 is outside (1, 1e+06]");
}

TEST(ConfigErrors, Band) {
  const std::string text = head_with("wavelength = \"4 um\"\n", "") + "[band]\n";
  expect_one(text + "wavelength = [\"4.8 um\", \"3.4 um\"]\n",
             "s.toml:9:14: error: band.wavelength:", {"two increasing"});
  expect_one(text + "wavelength = [\"3.4 um\"]\n", "s.toml:9:14: error: band.wavelength: ", {"is no pair"});
  expect_one(text + "wavelength = [\"3.4 um\", 5]\n", "s.toml:9:25: error: band.wavelength: 5 has no unit");
  expect_one(text, "s.toml:8:1: error: band.wavelength: missing");
  expect_one(kHead + "[band]\nwavelength = [\"3.4 um\", \"4.8 um\"]\n",
             "s.toml:7:14: error: optics.wavelength:", {"twice"});
}

TEST(ConfigErrors, Components) {
  const auto list = [](const std::string& name, const std::string& body) {
    return kHead + "[[" + name + "]]\n" + body;
  };
  expect_one(list("postsample", "kind = \"footprint\"\nwidth = \"15 um\"\n"),
             "s.toml:10:8: error: postsample[0].kind: \"footprint\"", {"[[postsample]]"});
  expect_one(list("presample", "kind = \"diffraction\"\n[[presample]]\nkind = \"diffraction\"\n"),
             "s.toml:12:8: error: presample[1].kind:", {"second complete pupil"});
  expect_one(list("presample",
                  "kind = \"jitter\"\nlabel = \"a\"\nrms = \"1 um\"\n[[presample]]\nkind = \"jitter\"\n"
                  "rms = \"1 um\"\nlabel = \"a\"\n"),
             "s.toml:16:9: error: presample[1].label: \"a\"", {"another component"});
  expect_one(list("readout", "kind = \"butterworth\"\ncutoff = \"40 cy/mm\"\npoles = 3.0\n"),
             "s.toml:12:9: error: readout[0].poles: 3.0", {"whole number"});
  expect_one(list("readout", "kind = \"butterworth\"\ncutoff = \"40 cy/mm\"\npoles = 21\n"),
             "s.toml:12:9: error: readout[0].poles: 21 is outside [1, 20]");
  expect_one(list("readout", "kind = \"rc_lowpass\"\ncutoff = 40\n"), "s.toml:11:10: error: readout[0].cutoff: 40",
             {"no unit", "\"40 cy/mm\""});
  expect_one(list("readout", "kind = \"rc_lowpass\"\ncutoff = \"25 kHz\"\n"),
             "s.toml:11:10: error: readout[0].cutoff:", {"kHz", "scan_velocity"});
  expect_one(list("readout", "kind = \"rc_lowpass\"\ncutoff = \"25 cy/mm\"\nscan_rate = \"1 rad/s\"\n"),
             "s.toml:12:13: error: readout[0].scan_rate:", {"spatial frequency"});
  expect_one(
      list("readout", "kind = \"rc_lowpass\"\ncutoff = \"25 kHz\"\nscan_rate = \"1 rad/s\"\npixel_clock = \"1 MHz\"\n"),
      "s.toml:12:13: error: readout[0].scan_rate:", {"one of", "scan_velocity, scan_rate, pixel_clock"});
  expect_one(list("readout", "kind = \"rc_lowpass\"\ncutoff = \"25 um\"\n"),
             "s.toml:11:10: error: readout[0].cutoff: \"25 um\"", {"does not fit", "\"40 cy/mm\"", "\"0.6 cy/px\""});
  expect_one(list("postsample", "kind = \"fir\"\ntaps = [1, 2, 1]\n"),
             "s.toml:11:8: error: postsample[0].taps: has to be");
  expect_one(list("postsample", "kind = \"fir\"\ntaps = [[1, \"2\", 1]]\n"),
             "s.toml:11:13: error: postsample[0].taps: \"2\" is a string");
  expect_one(list("postsample", "kind = \"fir\"\ntaps = [[1, 1]]\n"),
             "s.toml:11:8: error: postsample[0].taps:", {"odd"});
  expect_one(list("presample", "kind = \"curve\"\nfile = \"no_such.csv\"\n"),
             "s.toml:11:8: error: presample[0].file: cannot read no_such.csv");
  expect_one(list("presample", "kind = \"curve\"\nfile = \"\"\"\nfrequency_cy_mm,mtf\n0,1\n9,x\n\"\"\"\n"),
             "s.toml:11:8: error: presample[0].file: text:3:", {"\"x\""});
  expect_one(list("presample", "kind = \"curve\"\nfile = \"\"\"\nlens\n.csv\"\"\"\n"),
             "s.toml:11:8: error: presample[0].file: text:1: one column only");
  expect_one(list("presample", "kind = \"linear_motion\"\ntravel = \"1 um\"\nvelocity = \"1 mm/s\"\n"),
             "s.toml:11:10: error: presample[0].travel: give exactly one");
  expect_one(list("presample", "kind = \"linear_motion\"\nvelocity = \"1 furlong/s\"\n"),
             "s.toml:11:12: error: presample[0].velocity: ");
}

TEST(ConfigErrors, FitTables) {
  const auto with = [](const std::string& table) {
    return kHead + "[[presample]]\nkind = \"jitter\"\nrms = " + table + "\n";
  };
  expect_one(with("{ value = \"8 um\", fit = true, mn = \"1 um\" }"),
             "s.toml:11:37: error: presample[0].rms.mn: unknown key", {"did you mean \"min\"?"});
  expect_one(with("{ fit = true }"), "s.toml:11:7: error: presample[0].rms: has no value");
  expect_one(with("{ value = 8 }"), "s.toml:11:17: error: presample[0].rms.value: 8 has no unit");
  expect_one(with("{ value = \"8 um\", min = \"9 um\" }"),
             "s.toml:11:31: error: presample[0].rms.min: \"9 um\" is above");
  expect_one(with("{ value = \"8 um\", max = \"7 um\" }"),
             "s.toml:11:31: error: presample[0].rms.max: \"7 um\" is below");
  expect_one(with("{ value = \"8 um\", min = \"1 urad\" }"),
             "s.toml:11:31: error: presample[0].rms.min:", {"\"1 urad\"", "in um"});
  expect_one(with("{ value = \"8 um\", fit = 1 }"), "s.toml:11:31: error: presample[0].rms.fit:", {"true"});
  expect_one(with("{ value = \"8 um\", prior = { mean = \"8 um\", sd = \"0 um\" } }"),
             "s.toml:11:55: error: presample[0].rms.prior.sd:", {"\"0 um\"", "above 0"});
  expect_one(with("{ value = \"8 um\", prior = { mean = \"8 um\" } }"),
             "s.toml:11:33: error: presample[0].rms.prior.sd: missing");
  expect_one(with("{ value = \"8 um\", interval = [\"9 um\", \"7 um\"] }"),
             "s.toml:11:36: error: presample[0].rms.interval:", {"low end is above"});
  expect_one(with("{ value = \"8 um\", interval = [\"9 um\", \"10 um\"] }"),
             "s.toml:11:36: error: presample[0].rms.interval:", {"does not hold the value \"8 um\""});
  expect_one(with("{ value = \"8 um\", interval = \"9 um\" }"),
             "s.toml:11:36: error: presample[0].rms.interval:", {"[low, high]"});
  expect_one(with("{ value = \"8 um\", interval = [\"1 urad\", \"9 um\"] }"),
             "s.toml:11:36: error: presample[0].rms.interval:", {"\"1 urad\"", "in um"});
  expect_one(with("{ value = \"8 um\", stderr = \"1 um\", interval = [\"0 um\", \"9 um\"] }"),
             "s.toml:11:53: error: presample[0].rms.interval:", {"without stderr"});
  expect_one(with("{ value = \"-8 um\" }"), "s.toml:11:17: error: presample[0].rms: -8 um is outside [0, 1e+09]");
}

TEST(ConfigErrors, AllInOnePassInTheOrderOfTheFile) {
  const auto lines = messages(
      "schema = 1\n[frame]\nfocal_length = 100\npitch = \"-15 um\"\n[scene]\nsampel = \"1 um\"\n[optics]\nf_number = "
      "2.0\n"
      "[[presample]]\nkind = \"diffraction\"\n[[presample]]\nkind = \"jitter\"\nrms = \"-2 um\"\n[[presample]]\n"
      "kind = \"footprnt\"\n[[presample]]\nkind = \"gaussian\"\nsigma = \"-3 um\"\n");
  const std::vector<std::string> starts{"s.toml:3:16: error: frame.focal_length: 100 has no unit",
                                        "s.toml:4:9: error: frame.pitch: -15 um",
                                        "s.toml:6:1: error: scene.sampel",
                                        "s.toml:9:1: error: presample[0].wavelength: missing",
                                        "s.toml:13:7: error: presample[1].rms: -2 um",
                                        "s.toml:15:8: error: presample[2].kind",
                                        "s.toml:18:9: error: presample[3].sigma: -3 um"};
  ASSERT_EQ(lines.size(), starts.size()) << (lines.empty() ? "" : lines.back());
  for (std::size_t i = 0; i < lines.size(); ++i) EXPECT_TRUE(lines[i].starts_with(starts[i])) << lines[i];
}

TEST(ConfigErrors, NotesAndWarningsAreNoErrors) {
  const auto notes = messages(kHead, false);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_TRUE(says(notes[0], "presample: no diffraction")) << notes[0];
  EXPECT_TRUE(notes[1].starts_with("s.toml: note: presample: no detector footprint")) << notes[1];
  const auto warnings = messages(kHead + "[[presample]]\nkind = \"rms_wavefront\"\nrms = 0.15\n", false);
  ASSERT_EQ(warnings.size(), 3u);
  EXPECT_TRUE(warnings[2].starts_with("s.toml:11:7: warning: presample[0].rms: ")) << warnings[2];
}

TEST(ConfigErrors, ALensInAirHasAHalfAtLeast) {
  const auto lens = [](const std::string& f_number) {
    std::string text = kHead;
    text = replaced(text, "f_number = 2.0", f_number);
    for (const std::string& message : messages(text, false))
      if (message.find(": warning: ") != std::string::npos) return message;
    return std::string();
  };
  EXPECT_EQ(lens("f_number = 0.5"), "");
  EXPECT_TRUE(lens("f_number = 0.49").starts_with("s.toml:6:12: warning: optics.f_number: an f-number of 0.49"));
  EXPECT_TRUE(lens("aperture = \"250 mm\"").starts_with("s.toml:6:12: warning: optics.aperture: an f-number of 0.4"));
}

TEST(ConfigErrors, UnitsThatAreWrongByAThousandLeaveTheRangeOfQ) {
  using Lines = std::vector<std::string>;
  const auto warnings = [](const std::string& from, const std::string& to, const std::string& pupil) {
    Lines lines;
    for (const std::string& message : messages(head_with(from, to) + "[[presample]]\nkind = \"" + pupil + "\n", false))
      if (message.find(": warning: ") != std::string::npos) lines.push_back(message);
    return lines;
  };
  const auto expect_q = [](const Lines& lines, std::string_view place, std::string_view q) {
    ASSERT_EQ(lines.size(), 1u);
    expect_says(lines[0], {place, q, "0.05 to 5"});
  };
  const std::string diffraction = "diffraction\"", both = "pitch = \"15 um\"";
  EXPECT_EQ(warnings("15 um", "15 um", diffraction), Lines{});
  EXPECT_EQ(warnings("15 um", "5 mm", diffraction), Lines{});  // Q = 0.0016, a scanner
  EXPECT_EQ(warnings("2.0", "100", diffraction), Lines{});     // Q = 27, a pinhole
  expect_q(warnings("15 um", "15 mm", diffraction), "s.toml:4:9: warning: frame.pitch", "8 um / 15000 um = 0.000533");
  expect_q(warnings("4 um", "4 mm", diffraction), "s.toml:4:9: warning: frame.pitch", "8000 um / 15 um = 533");
  expect_q(warnings("f_number = 2.0", "aperture = \"50 um\"", diffraction), "s.toml:4:9: warning: frame.pitch",
           "8000 um / 15 um = 533");
  expect_q(warnings(both, "pitch_x = \"15 um\"\npitch_y = \"15 mm\"", diffraction),
           "s.toml:5:11: warning: frame.pitch_y:", "8 um / 15000 um");
  // What counts is the pupil's own f-number and wavelength.
  EXPECT_EQ(warnings("4 um", "4 mm", diffraction + "\nwavelength = \"4 um\""), Lines{});
  expect_q(warnings("2.0", "2.0", diffraction + "\nf_number = 2000"), "s.toml:4:9: warning: frame.pitch",
           "8000 um / 15 um = 533");
}

TEST(ConfigErrors, EveryKindOfFootprintIsOne) {
  for (const std::string footprint :
       {"kind = \"footprint\"\nwidth = \"10 um\"\n", "kind = \"circular_footprint\"\ndiameter = \"10 um\"\n",
        "kind = \"polygon_footprint\"\nvertices = [[-0.5, -0.5], [0.5, -0.5], [0, 0.5]]\n"
        "unit_length = \"10 um\"\n"}) {
    const auto notes = messages(kHead + "[[presample]]\n" + footprint, false);
    ASSERT_EQ(notes.size(), 1u) << footprint << notes.back();
    EXPECT_TRUE(says(notes[0], "presample: no diffraction")) << notes[0];
  }
}

TEST(ConfigErrors, ManyAndLongOnesStayBounded) {
  std::string text = kHead + "[scene]\n";
  for (int i = 0; i < 90000; ++i) text += "gai" + std::to_string(i) + "=1\n";  // each of them near a known key
  EXPECT_LE(messages(text).size(), 1000u);
  expect_one(kHead + std::string(300000, 'k') + " = 1\n", "s.toml:9:1: error: optics.kkk");
  EXPECT_LT(messages(kHead + std::string(300000, 'k') + " = 1\n")[0].size(), 1000u);
  expect_one(head_with("15 um", "15 " + std::string(300000, 'u')), "s.toml:4:9: error: frame.pitch:", {"this length"});
  std::string many = kHead;
  for (int i = 0; i < 300; ++i) many += "[[presample]]\nkind = \"diffraction\"\n";
  expect_one(many, "s.toml:9:1: error: presample:", {"256 components"});
}

TEST(ConfigErrors, LoadThrowsAllOfThem) {
  const std::string path = testing::TempDir() + "config_errors.toml";
  std::ofstream(path) << head_with("15 um", "15 umm") << "[scene]\ngain = 0\n";
  try {
    load_config(path);
    FAIL() << "no exception";
  } catch (const UsageError& error) {
    const std::string what = error.what();
    EXPECT_EQ(std::count(what.begin(), what.end(), '\n'), 1);
    EXPECT_TRUE(what.starts_with(path + ":4:9: error: ")) << what;
    expect_says(what, {"\n" + path + ":10:8: error: "});
  }
  // Files in each other's place.
  const auto error_of = [&](const std::string& text) -> std::string {
    std::ofstream(path, std::ios::binary) << text;
    return message_of([&] { load_config(path); });
  };
  expect_says(error_of("schema = 1\n[[mesh]]\nname = \"hull\"\n"),
              {path, "3-D scene", "[[mesh]]", "a sensor file belongs"});
  for (const std::string& image :
       {std::string("\x76\x2f\x31\x01 and so on"), "\x89PNG\r\n\x1a\n" + std::string(2 << 20, 'x')})
    expect_says(error_of(image), {path, "it is an image", "a text file belongs"});
  static_cast<void>(std::remove(path.c_str()));
  EXPECT_THROW(load_config(path), RuntimeError);
  EXPECT_THROW(load_config(testing::TempDir()), RuntimeError);
}

}  // namespace
}  // namespace mtf::io
