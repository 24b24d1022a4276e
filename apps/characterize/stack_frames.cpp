// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/stack_frames.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/npy.h"
#include "mtf/io/plane_checks.h"
#include "mtf/math/word_hash.h"
#include "mtf/parallel.h"

namespace apps {
namespace {

/// Of the frames that are read at a time, of which there are two at least: as many are added at a time.
constexpr std::int64_t kBatchBytes = std::int64_t{32} << 20;

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw mtf::UsageError(one_line(file) + ": " + what);
}

std::uint64_t hash_of(const mtf::Image& frame) {
  std::array<std::uint64_t, 8> lanes, words;  // as many multiplications at a time, of two pixels each
  lanes.fill(mtf::kWordHashStart);
  std::int64_t i = 0;
  for (; i + 2 * std::ssize(lanes) <= frame.size(); i += 2 * std::ssize(lanes)) {
    std::memcpy(words.data(), frame.data() + i, sizeof words);
    for (std::size_t k = 0; k < lanes.size(); ++k) lanes[k] = mtf::mixed(lanes[k], words[k]);
  }
  for (; i < frame.size(); ++i) lanes[0] = mtf::mixed(lanes[0], std::bit_cast<std::uint32_t>(frame.data()[i]));
  std::uint64_t hash = 0;
  for (const std::uint64_t lane : lanes) hash = mtf::mixed(hash, lane);
  return hash;
}

void require_unprocessed(const std::string& path, const mtf::io::FileInfo& info) {
  if (info.format == mtf::io::Format::jpeg)
    refuse(path, "JPEG holds what a camera's processing made of its frames; give raw frames as PNG, TIFF or NPY");
  const std::string& curve = info.encoding.word;
  if (!info.encoding.source.empty() && curve != "linear" && curve != "gamma:1")
    refuse(path,
           "states a curve, " + info.encoding.source + ": radiometry does not go through it; give linear raw frames");
}

/// The one plane of a picture.
mtf::Image read_picture(const std::string& path) {
  mtf::io::ImageFile image = mtf::io::read_image(path);
  require_frame(path, image);
  return std::move(image.planes.front());
}

/// The reader of a file of several frames; of a picture none.
std::optional<mtf::io::NpyReader> cube_of(const StackEntry& entry, const std::string& path) {
  if (const auto& raw = entry.raw)
    return std::optional<mtf::io::NpyReader>(std::in_place, path, raw->type, raw->header, raw->height, raw->columns);
  return path.ends_with(".npy") ? std::optional<mtf::io::NpyReader>(std::in_place, path) : std::nullopt;
}

struct FramePlace {
  const std::string& path;
  FrameShape shape;  ///< of the file
  std::int64_t number;
};

struct StackFrame {
  std::string where;
  mtf::Image image{};
  std::uint64_t hash = 0;
  mtf::io::Rounding rounding{};  ///< of an array of wider numbers
};

/// Neighbours are alike where the bytes of a count are in the order that is stated.
void require_byte_order(const std::string& type, const StackFrame& frame) {
  const auto turned = [](float value) {
    const auto count = static_cast<std::int32_t>(value);
    return (count & 255) << 8 | count >> 8;
  };
  double stated = 0.0, other = 0.0;
  for (const float* at = frame.image.data() + 1; at < frame.image.data() + frame.image.size(); ++at) {
    stated += static_cast<double>(std::abs(at[0] - at[-1]));
    other += std::abs(turned(at[0]) - turned(at[-1]));
  }
  const auto mean = [&](double sum) { return significant(sum / static_cast<double>(frame.image.size() - 1), 3); };
  if (type != "|u1" && other < 0.5 * stated)
    refuse(frame.where, "neighbours differ by " + mean(stated) + " counts, and by " + mean(other) +
                            " with the bytes of each in the other order; write type = " +
                            (type == "<u2" ? "\"uint16be\"" : "\"uint16le\""));
}

/// Into the memory of the frame that was there before, where it fits.
void read_frame(const StackEntry& entry, const FramePlace& place, double step, StackFrame& frame) {
  const auto& [path, shape, number] = place;
  frame.where = path;
  if (!entry.memory.empty()) {
    frame.where += " frame " + std::to_string(number + 1);
    const mtf::ImageView<const float>& from = entry.memory[static_cast<std::size_t>(number)];
    frame.image = mtf::Image(from.width, from.height);
    for (std::int64_t y = 0; y < from.height; ++y) std::copy_n(from.row(y), from.width, frame.image.view().row(y));
  } else if (auto cube = cube_of(entry, path)) {
    frame.where += " frame " + std::to_string(number + 1);
    const auto columns = static_cast<std::int64_t>(entry.raw ? entry.raw->columns : cube->shape().back());
    if (frame.image.size() != columns * shape.height) frame.image = mtf::Image(columns, shape.height);
    const auto size = static_cast<std::size_t>(frame.image.size());
    frame.rounding = {};
    cube->read(static_cast<std::uint64_t>(number) * size, {frame.image.data(), size}, &frame.rounding);
    for (std::int64_t y = 1; y < shape.height && columns > shape.width; ++y)
      std::copy_n(frame.image.data() + y * columns, shape.width, frame.image.data() + y * shape.width);
    frame.image.reshape(shape.width, shape.height);
    if (entry.raw && number == 0) require_byte_order(entry.raw->type, frame);
  } else {
    frame.image = mtf::Image();  // before there is another one
    frame.image = read_picture(path);
  }
  if (step != 1.0)
    for (std::int64_t i = 0; i < frame.image.size(); ++i) frame.image.data()[i] /= static_cast<float>(step);
  frame.hash = hash_of(frame.image);
}

FrameShape shape_of(const StackEntry& entry, const std::string& path) {
  if (const auto cube = cube_of(entry, path)) {
    std::vector<std::uint64_t> shape = cube->shape();
    if (shape.size() == 2) shape.insert(shape.begin(), 1);
    if (shape.size() != 3) refuse(path, "a cube of frames x rows x columns belongs here");
    const auto rows = static_cast<std::int64_t>(shape[1]), columns = static_cast<std::int64_t>(shape[2]);
    mtf::io::check_plane_size(path, columns, rows, 1);
    const std::string kind = cube->type()[1] == 'u' ? "uint" : cube->type()[1] == 'i' ? "int" : "float";
    return {static_cast<std::int64_t>(shape[0]), entry.raw ? static_cast<std::int64_t>(entry.raw->width) : columns,
            rows, kind + std::to_string(8 * (cube->type()[2] - '0'))};
  }
  const mtf::io::FileInfo info = mtf::io::read_info(path);
  require_unprocessed(path, info);
  return {1, info.width, info.height, info.channels.front().type};
}

/// Some frames of a stack at a time, in order, and how many files end with them.
using Batch = std::function<void(const std::vector<StackFrame>& frames, std::size_t files)>;
void each_batch(const StackEntry& entry, const StackShapes& shapes, const StacksFile& file, int threads,
                const Batch& take) {
  std::vector<FramePlace> places;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::int64_t t = 0; t < shapes[i].frames; ++t)
      places.push_back({entry.memory.empty() ? entry.files[i] : entry.name, shapes[i], t});
  const std::int64_t bytes = 4 * places[0].shape.width * places[0].shape.height;
  const std::int64_t most = std::clamp<std::int64_t>(kBatchBytes / bytes, 2, 64);
  std::vector<StackFrame> frames;
  for (std::int64_t begin = 0; begin < std::ssize(places); begin += most) {
    frames.resize(static_cast<std::size_t>(std::min(most, std::ssize(places) - begin)));
    const auto place = [&](std::int64_t k) -> const FramePlace& { return places[static_cast<std::size_t>(begin + k)]; };
    mtf::parallel_for(std::ssize(frames), 1, threads, [&](std::int64_t k, std::int64_t) {
      read_frame(entry, place(k), file.step, frames[static_cast<std::size_t>(k)]);
    });
    std::size_t files = 0;
    for (std::int64_t k = 0; k < std::ssize(frames); ++k) files += place(k).number + 1 == place(k).shape.frames ? 1 : 0;
    take(frames, files);
  }
}

