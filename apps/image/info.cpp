// SPDX-License-Identifier: Apache-2.0

// `mtf info FILE`: format and metadata of a file, statistics of its pixels, and the command to run next.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/config_command.h"
#include "apps/options.h"
#include "apps/simulate/stated_camera.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "calib/find/find_edges.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/io/channel_choice.h"
#include "mtf/io/exr/spectral_exr.h"
#include "mtf/io/float_rounding.h"
#include "mtf/io/image_formats.h"
#include "mtf/io/scene.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps {
namespace {

// What there is to know of an image file before it is simulated.
#ifdef MTFKIT_HAVE_CALIB

#endif

struct ChannelFacts {
  mtf::io::ChannelInfo channel;
  std::optional<mtf::Statistics> statistics;  ///< nothing for channels that are not read
  std::optional<double> min, max, mean, std;  ///< of the finite pixels, nothing when there is none
};

/// Temperatures of the least, the mean and the largest count of a thermal camera.
struct CountTemperatures {
  StatedCamera stated;
  std::vector<std::pair<double, radiometry::CountUncertainty>> rows{};

  /// Calls visit(number, row, value, sd) for each number with a standard deviation.
  void each_uncertain(const auto& visit) const {
    std::size_t i = 0;
    for_each_field(stated.told, [&](const radiometry::FieldInfo& info, double value) {
      if (const double sd = stated.sd[i]; sd > 0.0) visit(i, info, value, sd);
      ++i;
    });
  }
  bool uncertain() const {
    return std::ranges::any_of(stated.sd, [](double sd) { return sd > 0.0; });
  }
};

struct ImageFacts {
  std::string path;
  mtf::io::FileInfo info;
  std::vector<ChannelFacts> channels;  ///< those that were asked for, in the file's order
  std::string values;                  ///< what a value means: stated in the file, or what is assumed
  std::vector<std::string> remarks;
  bool refused = false;                             ///< values of a channel are
  std::optional<CountTemperatures> temperatures{};  ///< of a thermal camera's counts
  std::string next;                                 ///< command to run next, "" when nothing in the file can be read
};

using mtf::io::ChannelInfo;
using mtf::io::FileInfo;
using mtf::io::ReadOptions;

/// A channel by channel pass decodes the whole file each time: samples decoded, about a minute.
constexpr double kMostSamples = 4e9;

bool is_float(const ChannelInfo& channel) {
  const std::string& type = channel.type;
  return type.ends_with("half") || type.ends_with("float") || type.ends_with("double");
}

bool is_radiance(const ChannelInfo& channel) {
  const auto spectral = mtf::io::parse_spectral_channel(channel.name);
  return spectral && spectral->kind == mtf::io::SpectralChannel::Kind::stokes;
}

std::string meaning(const FileInfo& info) {
  const auto stated = [&](const char* name) {
    const auto found = info.attributes.find(name);
    return found == info.attributes.end() ? std::string() : one_line(found->second);
  };
  const std::string quantity = stated("mtf:quantity"), units = stated("mtf:units");
  if (!quantity.empty() || !units.empty())
    return (quantity.empty() ? "quantity not stated" : quantity) + (units.empty() ? "" : " in " + units) +
           " (stated in the file)";
  if (const std::string foreign = stated("emissiveUnits"); !foreign.empty())
    return "emissiveUnits " + foreign + " (stated in the file); [scene] of the sensor file says what it is taken for";
  if (std::any_of(info.channels.begin(), info.channels.end(), is_radiance))
    return "spectral radiance by the names of its channels; unit not stated: W.m^-2.sr^-1.nm^-1 assumed, unless "
           "[scene] of the sensor file gives a gain";
  if (std::none_of(info.channels.begin(), info.channels.end(), is_float))
    return "whole numbers, unit not stated: [scene] of the sensor file has to give gain, offset and quantity";
  if (info.format != mtf::io::Format::exr) return "not stated: [scene] of the sensor file has to give quantity";
  return "not stated: radiance assumed, W.m^-2.sr^-1, unless [scene] of the sensor file gives another quantity";
}

/// What the file says of the curve of its values, and who follows it.
std::string encoding_remark(const FileInfo& info) {
  const auto& [word, source] = info.encoding;
  if (source.empty()) return "";
  if (word == "linear") return source + ": the values are linear";
  if (word.empty())
    return source +
           " is not applied: measure and fit take the values as linear unless --encoding says their curve, "
           "simulate asks for [scene] encoding";
  return source + ": the values follow the curve " + word +
         "; measure and fit undo it (--encoding linear: not), simulate asks for [scene] encoding";
}

void measure(ChannelFacts& facts, const mtf::Image& plane) {
  const mtf::Statistics s = mtf::statistics(plane.view());
  facts.statistics = s;
  if (s.not_finite >= plane.size()) return;
  facts.min = s.min;
  facts.max = s.max;
  facts.mean = s.mean;
  facts.std = s.std;
}

bool can_be_read(const ChannelInfo& channel) {
  return channel.x_sampling == 1 && channel.y_sampling == 1 && !channel.type.starts_with("deep");
}

/// What was found while the pixels were read.
void add_notes(ImageFacts& facts, const mtf::io::ImageFile& image) {
  for (const std::string& note : image.info.notes)
    if (std::ranges::find(facts.remarks, note) == facts.remarks.end()) facts.remarks.push_back(note);
  if (!stated_camera(image.info.attributes)) return;
  for (std::size_t i = 0; i < image.names.size(); ++i)
    if (std::string clipped = clipped_counts(image.info, image.names[i], image.planes[i].view()); !clipped.empty())
      facts.remarks.push_back(std::move(clipped));
}

/// The image; nothing, with the reason among the remarks, where float32 would change its values too much.
std::optional<mtf::io::ImageFile> read_or_say(ImageFacts& facts, const ReadOptions& read) {
  try {
    mtf::io::ImageFile image = mtf::io::read_image(facts.path, read);
    add_notes(facts, image);
    return image;
  } catch (const mtf::io::RoundingError& error) {
    facts.refused = true;
    facts.remarks.emplace_back(error.what());
    return std::nullopt;
  }
}

void measure_raster(ImageFacts& facts, const InfoOptions& options) {
  const auto found = read_or_say(facts, options.read);
  if (!found) return;
  const mtf::io::ImageFile& image = *found;
  for (std::size_t i = 0; i < image.names.size(); ++i)
    for (ChannelFacts& channel : facts.channels)
      if (channel.channel.name == image.names[i]) measure(channel, image.planes[i]);
}

void measure_in_turn(ImageFacts& facts) {
  const FileInfo& info = facts.info;
  const double pixels = static_cast<double>(info.width) * static_cast<double>(info.height);
  const auto count = static_cast<double>(info.channels.size());
  if (pixels * count * static_cast<double>(facts.channels.size()) > kMostSamples) {
    facts.remarks.push_back("no statistics: the file is large; choose one channel with --channel NAME");
    return;
  }
  std::int64_t missing = 0;
  std::size_t unreadable = 0;
  for (ChannelFacts& channel : facts.channels) {
    if (!can_be_read(channel.channel)) {
      ++unreadable;
      continue;
    }
    const ReadOptions read{.channel = channel.channel.name, .layer = {}, .part = channel.channel.part};
    const auto image = read_or_say(facts, read);
    if (!image) continue;
    missing = std::max(missing, image->missing_pixels);
    measure(channel, image->planes.front());
  }
  if (unreadable > 0)
    facts.remarks.push_back(std::to_string(unreadable) +
                            " channels are deep (several samples a pixel) or subsampled and cannot be read; "
                            "flatten the image, or choose a channel at full resolution");
  if (missing > 0)
    facts.remarks.push_back(std::to_string(missing) + " pixels lie outside the data window and count as 0");
}

/// The shortest choice that reads an image from the file; nothing when there is none. Channels one by one come last.
std::optional<ReadOptions> choice_of(const std::string& path, const FileInfo& info, const InfoOptions& options) {
  const auto works = [&](const ReadOptions& read) {
    try {
      static_cast<void>(mtf::io::choose_channels(path, info.channels, read));
      return true;
    } catch (const mtf::UsageError&) {
      return false;
    }
  };
  std::vector<ReadOptions> tries;
  const ReadOptions& asked = options.read;
  tries.push_back(asked);
  if (!asked.channel) {
    std::set<std::pair<std::optional<std::string>, std::optional<int>>> known;  // each once: a cube has one layer
    const auto add = [&](const std::optional<std::string>& layer, const std::optional<int>& part) {
      if (known.emplace(layer, part).second) tries.push_back({.channel = {}, .layer = layer, .part = part});
    };
    for (const ChannelInfo& c : info.channels) add(c.layer, asked.part);
    for (const ChannelInfo& c : info.channels) add({}, c.part);
    for (const ChannelInfo& c : info.channels) add(c.layer, c.part);
    for (const ChannelInfo& c : info.channels) tries.push_back({.channel = c.name, .layer = {}, .part = c.part});
  }
  constexpr std::size_t most = 400;
  for (std::size_t i = 0; i < std::min(tries.size(), most); ++i)
    if (works(tries[i])) return tries[i];
  return std::nullopt;
}

/// As options of the command.
std::string words_of(const ReadOptions& read) {
  return (read.part ? " --part " + std::to_string(*read.part) : "") +
         (read.layer ? " --layer " + shell_word(*read.layer) : "") +
         (read.channel ? " --channel " + shell_word(*read.channel) : "");
}

/// An image of one channel that an edge crosses was made to be measured.
bool shows_one_edge([[maybe_unused]] const std::string& path, [[maybe_unused]] const FileInfo& info,
                    [[maybe_unused]] const ReadOptions& read) {
#ifdef MTFKIT_HAVE_CALIB
  constexpr double kMostPixels = 4e6;
  if (static_cast<double>(info.width) * static_cast<double>(info.height) > kMostPixels) return false;
  const mtf::io::ImageFile image = mtf::io::read_image(path, read);
  if (image.planes.size() != 1) return false;
  const mtf::Image& plane = image.planes.front();
  const calib::FoundEdges found = calib::find_edges(plane.view());
  return found.edges.size() == 1 && found.edges.front().roi == calib::Roi{0, 0, plane.width(), plane.height()};
#else
  return false;
#endif
}

/// By the file's own numbers, and what those are worth.
std::string temperatures_remark(const CountTemperatures& all) {
  const StatedCamera& stated = all.stated;
  const radiometry::Thermometry assumed = stated.assumed();
  std::string text = "temperatures of the counts";
  for (const auto& [word, row] : {std::pair{" from ", &all.rows.front()}, {" to ", &all.rows.back()}}) {
    const auto s = sensitivity_of(row->first, stated.camera, assumed);
    if (!std::isfinite(s.emissivity)) return text + ": some of them have none by " + thermometry_words(assumed);
    text += word + significant(row->second.temperature_k, 6) + " K (" + significant(0.01 * s.emissivity, 2) +
            " K for 0.01 of emissivity, " + significant(s.reflected, 2) + " K for 1 K of reflected, " +
            significant(0.01 * s.transmission, 2) + " K for 0.01 of the air's transmission, " + significant(s.air, 2) +
            " K for 1 K of air)";
  }
  return text + ", by " + thermometry_words(assumed) + stated.left_out + stated.no_emissivity;
}

/// Where counts of a thermal camera were read.
void add_temperatures(ImageFacts& facts, const std::vector<std::string>& assumed) {
  const auto counts = std::ranges::find_if(
      facts.channels, [](const ChannelFacts& c) { return c.channel.name == "counts" && c.min.has_value(); });
  auto stated = stated_camera(facts.info.attributes);
  if (counts == facts.channels.end() || !stated) {
    if (assumed.empty()) return;
    throw mtf::UsageError(facts.path +
                          ": --assume has no effect: no channel counts with the constants of a thermal camera was "
                          "read; leave it out, or choose the counts of a radiometric JPEG by --channel counts");
  }
  assume(*stated, assumed);
  try {
    require_camera(facts.path, stated->camera);
  } catch (const mtf::UsageError& error) {
    facts.remarks.push_back(std::string("no temperatures of the counts: ") + error.what());
    return;
  }
  const radiometry::CountErrors errors(stated->camera, stated->told, stated->air, stated->sd);
  CountTemperatures& all = facts.temperatures.emplace(CountTemperatures{.stated = std::move(*stated)});
  for (const double count : {*counts->min, *counts->mean, *counts->max}) all.rows.emplace_back(count, errors.of(count));
  facts.remarks.push_back(temperatures_remark(all));
  if (!all.uncertain())
    facts.remarks.emplace_back(
        "no interval of these temperatures: no standard deviation of emissivity, surroundings, air or window is "
        "stated; state what is known as --assume \"emissivity=+- 0.02\" --assume \"surroundings=+- 2 K\"");
  else if (!std::ranges::all_of(all.rows, [](const auto& row) { return row.second.first_order; }))
    facts.remarks.emplace_back(
        "the temperatures are no straight lines of what is assumed over its standard deviations: where there is no sd "
        "the first order does not hold, and the interval does; an end of it that is none has no temperature");
}

/// Reads the header and, one plane at a time, the pixels. Statistics are left out, with a remark, where they would take
/// minutes. Throws as read_info and read_image.
ImageFacts image_facts(const InfoOptions& options) {
  ImageFacts facts;
  facts.path = options.file;
  facts.info = mtf::io::read_info_of(options.file, options.read.part);
  facts.values = meaning(facts.info);
  facts.remarks = facts.info.notes;
  for (std::string remark : {encoding_remark(facts.info), mtf::io::aspect_note(facts.info)})
    if (!remark.empty()) facts.remarks.push_back(std::move(remark));
  const auto& [wanted, layer, part] = options.read;
  for (const ChannelInfo& channel : facts.info.channels) {
    const bool in_layer = !layer || channel.layer == *layer || (channel.layer.empty() && channel.part_name == *layer);
    const bool named = !wanted || channel.name == *wanted || (layer && mtf::io::base_of(channel.name) == *wanted);
    if (in_layer && named && (!part || channel.part == *part)) facts.channels.push_back({channel, {}, {}, {}, {}, {}});
  }
  // The refusal of the reader lists what there is.
  if (facts.channels.empty() && (wanted || layer || part))
    static_cast<void>(mtf::io::read_image(options.file, options.read));
  if (mtf::io::row_of(facts.info.format).in_pieces())
    measure_in_turn(facts);
  else
    measure_raster(facts, options);
  add_temperatures(facts, options.assume);
  if (facts.refused) return facts;  // there is nothing to run with it
  if (const std::optional<ReadOptions> read = choice_of(options.file, facts.info, options)) {
    const std::string file = shell_word(options.file) + words_of(*read);
    const bool taken = std::filesystem::path(options.file).filename() == "out.exr";
    facts.next = shows_one_edge(options.file, facts.info, *read)
                     ? "mtf measure " + file
                     : "mtf simulate sensor.toml " + file + (taken ? " -o out2.exr" : " -o out.exr");
  }
  return facts;
}

std::string format_name(mtf::io::Format format) { return std::string(mtf::io::row_of(format).name); }

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

std::string temperature_table(const CountTemperatures& all) {
  std::vector<std::string> header{"count", "T (K)", "sd (K)", "2.5 % (K)", "97.5 % (K)"};
  all.each_uncertain([&](std::size_t, const auto& info, double value, double sd) {
    header.push_back(
        mtf::with_unit(std::string(info.name) + " " + significant(value, 6) + " +- " + significant(sd, 3), info.unit));
  });
  TextTable table(header);
  const auto cell = [](bool known, double value, int digits, const char* unit = "") {
    return known && std::isfinite(value) ? significant(value, digits) + unit : std::string("-");
  };
  for (const auto& [count, found] : all.rows) {
    std::vector<std::string> row{significant(count, 6), cell(true, found.temperature_k, 6),
                                 cell(found.first_order, found.sd_k, 2), cell(true, found.low_k, 6),
                                 cell(true, found.high_k, 6)};
    all.each_uncertain([&](std::size_t i, const auto&, double, double) {
      row.push_back(cell(found.first_order, 100.0 * found.share(i), 2, " %"));
    });
    table.add(std::move(row));
  }
  return table.aligned(std::vector<Align>(header.size(), Align::right));
}

/// Null in place of sd, shares and interval where they are not known.
Json temperatures_json(const CountTemperatures& all) {
  Json list = Json::array();
  const auto number = [](bool known, double value) { return known && std::isfinite(value) ? Json(value) : Json(); };
  for (const auto& [count, found] : all.rows) {
    const bool uncertain = all.uncertain(), linear = uncertain && found.first_order;
    Json sources = Json::array();
    all.each_uncertain([&](std::size_t i, const auto& info, double value, double sd) {
      sources.push_back({{"name", info.name},
                         {"value", value},
                         {"sd", sd},
                         {"unit", info.unit},
                         {"change_K", number(linear, found.change_k[i])},
                         {"share", number(linear, found.share(i))}});
    });
    list.push_back({{"count", count},
                    {"temperature_K", number(true, found.temperature_k)},
                    {"sd_K", number(linear, found.sd_k)},
                    {"interval95_K", uncertain ? Json{number(true, found.low_k), number(true, found.high_k)} : Json()},
                    {"first_order_holds", uncertain ? Json(found.first_order) : Json()},
                    {"sources", std::move(sources)}});
  }
  return list;
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
  if (facts.temperatures && facts.temperatures->uncertain())
    text += "\ntemperatures of the least, the mean and the largest count, and the shares of what is uncertain\n" +
            temperature_table(*facts.temperatures);
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
  json["encoding"] = text_or_null(word);
  json["encoding_source"] = text_or_null(source);
  json["notes"] = facts.remarks;
  Json& channels = json["channels"] = Json::array();
  for (const ChannelFacts& facts_of : facts.channels) {
    const mtf::io::ChannelInfo& c = facts_of.channel;
    Json channel{{"name", c.name}, {"type", c.type},           {"layer", c.layer},
                 {"part", c.part}, {"part_name", c.part_name}, {"sampling", {c.x_sampling, c.y_sampling}}};
    channel["min"] = facts_of.min;
    channel["max"] = facts_of.max;
    channel["mean"] = facts_of.mean;
    channel["std"] = facts_of.std;
    channel["not_finite"] = facts_of.statistics ? Json(facts_of.statistics->not_finite) : Json();
    channels.push_back(std::move(channel));
  }
  if (facts.temperatures) json["temperatures"] = temperatures_json(*facts.temperatures);
  json["attributes"] = info.attributes;
  json["next"] = facts.next;
  return json_document(json);
}

/// The table of formats: for people the lists of items as lines below it.
std::string formats_text(Format format) {
  TextTable table({"format", "known by", "reads", "in pieces", "written as", "writes"});
  TextTable all({"format", "known_by", "reads", "in_pieces", "written_as", "writes", "applied", "noted", "refused"});
  std::string items;
  Json list = Json::array();
  for (const mtf::io::ImageFormat& row : mtf::io::image_formats()) {
    const auto text = [](std::string_view words) { return std::string(words); };
    std::string endings = text(row.endings[0]);
    if (!row.endings[1].empty()) endings += " " + text(row.endings[1]);
    std::vector<std::string> cells{text(row.name),    text(row.known_by),
                                   text(row.numbers), row.in_pieces() ? "yes" : "no",
                                   endings,           text(row.written)};
    table.add(cells);
    list.push_back({{"format", row.name},
                    {"known_by", row.known_by},
                    {"reads", row.numbers},
                    {"in_pieces", row.in_pieces()},
                    {"written_as", endings},
                    {"writes", row.written},
                    {"applied", row.applied},
                    {"noted", row.noted},
                    {"refused", row.refused}});
    items += "\n" + text(row.name) + "\n";
    for (const auto& [what, words] :
         {std::pair{"applied", row.applied}, {"noted", row.noted}, {"refused", row.refused}}) {
      if (!words.empty()) items += "  " + std::string(what) + ": " + text(words) + "\n";
      cells.emplace_back(words);
    }
    all.add(std::move(cells));
  }
  if (format == Format::json) return json_document({{"formats", std::move(list)}});
  return format == Format::csv ? all.csv() : table.aligned() + items;
}

bool is_config_file(const std::string& path) { return mtf::lower_case(path).ends_with(".toml"); }

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
  if (options.formats) {
    print(formats_text(options.format));
    return 0;
  }
  if (options.file.empty()) throw mtf::UsageError("name an image or a sensor file, or ask for --formats");
  if (is_config_file(options.file)) return info_of_config(options);
  const ImageFacts facts = image_facts(options);
  if (options.format == Format::json)
    print(as_json(facts));
  else
    print(options.format == Format::csv ? channel_table(facts, true).csv() : as_text(facts));
  return 0;
}

}  // namespace apps
