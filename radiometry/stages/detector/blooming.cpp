// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/blooming.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mtf/parallel.h"

namespace radiometry {
namespace {

constexpr std::int64_t kLinesAtOnce = 16;

/// One line of pixels: the charge of each up to the full well, and its excess.
struct Line {
  std::vector<double> held, spill, first, second;

  explicit Line(std::int64_t length) {
    for (auto* list : {&held, &spill, &first, &second}) list->resize(static_cast<std::size_t>(length));
  }
};

/// Fills pixel i from the charge that is carried along.
void absorb(double& held, double well, double& carried) {
  const double taken = std::min(std::max(well - held, 0.0), carried);
  if (!(taken > 0.0)) return;  // full, NaN, or nothing carried
  held += taken;
  carried = taken < carried ? carried - taken : 0.0;
}

/// Half of each spill goes up the line, half down; returns the charge that leaves at the ends. `up_first` goes first.
double spread(const std::vector<double>& spill, double well, bool up_first, std::vector<double>& held) {
  double left = 0.0;
  for (const bool up : {up_first, !up_first}) {
    double carried = 0.0;
    for (std::size_t n = 0; n < held.size(); ++n) {
      const std::size_t i = up ? n : held.size() - 1 - n;
      absorb(held[i], well, carried);
      carried += 0.5 * spill[i];
    }
    left += carried;
  }
  return left;
}

/// Spreads `spill` over `held` in place, as the mean of both orders; returns the charge that leaves at the ends.
double spread(Line& line, double well) {
  line.first = line.second = line.held;
  const double left = 0.5 * (spread(line.spill, well, true, line.first) + spread(line.spill, well, false, line.second));
  for (std::size_t i = 0; i < line.held.size(); ++i) line.held[i] = 0.5 * (line.first[i] + line.second[i]);
  return left;
}

/// Lines of an image as one, to go over rows and columns alike.
struct Lines {
  float* data;
  std::int64_t count, length, from_line, from_pixel;

  float& at(std::int64_t line, std::int64_t i) const { return data[line * from_line + i * from_pixel]; }
};

Lines lines_of(mtf::ImageView<float> image, bool columns) {
  if (columns) return {image.data, image.width, image.height, 1, image.stride};
  return {image.data, image.height, image.width, image.stride, 1};
}

/// Spills `part` of the charge above the well in each line; the rest stays where it is.
Spilled bloom_lines(const Lines& lines, double well, double part, double drain, int threads) {
  std::vector<Spilled> of_line(static_cast<std::size_t>(lines.count));
  mtf::parallel_for(lines.count, kLinesAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    Line line(lines.length);
    for (std::int64_t l = begin; l < end; ++l) {
      bool any = false;
      for (std::int64_t i = 0; i < lines.length; ++i) any = any || static_cast<double>(lines.at(l, i)) > well;
      if (!any) continue;
      Spilled& spilled = of_line[static_cast<std::size_t>(l)];
      for (std::int64_t i = 0; i < lines.length; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const double electrons = static_cast<double>(lines.at(l, i)), excess = part * (electrons - well);
        const bool over = electrons > well;
        line.held[n] = over ? well : electrons;
        line.spill[n] = over && drain < 1.0 ? (1.0 - drain) * excess : 0.0;
        if (over && drain > 0.0) spilled.drained_e += drain * excess;
      }
      spilled.left_e = spread(line, well);
      for (std::int64_t i = 0; i < lines.length; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const double electrons = static_cast<double>(lines.at(l, i));
        const double kept = electrons > well && part < 1.0 ? (1.0 - part) * (electrons - well) : 0.0;
        lines.at(l, i) = static_cast<float>(line.held[n] + kept);
      }
    }
  });
  Spilled all;
  for (const Spilled& one : of_line) {
    all.drained_e += one.drained_e;
    all.left_e += one.left_e;
  }
  return all;
}

}  // namespace

Spilled bloom(mtf::ImageView<float> image, const Blooming& blooming, double full_well_e, int threads) {
  require_valid("blooming", blooming);
  if (!(full_well_e > 0.0))
    throw mtf::UsageError("blooming: a full well of " + mtf::format_double(full_well_e) +
                          " electrons; it has to be above 0");
  // The well as the float that pixels are held at.
  const auto well = static_cast<double>(static_cast<float>(full_well_e));
  if (!std::isfinite(well)) return {};
  Spilled spilled;
  if (blooming.direction != BloomingDirection::rows) {
    const double part = blooming.direction == BloomingDirection::both ? 0.5 : 1.0;
    spilled = bloom_lines(lines_of(image, true), well, part, blooming.drain, threads);
  }
  if (blooming.direction != BloomingDirection::columns) {
    const Spilled along_rows = bloom_lines(lines_of(image, false), well, 1.0, blooming.drain, threads);
    spilled.drained_e += along_rows.drained_e;
    spilled.left_e += along_rows.left_e;
  }
  return spilled;
}

}  // namespace radiometry
