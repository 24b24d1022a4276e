// SPDX-License-Identifier: Apache-2.0

// `mtf characterize check`: what stacks of frames can determine, as the headers of their files say.

#include <cmath>
#include <set>

#include "apps/characterize/characterize_options.h"
#include "apps/characterize/stack_frames.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/parallel.h"

namespace apps {
namespace {

std::string words_of(const FrameShape& shape) {
  return std::to_string(shape.width) + " x " + std::to_string(shape.height) + " of " + shape.type;
}

/// Of each stack, all of one size and type.
std::vector<FrameShape> shapes_of(const StacksFile& file, int threads) {
  std::vector<FrameShape> stacks;
  for (const StackEntry& entry : file.stacks) {
    std::vector<FrameShape> shapes(entry.files.size());
    mtf::parallel_for(std::ssize(shapes), 16, threads, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
        shapes[i] = shape_of(entry, entry.files[i]);
    });
    FrameShape all = shapes[0];
    all.frames = 0;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const FrameShape& first = stacks.empty() ? all : stacks[0];
      all.frames += shapes[i].frames;
      if (words_of(shapes[i]) != words_of(first))
        throw mtf::UsageError(one_line(entry.files[i]) + ": frames of " + words_of(shapes[i]) + " among those of " +
                              words_of(first) + "; give all one size and type");
    }
    if (all.frames < 2)
      throw mtf::UsageError(one_line(entry.name) + ": a single frame has no temporal noise; give two frames or more");
    stacks.push_back(std::move(all));
  }
  return stacks;
}

}  // namespace

void check_stacks(const StacksFile& file, int bits, Format format, int threads) {
  const std::vector<FrameShape> shapes = shapes_of(file, threads);
  const std::string& type = shapes.front().type;
  const double most = std::ldexp(1.0, bits) - 1.0, stored = most * file.step;
  if ((type == "uint8" && stored > 255.0) || (type == "uint16" && stored > 65535.0))
    throw mtf::UsageError(file.file + ": " + std::to_string(bits) + " bits in steps of " + significant(file.step, 6) +
                          " are more than the files hold, " + type + "; correct bits in [camera]");
  TextTable stacks({"stack", "files", "frames", "exposure", std::string(name_of(file.unit))}),
      numbers({"number", "can be determined"});
  Json json{{"frames", words_of(shapes[0])}, {"bits", bits}, {"stacks", Json::array()}, {"numbers", Json::array()}};
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const StackEntry& one = file.stacks[i];
    stacks.add({one_line(one.name), std::to_string(one.files.size()), std::to_string(shapes[i].frames),
                file.has_times ? significant(1e3 * one.time_s, 6) + " ms" : "-",
                one.light > 0.0 ? significant(one.light, 6) : "dark"});
    json["stacks"].push_back(
        {{"name", one.name}, {"frames", shapes[i].frames}, {"light", one.light}, {"time_s", one.time_s}});
  }
  std::set<double> lights, dark_times;
  for (const StackEntry& entry : file.stacks) {
    lights.insert(entry.light);
    if (!(entry.light > 0.0)) dark_times.insert(entry.time_s);
  }
  const int found = static_cast<int>(lights.size()), needed = 3 + file.nonlinearity;
  const std::string levels = found >= needed
                                 ? ""
                                 : std::to_string(found) + " levels of light, and " + std::to_string(needed) +
                                       " are needed: give stacks at more exposures";
  const std::string dark = dark_times.empty() ? "no dark stack: give one with light = false" : "";
  const std::string times = file.has_times && dark_times.size() > 1 ? levels : "it takes dark stacks of two exposures";
  for (const auto& [name, why] :
       {std::pair{"gain, read noise, offset, rate, crosstalk", levels},
        {"noise of rows and columns", ""},
        {"dark current", times},
        {"fixed patterns in the dark", dark},
        {"fixed patterns of the response", *lights.rbegin() > 0.0 ? dark : "no stack has light"}}) {
    numbers.add({name, why.empty() ? "yes" : "no: " + why});
    json["numbers"].push_back({{"name", name}, {"possible", why.empty()}, {"why", why}});
  }
  print(format == Format::json
            ? json_document(json)
            : stacks.aligned() + "\nframes of " + words_of(shapes[0]) + ", counts from 0 to " + significant(most, 10) +
                  " in steps of " + significant(file.step, 6) + "\n\n" + numbers.aligned());
}

}  // namespace apps