class Reduction {
 public:
  Reduction(const StackEntry& entry, const StacksFile& file, FrameSource& source)
      : entry_(entry), file_(file), source_(source), top_(std::ldexp(1.0, source.bits) - 1.0) {}

  void add(const std::vector<StackFrame>& frames) {
    std::vector<mtf::ImageView<const float>> views;
    for (const StackFrame& frame : frames) {
      views.push_back(frame.image.view());
      roundings_.emplace_back(frame.where, frame.rounding);
      const float *first = frame.image.data(), *end = first + frame.image.size();
      value_ = value_.value_or(*first);
      const bool one_value = std::adjacent_find(first, end, std::not_equal_to()) == end;
      varies_ = varies_ || !one_value || *first != *value_;
      if (one_value) continue;  // saturated frames are all alike
      const auto [before, fresh] = source_.seen.emplace(frame.hash, frame.where);
      if (!fresh) refuse(frame.where, "is the same frame as " + one_line(before->second) + "; give each frame once");
    }
    const std::int64_t before = sums_ ? sums_->frames() : 0;
    try {
      if (!sums_) sums_.emplace(views[0].width, views[0].height, calib::CountRange{0.0, top_});
      sums_->add(views, source_.threads);
    } catch (const mtf::UsageError& error) {
      refuse(frames[sums_ ? static_cast<std::size_t>(sums_->frames() - before) : 0].where, error.what());
    }
  }

