// SPDX-License-Identifier: Apache-2.0
#include "apps/command_line.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/image_formats.h"
#include "mtf/words.h"

namespace apps {
namespace {

// Names in the image files of a command line, for completion. Words that are no such file, and files that cannot be
// read, have none; only headers are read.

using Words = std::vector<std::string>;

template <class Of>
Words of_channels(const Words& line, Of of) {
  Words found;
  for (const std::string& word : line) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(word, error)) continue;
    try {
      // Of other formats the headers tell no layers, and need the module of codecs.
      if (!mtf::io::row_of(mtf::io::detect_format(word)).in_pieces()) continue;
      for (const mtf::io::ChannelInfo& channel : mtf::io::read_info(word).channels) found.push_back(of(channel));
    } catch (const std::exception&) {  // the command itself will say so
    }
  }
  std::erase(found, "");
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

Words channels_on(const Words& line) {
  return of_channels(line, [](const mtf::io::ChannelInfo& channel) { return channel.name; });
}

Words layers_on(const Words& line) {
  return of_channels(line, [](const mtf::io::ChannelInfo& channel) {
    return channel.layer.empty() ? channel.part_name : channel.layer;
  });
}

Words parts_on(const Words& line) {
  return of_channels(line, [](const mtf::io::ChannelInfo& channel) { return std::to_string(channel.part); });
}

}  // namespace

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

OptionSpec& add_text(Command& command, const std::string& names, const std::string& type, const std::string& doc,
                     std::vector<std::string>& target) {
  OptionSpec& option =
      add_text(command, names, type, doc, [&target](const std::string& text) { target.push_back(text); });
  option.repeats = true;
  return option;
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

void add_device(Command& command, std::string& device) {
  add_text(
      command, "--device", "WORD",
      "what may filter images: cpu (default), auto (a device where there is one that is admitted), or the id or a\n"
      "part of the name of one (mtf devices). The plan takes it where that is faster (--explain)",
      device)
      .candidates = one_of({"cpu", "auto"});
}

void add_channel_choice(Command& command, mtf::io::ReadOptions& read) {
  add_text(command, "--channel", "NAME", "the channel to use, by its full name", [&](const std::string& text) {
    read.channel = text;
  }).candidates = channels_on;
  add_word(command, "--layer", "NAME", "the layer to use; '' = the channels without a layer",
           [&](const std::string& text) { read.layer = text; })
      .candidates = layers_on;
  add_value(command, "--part", "N", "part of a file of several: OpenEXR, units of FITS, frames of FLIR; from 0",
            read.part, whole(0, 1'000'000))
      .candidates = parts_on;
  add_text(command, "--page", "N", "page of a TIFF, from 1", [&](const std::string& text) {
    const auto page = mtf::io::cell_number<int>(text);
    if (!page || *page < 1) throw mtf::UsageError("--page " + mtf::printable(text, 20) + ": pages count from 1");
    read.part = *page - 1;
  });
}

}  // namespace apps
