// SPDX-License-Identifier: Apache-2.0
#include "apps/command_line.h"

#include <sstream>

#include "apps/help/image_words.h"

namespace apps {

std::vector<std::string> names_of(const OptionSpec& option) {
  std::vector<std::string> names;
  std::istringstream text(option.names);
  for (std::string name; std::getline(text, name, ',');) names.push_back(name);
  return names;
}

Candidates one_of(std::vector<std::string> words) {
  return [words = std::move(words)](const std::vector<std::string>&) { return words; };
}

OptionSpec& add_word(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     const Setter& set) {
  return command.options.emplace_back(OptionSpec{.names = names, .type = type, .doc = doc, .set = set});
}

OptionSpec& add_text(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     const Setter& set) {
  const std::string name = names.substr(names.rfind(',') + 1);
  return add_word(command, names, type, doc, [set, name](const std::string& text) {
    if (text.empty()) throw mtf::UsageError(name + ": empty; give it a value");
    set(text);
  });
}

OptionSpec& add_text(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     std::string& target) {
  return add_text(command, names, type, doc, [&target](const std::string& text) { target = text; });
}

OptionSpec& add_file(Command& command, const std::string& name, const std::string& doc, std::string& target) {
  OptionSpec& option = add_text(command, name, "FILE", doc, target);
  option.required = true;
  return option;
}

void add_flag(Command& command, const std::string& names, const std::string& doc, bool& target) {
  add_word(command, names, "", doc, [&target](const std::string&) { target = true; }).flag = true;
}

void add_format(Command& command, const std::string& doc, Format& format) {
  add_choice(command, "--format", "FORMAT", doc, kFormats, format);
}

void add_force(Command& command, bool& force) {
  add_flag(command, "--force", "write into a folder that is not empty", force);
}

void add_channel(Command& command, std::optional<std::string>& channel) {
  add_text(command, "--channel", "NAME", "the channel to use, by its full name", [&](const std::string& text) {
    channel = text;
  }).candidates = channels_on;
}

void add_channel_choice(Command& command, std::optional<std::string>& channel, std::optional<std::string>& layer,
                        std::optional<int>& part) {
  add_channel(command, channel);
  add_word(command, "--layer", "NAME", "the layer to use; '' = the channels without a layer",
           [&](const std::string& text) { layer = text; })
      .candidates = layers_on;
  add_word(command, "--part", "N", "part of a multi-part OpenEXR file, from 0", [&](const std::string& text) {
    part = whole_number("--part", text, 0, 1'000'000);
  }).candidates = parts_on;
}

}  // namespace apps