  calib::Stack take() {
    if (static_cast<double>(sums_->bits()) > top_)
      refuse(entry_.name, "values outside 0 to " + significant(top_, 12) + ", which is what " +
                              std::to_string(source_.bits) + " bits hold; correct bits in [camera]");
    const std::uint32_t step = sums_->step();
    constexpr std::uint32_t exact = 1U << 24U;
    if (step > 1 && varies_)
      refuse(entry_.name, "all values are multiples of " + std::to_string(step) +
                              (sums_->bits() < exact ? ": fewer bits, stored shifted; write step = "
                                                     : ", as those above 2^24 are in float32: subtract a constant from "
                                                       "them; or, of fewer bits stored shifted, write step = ") +
                              significant(file_.step * step, 6) + " and their bits in [camera]");
    std::vector<std::string> rounded;  // of which one is enough, and each may be too much
    for (const auto& [where, rounding] : roundings_) rounding.note(where, "", rounded);
    if (!rounded.empty()) source_.warnings.push_back(rounded.front());
    if (step == 0)
      source_.warnings.push_back(entry_.name +
                                 ": values that are no whole numbers; rounding is not what it is taken for");
    source_.used |= sums_->bits();
    try {
      return {.name = entry_.name, .light = entry_.light, .time_s = entry_.time_s, .sums = calib::summary_of(*sums_)};
    } catch (const mtf::UsageError& error) {
      refuse(entry_.name, error.what());
    }
  }

 private:
  std::vector<std::pair<std::string, mtf::io::Rounding>> roundings_{};  ///< of each frame
  std::optional<float> value_;                                          ///< the first
  bool varies_ = false;                                                 ///< there is more than one value
  const StackEntry& entry_;
  const StacksFile& file_;
  FrameSource& source_;
  double top_;
  std::optional<calib::StackStatistics> sums_;
};

}  // namespace

void require_frame(const std::string& path, const mtf::io::ImageFile& picture) {
  require_unprocessed(path, picture.info);
  if (picture.planes.size() != 1 && !mtf::io::is_grey(picture.planes))
    refuse(path, std::to_string(picture.planes.size()) + " planes; frames have one, as the sensor gave them");
}

std::string words_of(const FrameShape& shape) {
  return std::to_string(shape.width) + " x " + std::to_string(shape.height) + " of " + shape.type;
}

std::vector<StackShapes> shapes_of(const StacksFile& file, int bits, int threads) {
  std::vector<StackShapes> stacks;
  for (const StackEntry& entry : file.stacks) {
    StackShapes& shapes = stacks.emplace_back(std::max<std::size_t>(1, entry.files.size()));
    if (const auto& memory = entry.memory; !memory.empty())
      shapes[0] = {std::ssize(memory), memory[0].width, memory[0].height, "float32"};
    mtf::parallel_for(std::ssize(entry.files), 16, threads, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
        shapes[i] = shape_of(entry, entry.files[i]);
    });
    std::int64_t frames = 0;
    const FrameShape& first = stacks.front().front();
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      frames += shapes[i].frames;
      if (words_of(shapes[i]) != words_of(first))
        refuse(
            entry.memory.empty() ? entry.files[i] : entry.name,
            "frames of " + words_of(shapes[i]) + " among those of " + words_of(first) + "; give all one size and type");
    }
    if (frames < 2) refuse(entry.name, "a single frame has no temporal noise; give two frames or more");
  }
  const FrameShape& found = stacks.front().front();
  if (const auto [columns, rows] = file.size; columns > 0 && (found.width != columns || found.height != rows))
    refuse(file.file, "its line n says frames of " + std::to_string(columns) + " x " + std::to_string(rows) +
                          ", the frames are " + words_of(found) +
                          "; correct columns and rows there, or give the frames of the whole sensor");
  const std::string& type = stacks.front().front().type;
  const double stored = (std::ldexp(1.0, bits) - 1.0) * file.step;
  for (const auto& [name, most] : {std::pair{"uint8", 255.0}, std::pair{"uint16", 65535.0}, std::pair{"int16", 32767.0},
                                   std::pair{"half", 2048.0}})
    if (type == name && stored > most)
      refuse(file.file, std::to_string(bits) + " bits in steps of " + significant(file.step, 6) +
                            " are more than the files hold, " + type + "; correct bits in [camera]");
  return stacks;
}

calib::Stack read_stack(const StackEntry& entry, const StackShapes& shapes, const StacksFile& file,
                        FrameSource& source) {
  Reduction reduction(entry, file, source);
  each_batch(entry, shapes, file, source.threads, [&](const std::vector<StackFrame>& frames, std::size_t files) {
    reduction.add(frames);
    for (std::size_t k = 0; source.progress && k < files; ++k) source.progress();
  });
  return reduction.take();
}

void read_series(const StackEntry& entry, const StackShapes& shapes, const StacksFile& file, int threads,
                 calib::PixelSeries& series) {
  each_batch(entry, shapes, file, threads, [&](const std::vector<StackFrame>& frames, std::size_t) {
    for (const StackFrame& frame : frames) series.add(frame.image.view());
  });
}

}  // namespace apps
