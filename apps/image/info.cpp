// SPDX-License-Identifier: Apache-2.0

// `mtf info FILE`: format and metadata of a file, statistics of its pixels, and the command to run next.

#include <algorithm>
#include <cctype>

#include "apps/config.h"
#include "apps/image/image_facts.h"
#include "apps/sweep/study_file.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps {
namespace {

std::string format_name(mtf::io::Format format) {
  constexpr std::array names{"OpenEXR", "PNG", "TIFF", "JPEG"};
  return names.at(static_cast<std::size_t>(format));
}

std::string window_text(const std::array<int, 4>& window) {
  return "(" + std::to_string(window[0]) + ", " + std::to_string(window[1]) + ") to (" + std::to_string(window[2]) +
         ", " + std::to_string(window[3]) + ")";
}

std::string shown(const std::optional<double>& value) { return value ? significant(*value, 6) : "-"; }
std::string exact(const std::optional<double>& value) { return value ? mtf::format_double(*value) : ""; }

std::vector<std::string> channel_row(const ChannelFacts& facts, bool exactly) {
  const auto number = exactly ? exact : shown;
  const mtf::io::ChannelInfo& info = facts.channel;
  const bool measured = facts.statistics.has_value();
  return {exactly ? info.name : one_line(info.name),
          info.type,
          exactly ? info.layer : one_line(info.layer),
          std::to_string(info.part),
          number(facts.min),
          number(facts.max),
          number(facts.mean),
          number(facts.std),
          measured  ? std::to_string(facts.statistics->not_finite)
          : exactly ? ""
                    : "-"};
}

TextTable channel_table(const ImageFacts& facts, bool exactly) {
  TextTable table(
      {"channel", "type", "layer", "part", "min", "max", "mean", "std", exactly ? "not_finite" : "NaN/Inf"});
  for (const ChannelFacts& channel : facts.channels) table.add(channel_row(channel, exactly));
  return table;
}

std::string as_text(const ImageFacts& facts) {
  constexpr std::size_t most_attributes = 40, longest = 100;
  const mtf::io::FileInfo& info = facts.info;
  const auto line = [](const std::string& name, const std::string& value) {
    return name + std::string(name.size() < 13 ? 13 - name.size() : 1, ' ') + value + "\n";
  };
  std::string text = line("file", one_line(facts.path));
  text += line("format", format_name(info.format) + (info.storage.empty() ? "" : ", " + one_line(info.storage)));
  text += line("size", std::to_string(info.width) + " x " + std::to_string(info.height) + " px");
  if (info.data_window != info.display_window)
    text += line("window", "data " + window_text(info.data_window) + ", display " + window_text(info.display_window));
  text += line("values", facts.values);
  for (const std::string& remark : facts.remarks) text += line("note", one_line(remark));
  using enum Align;
  text += "\n" + channel_table(facts, false).aligned({left, left, left, right, right, right, right, right, right});
  std::size_t count = 0;
  if (!info.attributes.empty()) text += "\nattributes\n";
  for (const auto& [name, value] : info.attributes) {
    if (++count > most_attributes) {
      text += "  and " + std::to_string(info.attributes.size() - most_attributes) + " more: --format json shows all\n";
      break;
    }
    text += "  " + line(one_line(name), mtf::printable(value, longest));
  }
  return text + "\n" + (facts.next.empty() ? "" : "next: " + facts.next + "\n");
}

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

std::string as_json(const ImageFacts& facts) {
  const mtf::io::FileInfo& info = facts.info;
  Json json{{"file", facts.path},
            {"format", format_name(info.format)},
            {"storage", info.storage},
            {"width", info.width},
            {"height", info.height},
            {"data_window", info.data_window},
            {"display_window", info.display_window},
            {"values", facts.values}};
  const auto& [word, source] = info.encoding;
  json["encoding"] = word.empty() ? Json() : Json(word);
  json["encoding_source"] = source.empty() ? Json() : Json(source);
  json["notes"] = facts.remarks;
  Json& channels = json["channels"] = Json::array();
  for (const ChannelFacts& facts_of : facts.channels) {
    const mtf::io::ChannelInfo& c = facts_of.channel;
    Json channel{{"name", c.name}, {"type", c.type},           {"layer", c.layer},
                 {"part", c.part}, {"part_name", c.part_name}, {"sampling", {c.x_sampling, c.y_sampling}}};
    channel["min"] = optional_json(facts_of.min);
    channel["max"] = optional_json(facts_of.max);
    channel["mean"] = optional_json(facts_of.mean);
    channel["std"] = optional_json(facts_of.std);
    channel["not_finite"] = facts_of.statistics ? Json(facts_of.statistics->not_finite) : Json();
    channels.push_back(std::move(channel));
  }
  json["attributes"] = info.attributes;
  json["next"] = facts.next;
  return json_document(json);
}

bool is_config_file(const std::string& path) {
  if (path.size() < 5) return false;
  std::string ending = path.substr(path.size() - 5);
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".toml";
}

int info_of_config(const InfoOptions& options) {
  const int status = check_config(options.file, options.format);
  if (options.format != Format::table) return status;
  const std::string file = shell_word(options.file);
  if (status == 0 && is_study_file(options.file)) {
    print("next: mtf sweep " + file + " -o results\n");
    return status;
  }
  if (status == 0)
    print("next: mtf curve " + file + "\n      mtf config explain " + file + "\n      mtf simulate " + file +
          " scene.exr -o out.exr\n");
  else
    print("next: correct what is named, then: mtf config check " + file + "\n");
  return status;
}

}  // namespace

int run_info(const InfoOptions& options, const Global&) {
  if (is_config_file(options.file)) return info_of_config(options);
  const ImageFacts facts = image_facts(options);
  if (options.format == Format::json)
    print(as_json(facts));
  else
    print(options.format == Format::csv ? channel_table(facts, true).csv() : as_text(facts));
  return 0;
}

}  // namespace apps
