// SPDX-License-Identifier: Apache-2.0
#include "apps/help/completion.h"

#include <algorithm>

namespace apps {
namespace {

using Words = std::vector<std::string>;

const OptionSpec* find_option(const Command& root, const Command& command, const std::string& name) {
  for (const Command* each : {&command, &root})
    for (const OptionSpec& option : each->options)
      if (std::ranges::count(names_of(option), name) > 0) return &option;
  return nullptr;
}

/// The argument at that place, nullptr behind the last.
const OptionSpec* find_argument(const Command& command, std::size_t index) {
  for (const OptionSpec& option : command.options) {
    if (names_of(option).back().front() == '-') continue;
    if (index == 0 || option.repeats) return &option;
    --index;
  }
  return nullptr;
}

Words values_of(const OptionSpec* option, const Words& line) {
  return option != nullptr && option->candidates ? option->candidates(line) : Words{};
}

Words options_of(const Command& root, const Command& command) {
  Words found{"--help"};
  for (const Command* each : {&command, &root})
    for (const OptionSpec& option : each->options)
      for (const std::string& name : names_of(option))
        if (name.front() == '-' && std::ranges::count(found, name) == 0) found.push_back(name);
  return found;
}

/// What may stand in place of `current` after the words of `line`.
Words candidates(const Command& root, const Words& line, const std::string& current) {
  const Command* command = &root;
  const OptionSpec* waiting = nullptr;  // for its value
  std::size_t arguments = 0;
  for (const std::string& word : line) {
    const auto inner = std::ranges::find(command->commands, word, &Command::name);
    if (waiting != nullptr) {
      waiting = nullptr;
    } else if (word.starts_with('-')) {
      const OptionSpec* option = find_option(root, *command, word);
      if (option != nullptr && !option->flag) waiting = option;
    } else if (inner != command->commands.end()) {
      command = &*inner;
    } else {
      ++arguments;
    }
  }
  if (waiting != nullptr) return values_of(waiting, line);
  if (current.starts_with("--") && current.find('=') != std::string::npos)
    return values_of(find_option(root, *command, current.substr(0, current.find('='))), line);
  if (current.starts_with('-')) return options_of(root, *command);
  const OptionSpec* argument = find_argument(*command, arguments);
  if (argument == nullptr && command->commands.empty()) return options_of(root, *command);
  Words names = argument != nullptr ? values_of(argument, line) : Words();
  if (arguments == 0)
    for (const Command& inner : command->commands) names.push_back(inner.name);
  return names;
}

}  // namespace

std::string completion(const Command& root, const Words& words) noexcept {
  try {
    if (words.empty()) return "";
    const std::string& current = words.back();
    Words found = candidates(root, {words.begin(), words.end() - 1}, current);
    const std::string begun = current.starts_with("--") ? current.substr(current.find('=') + 1) : current;
    // Names in files may hold anything: a line break would make two of one.
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
    std::erase_if(found, [&](const std::string& word) {
      return !word.empty() && (!word.starts_with(begun) || std::ranges::any_of(word, is_control));
    });
    if (found.empty()) return "\n";
    std::ranges::stable_partition(found, &std::string::empty);
    std::string lines;
    for (const std::string& word : found) lines += word + "\n";
    return lines;
  } catch (...) {
    return "";
  }
}

}  // namespace apps
