// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a command takes, as plain data: each command describes itself (commands.h), main.cpp hands that to CLI11 and is
// the only file that sees it. Values are read by functions of ours (arguments.h): CLI11's own messages name neither the
// option nor the remedy.

#include <functional>
#include <memory>

#include "apps/arguments.h"

namespace apps {

using Setter = std::function<void(const std::string&)>;

/// What a value may be, for completion (help/completion.h), after the words of a command line; "" stands for any file.
using Candidates = std::function<std::vector<std::string>(const std::vector<std::string>& line)>;

/// An option ("--freq", "-o,--out") or an argument ("sensor").
struct OptionSpec {
  std::string names, type, doc;
  Setter set;  ///< called with every value; a flag is set by being there, with ""
  bool required = false;
  bool repeats = false;  ///< may be given more than once, or as several words for an argument
  bool flag = false;
  Candidates candidates{};  ///< none: any file
};

/// "-o", "--out" of "-o,--out".
std::vector<std::string> names_of(const OptionSpec& option);

struct Command {
  std::string name, doc, details, examples;
  std::vector<OptionSpec> options{};
  std::vector<Command> commands{};  ///< one of them has to follow, or may where there is `run`; then that one's runs
  std::function<int(const Global&)> run{};
};

/// The options of `command`, kept for as long as it is, and what runs with them.
template <class Options, class Run>
Options& options_of(Command& command, const Run& run) {
  const auto kept = std::make_shared<Options>();
  command.run = [kept, run](const Global& global) { return run(*kept, global); };
  return *kept;
}

/// An option whose word is read by `set`.
OptionSpec& add_word(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     const Setter& set);

/// An option whose value is what `read(option, word)` gives (arguments.h), of a list one more: then it may be given
/// again.
template <class T, class Read>
OptionSpec& add_value(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                      T& target, const Read& read) {
  const std::string name = names.substr(0, names.find(','));
  constexpr bool listed = requires { target.push_back(read(name, name)); };
  OptionSpec& option = add_word(command, names, type, doc, [&target, read, name](const std::string& text) {
    if constexpr (listed)
      target.push_back(read(name, text));
    else
      target = read(name, text);
  });
  option.repeats = listed;
  return option;
}

/// Text that may not be empty, of a list one more: then it may be given again.
OptionSpec& add_text(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     const Setter& set);
OptionSpec& add_text(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     std::string& target);
OptionSpec& add_text(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     std::vector<std::string>& target);

/// A file that has to be named.
OptionSpec& add_file(Command& command, const std::string& name, const std::string& doc, std::string& target);

void add_flag(Command& command, const std::string& names, const std::string& doc, bool& target);

/// Always the same words.
Candidates one_of(std::vector<std::string> words);
template <class T, std::size_t N>
Candidates one_of(const Choices<T, N>& words) {
  std::vector<std::string> names;
  for (const auto& [name, value] : words) names.emplace_back(name);
  return one_of(std::move(names));
}

template <class Value, std::size_t N, class T>
OptionSpec& add_choice(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                       const Choices<Value, N>& words, T& target) {
  OptionSpec& option = add_value(command, names, type, doc, target,
                                 [words](const auto& name, const auto& text) { return choice(name, text, words); });
  option.candidates = one_of(words);
  return option;
}

// Options that several commands have.
inline constexpr auto kFormats = enumerated<Format>("table", "csv", "json");
inline constexpr std::array kTableOrJson{kFormats[0], kFormats[2]};
void add_format(Command& command, const std::string& doc, Format& format);
void add_force(Command& command, bool& force);
void add_device(Command& command, std::string& device);
/// --channel, --layer and --part.
void add_channel_choice(Command& command, mtf::io::ReadOptions& read);

}  // namespace apps
