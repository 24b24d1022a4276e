// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/microscan.h"

#include <limits>

namespace radiometry {
namespace {

using mtf::UsageError;

void require_microscan(const Microscan& microscan) {
  require_valid("microscan", microscan);
  if (microscan.pattern == MicroscanPattern::diagonal && microscan.steps != 2)
    throw UsageError("microscan.steps = " + std::to_string(microscan.steps) + ": the diagonal pattern has 2");
}

void require_position(const Microscan& microscan, int position) {
  if (position < 0 || position >= microscan.positions())
    throw UsageError("microscan: position " + std::to_string(position) + " of " +
                     std::to_string(microscan.positions()) + ", counted from 0");
}

struct Cell {
  std::int64_t x = 0, y = 0;
};

Cell place_of(const Microscan& microscan, int position) {
  if (microscan.pattern == MicroscanPattern::diagonal) return {position, position};
  return {position % microscan.steps, position / microscan.steps};
}

/// Gives the places of odd x + y the mean of their neighbours, each of which is a measured one.
void fill_between(mtf::ImageView<float> fine) {
  for (std::int64_t y = 0; y < fine.height; ++y)
    for (std::int64_t x = (y + 1) % 2; x < fine.width; x += 2) {
      double sum = 0.0;
      int count = 0;
      const auto add = [&](std::int64_t i, std::int64_t j) {
        if (i < 0 || j < 0 || i >= fine.width || j >= fine.height) return;
        sum += static_cast<double>(fine.at(i, j));
        ++count;
      };
      add(x - 1, y);
      add(x + 1, y);
      add(x, y - 1);
      add(x, y + 1);
      fine.at(x, y) = static_cast<float>(sum / count);
    }
}

}  // namespace

mtf::Image microscan_frame(mtf::ImageView<const float> fine, const Microscan& microscan, int position) {
  require_microscan(microscan);
  require_position(microscan, position);
  const std::int64_t n = microscan.steps;
  if (fine.width < n || fine.height < n || fine.width % n != 0 || fine.height % n != 0)
    throw UsageError("microscan: an image of " + size_of(fine.width, fine.height) +
                     " samples is not a whole number of pitches of " + size_of(n, n) + "; crop it");
  const Cell cell = place_of(microscan, position);
  mtf::Image frame(fine.width / n, fine.height / n);
  for (std::int64_t y = 0; y < frame.height(); ++y)
    for (std::int64_t x = 0; x < frame.width(); ++x) frame.at(x, y) = fine.at(n * x + cell.x, n * y + cell.y);
  return frame;
}

mtf::Image microscan_interlace(std::span<const mtf::Image> frames, const Microscan& microscan) {
  require_microscan(microscan);
  if (frames.size() != static_cast<std::size_t>(microscan.positions()))
    throw UsageError("microscan: " + std::to_string(frames.size()) + " frames for " +
                     std::to_string(microscan.positions()) + " positions; give one for each");
  const std::int64_t n = microscan.steps, width = frames[0].width(), height = frames[0].height();
  for (const mtf::Image& frame : frames)
    if (frame.width() != width || frame.height() != height || frame.size() == 0)
      throw UsageError("microscan: frames of " + size_of(width, height) + " and " +
                       size_of(frame.width(), frame.height()) + " pixels; give all one size");
  mtf::Image fine(n * width, n * height);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Cell cell = place_of(microscan, static_cast<int>(k));
    for (std::int64_t y = 0; y < height; ++y)
      for (std::int64_t x = 0; x < width; ++x) fine.at(n * x + cell.x, n * y + cell.y) = frames[k].at(x, y);
  }
  if (microscan.pattern == MicroscanPattern::diagonal) fill_between(fine.view());
  return fine;
}

NoiseKey microscan_key(const NoiseKey& key, const Microscan& microscan, int position) {
  require_microscan(microscan);
  require_position(microscan, position);
  const std::uint64_t frame = std::uint64_t{key.frame} * static_cast<std::uint64_t>(microscan.positions()) +
                              static_cast<std::uint64_t>(position);
  if (frame > std::numeric_limits<std::uint32_t>::max())
    throw UsageError("microscan: frame " + std::to_string(key.frame) + " of " + std::to_string(microscan.positions()) +
                     " positions; the frames of the detector are counted to below 2^32");
  return {key.seed, static_cast<std::uint32_t>(frame)};
}

}  // namespace radiometry
