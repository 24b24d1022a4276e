// SPDX-License-Identifier: Apache-2.0

// The command `mtf`: reads the command line (the only file that sees CLI11), calls one subcommand, and turns exceptions
// into messages and exit codes: 0 ok, 1 run-time or I/O, 2 usage or config, 3 a check failed, 130 interrupted.

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <functional>
#include <iostream>
#include <new>

#include "apps/arguments.h"
#include "apps/interrupt.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/usage_errors.h"
#include "mtf/engines/fftw.h"
#include "mtf/error.h"
#include "mtf/version.h"

namespace apps {
namespace {

using Setter = std::function<void(const std::string&)>;

struct Options {
  Global global;
  CurveOptions curve;
  InfoOptions info;
  ConfigOptions config;
  SimulateOptions simulate;
  DemoOptions demo;
  CheckOptions check;
  BenchOptions bench;
};

constexpr std::array kFormats{std::pair{std::string_view("table"), Format::table},
                              std::pair{std::string_view("csv"), Format::csv},
                              std::pair{std::string_view("json"), Format::json}};
constexpr std::array kTableOrJson{kFormats[0], kFormats[2]};
constexpr std::array kProgress{
    std::pair{std::string_view("auto"), Progress::automatic}, std::pair{std::string_view("plain"), Progress::plain},
    std::pair{std::string_view("json"), Progress::json}, std::pair{std::string_view("none"), Progress::none}};
constexpr std::array kNan{std::pair{std::string_view("refuse"), NanPolicy::refuse},
                          std::pair{std::string_view("fill"), NanPolicy::fill},
                          std::pair{std::string_view("propagate"), NanPolicy::propagate}};
constexpr std::array kRigor{std::pair{std::string_view("estimate"), false},
                            std::pair{std::string_view("measure"), true}};
constexpr std::array kResume{std::pair{std::string_view("auto"), true}, std::pair{std::string_view("no"), false}};
constexpr std::array kTableOrMarkdown{std::pair{std::string_view("table"), false},
                                      std::pair{std::string_view("markdown"), true}};
constexpr std::array kUnits{std::pair{std::string_view("cy/mm"), 0}, std::pair{std::string_view("cy/mrad"), 1},
                            std::pair{std::string_view("cy/px"), 2}};

/// An option whose word is read by us: CLI11's own messages name neither the option nor the remedy.
CLI::Option* add_word(CLI::App& app, const std::string& names, const std::string& type, const std::string& doc,
                      const Setter& set) {
  return app.add_option_function<std::string>(names, set, doc)->type_name(type);
}

/// Text that may not be empty.
CLI::Option* add_text(CLI::App& app, const std::string& names, const std::string& type, const std::string& doc,
                      const Setter& set) {
  const std::string name = names.substr(names.rfind(',') + 1);
  return add_word(app, names, type, doc, [set, name](const std::string& text) {
    if (text.empty()) throw mtf::UsageError(name + ": empty; give it a value");
    set(text);
  });
}

/// A file that has to be named.
void add_file(CLI::App& app, const std::string& name, const std::string& doc, std::string& target) {
  add_text(app, name, "FILE", doc, [&target](const std::string& text) { target = text; })->required();
}

template <class T, std::size_t N>
void add_choice(CLI::App& app, const std::string& name, const std::string& type, const std::string& doc,
                const std::array<std::pair<std::string_view, T>, N>& words, T& target) {
  add_word(app, name, type, doc,
           [&words, &target, name](const std::string& text) { target = choice(name, text, words); });
}

CLI::App& add_command(CLI::App& parent, const std::string& name, const std::string& doc, const std::string& details,
                      const std::string& examples) {
  CLI::App& app = *parent.add_subcommand(name, doc);
  app.fallthrough();  // global options work after the subcommand too
  app.footer((details.empty() ? "" : details + "\n\n") +
             "Global options (mtf --help) may follow as well: --threads, --quiet, --progress.\n\nExamples:\n" +
             examples);
  return app;
}

void add_global(CLI::App& app, Global& global) {
  add_word(app, "--threads", "N", "threads to use; 0 = all cores (default)",
           [&](const std::string& text) { global.threads = whole_number("--threads", text, 0, 4096); });
  app.add_flag("--quiet", global.quiet, "no notes and warnings on standard error, errors only");
  add_choice(app, "--progress", "MODE", "auto (default: on a terminal only), plain, json or none", kProgress,
             global.progress);
}

void add_choice_of_channel(CLI::App& app, std::optional<std::string>& channel, std::optional<std::string>& layer,
                           std::optional<int>& part) {
  add_text(app, "--channel", "NAME", "the channel to use, by its full name",
           [&](const std::string& text) { channel = text; });
  add_word(app, "--layer", "NAME", "the layer to use; '' = the channels without a layer",
           [&](const std::string& text) { layer = text; });
  add_word(app, "--part", "N", "part of a multi-part OpenEXR file, from 0",
           [&](const std::string& text) { part = whole_number("--part", text, 0, 1'000'000); });
}

void add_curve(CLI::App& root, CurveOptions& options) {
  CLI::App& app = add_command(
      root, "curve", "OTF of every component, of each list and of the system",
      "Tables show MTF = |OTF|; csv has one column a component and product, or NAME_re and NAME_im where the OTF is\n"
      "not real; json has real and imaginary parts of all. Both have 17 digits. A component that depends on\n"
      "wavelength is shown averaged over the band by itself; products are averaged as a whole.\n"
      "A figure writes its data beside it as CSV.",
      "  mtf curve sensor.toml --freq 0:60:13 --unit cy/mm\n"
      "  mtf curve sensor.toml --format csv -o curve.csv --plot mtf.svg");
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_text(app, "--freq", "LIST", "START:STOP:COUNT (both ends) or a comma list; default: 61 up to the cutoff",
           [&](const std::string& text) { options.frequencies = text; });
  add_word(app, "--unit", "UNIT", "of the frequencies: cy/mm (default), cy/mrad or cy/px",
           [&](const std::string& text) { options.unit = kUnits[choice("--unit", text, kUnits)].first; });
  add_word(app, "--angle", "DEG",
           "direction in the focal plane, from +x (right) to +y (down); default 0.\n"
           "With cy/px the vector is in pixels of each axis: 0.5 is Nyquist along both",
           [&](const std::string& text) { options.angle_deg = number("--angle", text); });
  add_choice(app, "--format", "FORMAT", "table (default), csv or json", kFormats, options.format);
  add_text(app, "--plot", "FILE", "figure: a .svg, .pdf or .png file, or ascii for the terminal",
           [&](const std::string& text) { options.plot = text; });
  add_text(app, "-o,--out", "FILE", "write the values here instead of standard output",
           [&](const std::string& text) { options.out = text; });
}

void add_info(CLI::App& root, InfoOptions& options) {
  CLI::App& app = add_command(root, "info", "what a file holds, and the command to run next",
                              "Reads OpenEXR, PNG and TIFF images and sensor files (.toml).",
                              "  mtf info scene.exr\n"
                              "  mtf info scene.exr --format json");
  add_file(app, "file", "image or sensor file", options.file);
  add_choice_of_channel(app, options.channel, options.layer, options.part);
  add_choice(app, "--format", "FORMAT", "table (default), csv (of the channels) or json", kFormats, options.format);
}

void add_config(CLI::App& root, ConfigOptions& options) {
  CLI::App& app = add_command(root, "config", "write, check and explain sensor files", "",
                              "  mtf config check sensor.toml\n"
                              "  mtf config explain sensor.toml");
  app.require_subcommand(1, 1);
  CLI::App& init = add_command(app, "init", "a commented sensor file to start from", "",
                               "  mtf config init -o my-sensor.toml\n"
                               "  mtf config init > another.toml");
  init.callback([&] { options.action = ConfigOptions::Action::init; });
  add_text(init, "-o,--out,file", "FILE", "file to write; default: standard output",
           [&](const std::string& text) { options.file = text; });
  init.add_flag("--force", options.force, "replace an existing file");
  CLI::App& check = add_command(app, "check", "all errors of a sensor file in one pass", "",
                                "  mtf config check sensor.toml\n"
                                "  mtf config check sensor.toml --format json");
  check.callback([&] { options.action = ConfigOptions::Action::check; });
  add_file(check, "file", "sensor file (TOML)", options.file);
  add_choice(check, "--format", "FORMAT", "table (default) or json", kTableOrJson, options.format);
  CLI::App& explain = add_command(app, "explain", "what every number becomes after units and defaults", "",
                                  "  mtf config explain sensor.toml\n"
                                  "  mtf config explain sensor.toml > explained.txt");
  explain.callback([&] { options.action = ConfigOptions::Action::explain; });
  add_file(explain, "file", "sensor file (TOML)", options.file);
  CLI::App& kinds = add_command(app, "kinds", "every component: formula, validity, source, and each parameter",
                                "mtf/components/README.md is the output of --format markdown.",
                                "  mtf config kinds\n"
                                "  mtf config kinds jitter");
  kinds.callback([&] { options.action = ConfigOptions::Action::kinds; });
  add_text(kinds, "kind", "KIND", "one component; default: all", [&](const std::string& text) { options.file = text; });
  add_choice(kinds, "--format", "FORMAT", "table (default) or markdown", kTableOrMarkdown, options.markdown);
}

Setter set_tolerance(std::optional<double>& tolerance) {
  return [&tolerance](const std::string& text) {
    tolerance = number("--tolerance", text);
    if (!(*tolerance > 0.0 && *tolerance < 1.0)) throw mtf::UsageError("--tolerance: " + text + " is outside (0, 1)");
  };
}

void add_simulate(CLI::App& root, SimulateOptions& options) {
  CLI::App& app = add_command(
      root, "simulate", "a radiance image through the sensor",
      "Scenes: OpenEXR, PNG, TIFF. Output by extension: .exr (float), .png or .tif (16 bits).\n"
      "The tolerance is the rms error over the output pixels, relative to the scene's standard deviation.\n"
      "A number in a name, as in frame.%04d.exr, makes it a sequence: its frames run in parallel. A schedule\n"
      "has the header frame,parameter,value and lines such as 20,jitter.rms,8 urad: from frame 20 on the\n"
      "component labelled jitter has that rms, as if the sensor file said so. With a schedule the scene may\n"
      "be one image; there is an output for every frame that the schedule names, or those of --frames.",
      "  mtf simulate sensor.toml scene.exr -o out.exr\n"
      "  mtf simulate sensor.toml frame.%04d.exr -o out.%04d.exr --tolerance 1e-3 --report run.json");
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_file(app, "scene", "image of the scene, or frame.%04d.exr for a sequence", options.scene);
  add_text(app, "-o,--out", "FILE", "image to write; of a sequence out.%04d.exr", [&](const std::string& text) {
    options.out = text;
  })->required();
  add_text(app, "--report", "FILE", "what was done, how exactly and how fast, as JSON",
           [&](const std::string& text) { options.report = text; });
  add_choice_of_channel(app, options.channel, options.layer, options.part);
  add_word(app, "--tolerance", "X", "rms error allowed; default 1e-4", set_tolerance(options.tolerance));
  add_choice(app, "--nan", "POLICY", "NaN and infinite pixels: refuse (default), fill or propagate", kNan, options.nan);
  app.add_flag("--explain", options.explain, "show what the plan left out, merged and chose");
  add_choice(app, "--rigor", "RIGOR", "estimate (default, reproducible) or measure (times candidates first)", kRigor,
             options.measure);
  add_text(app, "--wisdom", "FILE",
           "what measuring has learnt: read before, written after; default:\na file in ~/.cache/mtfkit, which may be "
           "deleted at any time",
           [&](const std::string& text) { options.wisdom = text; });
  add_word(app, "--frames", "RANGE", "START:STOP[:STEP], both ends; default: all frames, or those of the schedule",
           [&](const std::string& text) { options.frames = frame_range("--frames", text); });
  add_text(app, "--schedule", "FILE", "parameters that change over frames: CSV with frame,parameter,value",
           [&](const std::string& text) { options.schedule = text; });
  add_word(app, "--memory", "SIZE",
           "most memory to use, such as 512MiB or 2GB: the scene (OpenEXR) goes through in tiles.\n"
           "Without it that is done only where the whole image does not fit the machine",
           [&](const std::string& text) { options.memory = byte_count("--memory", text); });
  add_word(app, "--roi", "X,Y,W,H", "pixels of the output that are wanted; only what they need is computed",
           [&](const std::string& text) { options.region = rectangle("--roi", text); });
  add_choice(app, "--resume", "MODE", "a stopped run in tiles: auto (default) goes on with it, no starts over", kResume,
             options.resume);
  add_word(app, "--range", "LOW:HIGH", "values at 0 and 65535 of 16-bit output; default: extremes of the image",
           [&](const std::string& text) {
             const auto range = number_range("--range", text);
             options.range_low = range[0];
             options.range_high = range[1];
           });
}

void add_demo(CLI::App& root, DemoOptions& options) {
  CLI::App& app = add_command(root, "demo", "the whole chain on an example, with proof, in seconds",
                              "Writes a folder with sensor file, scene, simulated image, previews and MTF plot.",
                              "  mtf demo\n"
                              "  mtf demo -o my-demo --tolerance 1e-5");
  add_text(app, "-o,--out", "FOLDER", "folder to create; default mtf-demo",
           [&](const std::string& text) { options.out = text; });
  add_word(app, "--tolerance", "X", "rms error allowed; default 1e-4", set_tolerance(options.tolerance));
  app.add_flag("--force", options.force, "write into a folder that is not empty");
}

void add_check(CLI::App& root, CheckOptions& options) {
  CLI::App& app = add_command(
      root, "check", "the accuracy promised, verified on this machine and build",
      "Compares the kernels with tables of high precision (built in), and images filtered at the extremes of size,\n"
      "scale, contrast and OTF with slow sums in double. Exit code 3 when a promise is not kept.\n"
      "Absolute and relative errors are the worst found; each value has to keep its own allowance.",
      "  mtf check\n"
      "  mtf check --format json -o check.json");
  add_text(app, "--reference", "FOLDER", "check against your own tables: CSV files named and laid out as the built-in",
           [&](const std::string& text) { options.reference = text; });
  add_choice(app, "--format", "FORMAT", "table (default), csv or json", kFormats, options.format);
  add_text(app, "-o,--out", "FILE", "write the results here instead of standard output",
           [&](const std::string& text) { options.out = text; });
}

void add_bench(CLI::App& root, BenchOptions& options) {
  CLI::App& app = add_command(
      root, "bench", "what each tolerance costs: promised and realised error beside run time",
      "For every decade of tolerance from 1e-1 to 1e-7: the plan that is chosen, every other way that keeps the\n"
      "tolerance, and plain OpenCV, each held against the exact image in double and timed in interleaved rounds with\n"
      "bare FFTW. Writes bench.csv, bench.json, bench.svg and bench.png. Exit code 3 when an error is above its\n"
      "promise. A tolerance that cannot be kept has a row `refused` with the one that can.",
      "  mtf bench sensor.toml scene.exr -o bench --rounds 3 --seconds 5\n"
      "  mtf bench sensor.toml scene.exr -o bench-1 --threads 1 --rounds 3 --seconds 5 --format csv");
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_file(app, "scene", "image of the scene", options.scene);
  add_text(app, "-o,--out", "FOLDER", "folder to create", [&](const std::string& text) {
    options.out = text;
  })->required();
  add_choice_of_channel(app, options.channel, options.layer, options.part);
  add_word(app, "--rounds", "N", "runs of each way; default 15, fewer of slow ones",
           [&](const std::string& text) { options.rounds = whole_number("--rounds", text, 1, 10000); });
  add_word(app, "--seconds", "S", "time for the whole, about; default 60", [&](const std::string& text) {
    options.seconds = number("--seconds", text);
    if (!(options.seconds >= 0.1 && options.seconds <= 1e6))
      throw mtf::UsageError("--seconds: " + text + " is outside 0.1 to 1e6");
  });
  add_choice(app, "--rigor", "RIGOR", "of plans: estimate (default) or measure; bare FFTW is always measured", kRigor,
             options.measure);
  add_choice(app, "--format", "FORMAT", "of standard output: table (default), csv or json", kFormats, options.format);
  app.add_flag("--force", options.force, "write into a folder that is not empty");
}

std::string version_text() {
  const std::string fft = mtf::fft::version();  // "fftw-3.3.10-sse2-avx"
  const std::string number = fft.starts_with("fftw-") ? fft.substr(5, fft.find('-', 5) - 5) : fft;
  return std::string("mtf ") + mtf::version + "\ncommit: " + mtf::git_commit + "\ncompiler: " + mtf::compiler +
         "\nFFT: fftw " + number +
         " (GPL)\nlicence: Apache-2.0; a binary that contains FFTW is passed on under the GPL";
}

int dispatch(const CLI::App& root, const Options& options) {
  if (root.got_subcommand("curve")) return run_curve(options.curve, options.global);
  if (root.got_subcommand("info")) return run_info(options.info, options.global);
  if (root.got_subcommand("config")) return run_config(options.config, options.global);
  if (root.got_subcommand("check")) return run_check(options.check, options.global);
  if (root.got_subcommand("bench")) return run_bench(options.bench, options.global);
  if (root.got_subcommand("simulate")) return run_simulate(options.simulate, options.global);
  return run_demo(options.demo, options.global);
}

/// What CLI11 complains about, with the word that was probably meant.
std::string parse_complaint(const CLI::App& root, const CLI::ParseError& error) {
  const CLI::App* app = &root;
  std::string command = "mtf";
  std::vector<std::string> options, commands;
  const auto collect = [&](const CLI::App& from) {
    for (const CLI::Option* option : from.get_options()) {
      for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
      for (const std::string& name : option->get_snames()) options.push_back("-" + name);
    }
  };
  collect(root);
  while (!app->get_subcommands().empty()) {
    app = app->get_subcommands().front();
    command += " " + app->get_name();
    collect(*app);
  }
  for (const CLI::App* sub : app->get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(sub->get_name());
  return usage_complaint(command, root.remaining(true), options, commands, error.what());
}

int run(int argc, char** argv) {
  Options options;
  CLI::App root("OTF models of electro-optical and infrared sensors: curves, sensor images, error against run time.",
                "mtf");
  root.get_formatter()->column_width(28);
  root.require_subcommand(1, 1);
  root.set_version_flag("--version", version_text, "version, commit, compiler and FFT library");
  root.footer(
      "Exit code: 0 ok, 1 run time or files, 2 usage or config, 3 a check failed, 130 interrupted.\n\n"
      "Examples:\n  mtf demo\n  mtf curve sensor.toml --plot ascii");
  add_global(root, options.global);
  add_demo(root, options.demo);
  add_info(root, options.info);
  add_config(root, options.config);
  add_curve(root, options.curve);
  add_simulate(root, options.simulate);
  add_bench(root, options.bench);
  add_check(root, options.check);
  try {
    root.parse(argc, argv);
  } catch (const CLI::CallForVersion& version) {
    print(std::string(version.what()) + "\n");
    return 0;
  } catch (const CLI::CallForHelp&) {
    print(root.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    throw mtf::UsageError(parse_complaint(root, error));
  }
  return dispatch(root, options);
}

}  // namespace
}  // namespace apps

int main(int argc, char** argv) {
  apps::prepare_process();
  const auto failed = [&](const char* what, int status) {
    apps::complain(apps::error_lines(what, {argv + 1, argv + argc}));
    return status;
  };
  try {
    const int status = apps::run(argc, argv);
    std::cout.flush();
    apps::print("");  // a failure of anything printed shows here at the latest
    return std::cout.good() ? status : 1;
  } catch (const mtf::UsageError& error) {
    return failed(error.what(), 2);
  } catch (const std::bad_alloc&) {
    return failed("out of memory; use a smaller image or fewer frequencies, or free some memory", 1);
  } catch (const std::exception& error) {
    return failed(error.what(), 1);
  } catch (...) {
    return failed("unexpected failure of unknown kind", 1);
  }
}
