// SPDX-License-Identifier: Apache-2.0

// The command `mtf`, in the core library: reads the command line (the only file that sees CLI11), calls one subcommand,
// and turns exceptions into messages and exit codes: 0 ok, 1 run-time or I/O, 2 usage or config, 3 a check failed, 130
// interrupted.

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <functional>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "apps/commands.h"
#include "apps/help/completion.h"
#include "apps/help/man_pages.h"
#include "apps/modules/modules.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/text/message_words.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/stage.h"
#include "mtf/units.h"
#include "mtf/version.h"
#include "mtf/words.h"
#include "mtf/work/usable_memory.h"

namespace apps {
namespace {

// Wording of what is wrong with a command line, and of errors in general.

std::string meant(const std::string& word, const std::vector<std::string>& candidates) {
  const auto nearest = mtf::nearest(word, candidates);
  return nearest ? "; did you mean " + *nearest + "?" : "";
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

/// `command` is what was recognised ("mtf config"), `remaining` the words that were not, `options` and `commands` what
/// is possible there; `otherwise` is used when every word was recognised.
std::string usage_complaint(const std::string& command, const std::vector<std::string>& remaining,
                            const std::vector<std::string>& options, const std::vector<std::string>& commands,
                            const std::string& otherwise) {
  const std::string help = " (see " + command + " --help)";
  const std::string where = command == "mtf" ? "" : command + ": ";
  for (const std::string& word : remaining) {
    if (word == "--") continue;
    const std::string shown = "'" + mtf::printable(word, 80) + "'";
    if (word.size() > 1 && word.front() == '-')
      return where + "unknown option " + shown + meant(word.substr(0, word.find('=')), options) + help;
    if (!commands.empty())
      return where + "unknown subcommand " + shown + meant(word, commands) + " (there are " + joined(commands) + ")";
    return where + "unexpected argument " + shown + help;
  }
  if (!commands.empty()) return where + "give a subcommand: " + joined(commands) + help;
  return where + otherwise + help;
}

/// An error as it is shown: "mtf: error: ..." on one line, or the file:line:col lines of a sensor file as they are.
/// Control characters of the arguments do not break lines.
std::string error_lines(std::string message, const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    const std::string value = argument.starts_with("--") && argument.find('=') != std::string::npos
                                  ? argument.substr(argument.find('=') + 1)
                                  : argument;
    if (const std::string harmless = one_line(value); harmless != value) replace_all(message, value, harmless);
  }
  if (message.find(": error: ") == std::string::npos) return "mtf: error: " + one_line(message);
  std::string lines;
  for (std::size_t at = 0; at <= message.size();) {
    const std::size_t end = std::min(message.find('\n', at), message.size());
    lines += (at > 0 ? "\n" : "") + one_line(message.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

constexpr auto kProgress = enumerated<Progress>("auto", "plain", "json", "none");

void add_option(CLI::App& app, const OptionSpec& option) {
  if (option.flag) {
    app.add_flag_function(
        option.names, [set = option.set](std::int64_t) { set(""); }, option.doc);
    return;
  }
  CLI::Option* added = nullptr;
  if (option.repeats) {
    added = app.add_option_function<std::vector<std::string>>(
        option.names,
        [set = option.set](const std::vector<std::string>& words) {
          for (const std::string& word : words) set(word);
        },
        option.doc);
    // An option takes one word each time it is given, an argument as many as there are.
    if (option.names.front() == '-') added->allow_extra_args(false);
  } else {
    added = app.add_option_function<std::string>(option.names, option.set, option.doc);
  }
  added->type_name(option.type)->required(option.required);
}

/// The command and those below it; whichever is called leaves its `run` in `chosen`.
void add_command(CLI::App& parent, const Command& command, std::function<int(const Global&)>& chosen) {
  CLI::App& app = *parent.add_subcommand(command.name, command.doc);
  app.fallthrough();  // global options work after the subcommand too
  app.footer((command.details.empty() ? "" : command.details + "\n\n") +
             "Global options (mtf --help) may follow as well: --threads, --quiet, --progress.\n\nExamples:\n" +
             command.examples);
  for (const OptionSpec& option : command.options) add_option(app, option);
  if (!command.commands.empty()) app.require_subcommand(command.run ? 0 : 1, 1);
  for (const Command& inner : command.commands) add_command(app, inner, chosen);
  if (!command.run) return;
  app.callback([run = command.run, &chosen] {
    if (!chosen) chosen = run;  // else a command below this one was called, whose turn comes first
  });
}

std::string version_text() {
  const std::string fft = mtf::fft::version();  // "fftw-3.3.10-sse2-avx"
  const std::string number = fft.starts_with("fftw-") ? fft.substr(5, fft.find('-', 5) - 5) : fft;
  return std::string("mtf ") + mtf::version + "\ncommit: " + mtf::git_commit + "\ncompiler: " + mtf::compiler +
         "\nFFT: fftw " + number +
         " (GPL)\nlicence: Apache-2.0; a binary that contains FFTW is passed on under the GPL\n" + modules_text();
}

/// `asked`: the words after `mtf help`. It has nothing to run: help_of() is the answer.
Command help_command(std::vector<std::string>& asked, std::vector<std::string> commands) {
  Command command{"help", "what a command does, and what it takes", "The same as mtf COMMAND --help.",
                  "  mtf help curve\n"
                  "  mtf help config kinds"};
  OptionSpec& words = add_text(command, "command", "COMMAND", "the command, and one of its subcommands; default: mtf",
                               [&asked](const std::string& word) { asked.push_back(word); });
  words.repeats = true;
  words.candidates = [commands = std::move(commands)](const std::vector<std::string>& line) {
    return !line.empty() && line.back() == "help" ? commands : std::vector<std::string>();
  };
  return command;
}

/// The whole command: help, manual pages and completion are made from it.
Command root_command(Global& global, std::vector<std::string>& help_for) {
  Command command{"mtf",
                  "OTF models of electro-optical and infrared sensors: curves, sensor images, error against run time.",
                  "", "  mtf demo\n  mtf curve sensor.toml --plot ascii"};
  add_word(command, "--version", "", "version, commit, compiler, FFT library, and which modules are there",
           [](const std::string&) { throw CLI::CallForVersion(version_text(), 0); })
      .flag = true;
  add_value(command, "--threads", "N", "threads to use; 0 = all cores (default)", global.threads, whole(0, 4096));
  add_flag(command, "--quiet", "no notes and warnings on standard error, errors only", global.quiet);
  add_choice(command, "--progress", "MODE", "auto (default: on a terminal only), plain, json or none", kProgress,
             global.progress);
  command.commands = {demo_command(),   info_command(),       config_command(),   curve_command(),
                      budget_command(), atmosphere_command(), simulate_command(), bench_command(),
                      check_command(),  report_command(),     live_command(),     devices_command()};
  const auto add = [&](const std::initializer_list<Command>& more) {
    command.commands.insert(command.commands.end(), more);
  };
#ifdef MTFKIT_HAVE_CALIB
  add({measure_command(), fit_command(), characterize_command()});
#endif
  add({scene_command(), heat_command(), render_command(), fly_command()});
#ifdef MTFKIT_HAVE_STUDY
  add({range_command(), sweep_command(), optimize_command()});
#endif
  std::vector<std::string> names;
  for (const Command& inner : command.commands) names.push_back(inner.name);
  add({help_command(help_for, std::move(names))});
  return command;
}

std::vector<std::string> names_below(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
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
  commands = names_below(*app);
  return usage_complaint(command, root.remaining(true), options, commands, error.what());
}

/// What `mtf WORDS --help` prints.
std::string help_of(const CLI::App& root, const std::vector<std::string>& words) {
  const CLI::App* app = &root;
  std::string above;
  for (const std::string& word : words) {
    const auto inner = app->get_subcommands([&](const CLI::App* each) { return each->get_name() == word; });
    above += (above.empty() ? "" : " ") + app->get_name();
    if (inner.empty()) throw mtf::UsageError(usage_complaint(above, {word}, {}, names_below(*app), "no such command"));
    app = inner.front();
  }
  const std::string name = above.empty() ? app->get_name() : above + " " + app->get_name();
  return app->get_formatter()->make_help(app, name, CLI::AppFormatMode::Normal);
}

int parse_and_run(int argc, char** argv) {
  Global global;
  std::function<int(const Global&)> chosen;
  std::vector<std::string> help_for;
  const Command command = root_command(global, help_for);
  // For the shell and the build, not for people: no help lists them.
  if (argc > 1 && argv[1] == std::string_view("--complete")) {
    print(completion(command, {argv + 2, argv + argc}));
    return 0;
  }
  if (argc == 3 && argv[1] == std::string_view("--man")) {
    write_man_pages(command, argv[2]);
    return 0;
  }
  CLI::App root(command.doc, command.name);
  root.get_formatter()->column_width(28);
  root.require_subcommand(1, 1);
  root.footer("Exit code: " + std::string(kExitCodes) + "\n\nExamples:\n" + command.examples);
  for (const OptionSpec& option : command.options) add_option(root, option);
  for (const Command& inner : command.commands) add_command(root, inner, chosen);
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
  if (!chosen) print(help_of(root, help_for));
  return chosen ? chosen(global) : 0;
}

}  // namespace

int run_command(int argc, char** argv) {
  prepare_process();
  const auto failed = [&](const char* what, int status) {
    complain(error_lines(mtf::io::without_stages(what), {argv + 1, argv + argc}));
    return status;
  };
  try {
    const int status = parse_and_run(argc, argv);
    std::cout.flush();
    print("");  // reports a failure of anything printed before
    return std::cout.good() ? status : 1;
  } catch (const mtf::io::BrokenPipe&) {
    end_by_broken_pipe();
  } catch (const mtf::UsageError& error) {
    return failed(error.what(), 2);
  } catch (const std::bad_alloc&) {
    const mtf::UsableMemory memory = mtf::usable_memory();
    const std::string left = std::string(memory.whose) + " " + mtf::io::shown_bytes(memory.bytes);
    return failed(
        ("out of memory; " + left +
         ": raise that limit or free some memory, or use a smaller image, a coarser mesh or fewer frequencies")
            .c_str(),
        1);
  } catch (const std::exception& error) {
    return failed(error.what(), 1);
  } catch (...) {
    return failed("unexpected failure of unknown kind", 1);
  }
}

}  // namespace apps
