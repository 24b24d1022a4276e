// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/stack_frames.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/io/npy.h"
#include "mtf/math/word_hash.h"

namespace apps {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw mtf::UsageError(one_line(file) + ": " + what);
}

std::uint64_t hash_of(mtf::ImageView<const float> frame) {
  std::array<std::uint64_t, 8> lanes;  // as many multiplications at a time
  lanes.fill(mtf::kWordHashStart);
  for (std::int64_t y = 0; y < frame.height; ++y)
    for (std::int64_t x = 0; x < frame.width; ++x) {
      std::uint64_t& lane = lanes[static_cast<std::size_t>(x % 8)];
      lane = mtf::mixed(lane, std::bit_cast<std::uint32_t>(frame.at(x, y)));
    }
  std::uint64_t hash = 0;
  for (const std::uint64_t lane : lanes) hash = mtf::mixed(hash, lane);
  return hash;
}

bool same(const mtf::Image& a, const mtf::Image& b) { return std::equal(a.data(), a.data() + a.size(), b.data()); }

/// The one plane of a picture.
mtf::Image read_picture(const std::string& path) {
  mtf::io::ImageFile image = mtf::io::read_image(path);
  if (image.info.format == mtf::io::Format::jpeg)
    refuse(path, "JPEG holds what a camera's processing made of its frames; give raw frames as PNG, TIFF or NPY");
  const std::string& curve = image.info.encoding.word;
  if (!image.info.encoding.source.empty() && curve != "linear" && curve != "gamma:1")
    refuse(path, "states a curve, " + image.info.encoding.source +
                     ": radiometry does not go through it; give linear raw frames");
  const bool grey =
      image.planes.size() == 3 && same(image.planes[0], image.planes[1]) && same(image.planes[0], image.planes[2]);
  if (image.planes.size() != 1 && !grey)
    refuse(path, std::to_string(image.planes.size()) + " planes; frames have one, as the sensor gave them");
  return std::move(image.planes.front());
}

class Reduction {
 public:
  Reduction(const StackEntry& entry, const StacksFile& file, FrameSource& source)
      : entry_(entry), file_(file), source_(source), top_(std::ldexp(1.0, source.bits) - 1.0) {}

  void add(mtf::Image frame, const std::string& where) {
    if (file_.step != 1.0)
      for (std::int64_t i = 0; i < frame.size(); ++i) frame.data()[i] /= static_cast<float>(file_.step);
    const mtf::ImageView<const float> view = frame.view();
    const auto [least, most] = std::minmax_element(frame.data(), frame.data() + frame.size());
    if (*least < *most) {  // saturated frames are all alike
      const auto [before, fresh] = source_.seen.emplace(hash_of(view), where);
      if (!fresh) refuse(where, "is the same frame as " + one_line(before->second) + "; give each frame once");
    }
    try {
      if (!sums_) sums_.emplace(view.width, view.height, calib::CountRange{0.0, top_});
      sums_->add(view, source_.threads);
    } catch (const mtf::UsageError& error) {
      refuse(where, error.what());
    }
  }

  calib::Stack take() {
    if (static_cast<double>(sums_->bits()) > top_)
      refuse(entry_.name, "values outside 0 to " + significant(top_, 12) + ", which is what " +
                              std::to_string(source_.bits) + " bits hold; correct bits in [camera]");
    const std::uint32_t step = sums_->step();
    if (step > 1)
      refuse(entry_.name, "all values are multiples of " + std::to_string(step) +
                              ": fewer bits, stored shifted; write step = " + significant(file_.step * step, 6) +
                              " and their bits in [camera]");
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
  const StackEntry& entry_;
  const StacksFile& file_;
  FrameSource& source_;
  double top_;
  std::optional<calib::StackStatistics> sums_;
};

}  // namespace

calib::Stack read_stack(const StackEntry& entry, const StacksFile& file, FrameSource& source) {
  Reduction reduction(entry, file, source);
  for (const std::string& path : entry.files) {
    if (!path.ends_with(".npy")) {
      reduction.add(read_picture(path), path);
    } else {
      mtf::io::NpyReader cube(path);
      std::vector<std::uint64_t> shape = cube.shape();
      if (shape.size() == 2) shape.insert(shape.begin(), 1);
      if (shape.size() != 3) refuse(path, "a cube of frames x rows x columns belongs here");
      mtf::io::check_plane_size(path, static_cast<std::int64_t>(shape[2]), static_cast<std::int64_t>(shape[1]), 1);
      for (std::uint64_t t = 0; t < shape[0]; ++t) {
        mtf::Image frame(static_cast<std::int64_t>(shape[2]), static_cast<std::int64_t>(shape[1]));
        const auto size = static_cast<std::size_t>(frame.size());
        cube.read(t * size, {frame.data(), size});
        reduction.add(std::move(frame), path + " frame " + std::to_string(t + 1));
      }
    }
    if (source.progress) source.progress();
  }
  return reduction.take();
}

}  // namespace apps
