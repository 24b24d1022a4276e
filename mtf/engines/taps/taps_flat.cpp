// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps/taps_flat.h"

#include <cstring>

#include "mtf/math/clones.h"
#include "mtf/parallel.h"

namespace mtf::taps {
namespace {

using Kind = UniformRuns::Kind;

// Groups of samples that a group of outputs reads.
struct Support {
  struct Range {
    std::int64_t first, last;
  };
  std::vector<Range> ranges;
  bool border = false;  ///< whether it also reads the value of a constant border
};

Support support_of(const TapAxis& x, Border border, std::int64_t group) {
  const std::int64_t n = x.samples, outputs = std::min(group * kVector + kVector, x.outputs) - 1;
  const std::int64_t first = group * kVector * x.ratio + x.first, last = outputs * x.ratio + x.first + x.count - 1;
  const std::int64_t left = std::max<std::int64_t>(0, -first), right = std::max<std::int64_t>(0, last - n + 1);
  Support support;
  const auto add = [&](std::int64_t from, std::int64_t to) {
    if (from <= to) support.ranges.push_back({from / kVector, to / kVector});
  };
  support.border = border == Border::constant && left + right > 0;
  if (std::max(left, right) > n) {
    add(0, n - 1);
    return support;
  }
  add(std::max<std::int64_t>(first, 0), std::min(last, n - 1));
  if (border == Border::reflect) add(0, left - 1), add(n - right, n - 1);
  if (border == Border::periodic) add(n - left, n - 1), add(0, right - 1);
  if (border == Border::replicate && left > 0) add(0, 0);
  if (border == Border::replicate && right > 0) add(n - 1, n - 1);
  return support;
}

Kind kind_within(const Kind* row, const Support& support, Kind border_kind) {
  const Kind kind = row[support.ranges.front().first];
  if (support.border && border_kind != kind) return 0;
  for (const Support::Range& range : support.ranges)
    for (std::int64_t i = range.first; i <= range.last; ++i)
      if (row[i] != kind) return 0;
  return kind;
}

// The next row down: `alike` counts for how many rows each group has kept its kind, and `out` is that kind where it has
// kept it for `count` rows, else 0.
MTFKIT_CLONES void add_row(const Kind* __restrict row, const Kind* __restrict above, std::int64_t groups,
                           std::int32_t count, std::int32_t* __restrict alike, Kind* __restrict out) {
  for (std::int64_t g = 0; g < groups; ++g) {
    alike[g] = row[g] == above[g] ? alike[g] + 1 : 1;
    out[g] = alike[g] >= count ? row[g] : Kind{0};
  }
}

}  // namespace

TapsFlat::TapsFlat(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border)
    : map_(channel.flat), groups_((x.outputs + kVector - 1) / kVector) {
  if (map_ == nullptr || !map_->any()) return;
  const Kind border_kind = map_->kind_of(static_cast<float>(channel.border_value));
  std::vector<Support> supports;
  for (std::int64_t g = 0; g < groups_; ++g) supports.push_back(support_of(x, border, g));

  const std::int64_t needed = (y.outputs - 1) * y.ratio + y.count;
  const auto groups = static_cast<std::size_t>(groups_), samples = static_cast<std::size_t>(map_->groups());
  rows_.resize(static_cast<std::size_t>(needed) * groups);
  outputs_.resize(static_cast<std::size_t>(y.outputs) * groups);
  std::vector<std::int32_t> alike(groups, 0);
  std::vector<Kind> made(groups);
  const Kind* before = nullptr;  // many rows equal the one above
  std::int64_t alike_rows = 0;   // so far; nothing changes once the taps read no other rows
  for (std::int64_t r = 0; r < needed; ++r) {
    Kind* row = rows_.data() + static_cast<std::size_t>(r) * groups;
    const std::int64_t source = border_source(border, y.first + r, y.samples);
    const Kind* kinds = source < 0 ? nullptr : map_->row(source);
    ++alike_rows;
    if (kinds != nullptr && before != nullptr && std::memcmp(kinds, before, samples) == 0) {
      std::memcpy(row, row - groups, groups);
    } else {
      alike_rows = 0;
      for (std::size_t g = 0; g < groups; ++g)
        row[g] = kinds == nullptr ? border_kind : kind_within(kinds, supports[g], border_kind);
    }
    before = kinds;
    if (alike_rows <= y.count)
      add_row(row, r == 0 ? row : row - groups, groups_, static_cast<std::int32_t>(y.count), alike.data(), made.data());
    if (r >= y.count - 1 && (r - y.count + 1) % y.ratio == 0)
      std::memcpy(outputs_.data() + static_cast<std::size_t>((r - y.count + 1) / y.ratio) * groups, made.data(),
                  groups);
  }
}

void TapsFlat::fill_row(const Channel& channel, std::int64_t y) const {
  if (outputs_.empty()) return;
  for_stretches(output(y, 0), channel.out.width, [&](std::int64_t begin, std::int64_t end, Kind kind) {
    if (kind != 0)
      std::fill(channel.out.row(y) + begin, channel.out.row(y) + end, static_cast<float>(channel.dc * value(kind)));
  });
}

TileArea TapsFlat::rest(const TileArea& area) const {
  if (outputs_.empty()) return area;
  const std::int64_t groups = (area.columns + kVector - 1) / kVector;
  std::int64_t left = area.columns, right = 0, top = area.rows, bottom = 0;
  for (std::int64_t y = 0; y < area.rows; ++y) {
    const Kind *kinds = output(area.y0 + y, area.x0), *end = kinds + groups;
    const Kind* first = std::find(kinds, end, 0);
    if (first == end) continue;
    const Kind* last = end;
    while (*(last - 1) != 0) --last;
    left = std::min(left, (first - kinds) * kVector);
    right = std::max(right, std::min((last - kinds) * kVector, area.columns));
    top = std::min(top, y), bottom = y + 1;
  }
  if (bottom == 0) return {area.x0, area.y0, 0, 0};
  return {area.x0 + left, area.y0 + top, right - left, bottom - top};
}

std::int64_t TapsFlat::bytes(const TapAxis& x, const TapAxis& y) {
  const std::int64_t groups = (x.outputs + kVector - 1) / kVector;
  return groups * (y.outputs * (y.ratio + 1) + y.count);
}

void for_each_tile(const std::vector<Channel>& channels, const TapAxis& x, const TapAxis& y, Border border,
                   std::int64_t rows, int threads,
                   const std::function<void(const Channel&, const TapsFlat&, const TileArea&)>& tile) {
  std::vector<TapsFlat> flat;
  struct Task {
    std::size_t channel;
    TileArea area;
  };
  std::vector<Task> tasks;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    flat.emplace_back(channels[c], x, y, border);
    parallel_for_each(y.outputs, 64, threads, [&](std::int64_t j) { flat.back().fill_row(channels[c], j); });
    // Tiles of about the same width: a narrow tile costs as much as a wider one.
    const TileArea work = flat.back().rest({0, 0, x.outputs, y.outputs});
    const std::int64_t across = (work.columns + kTileColumns - 1) / kTileColumns;
    const std::int64_t width = across > 0 ? whole_vectors((work.columns + across - 1) / across) : kTileColumns;
    for (std::int64_t y0 = 0; y0 < work.rows; y0 += rows)
      for (std::int64_t x0 = 0; x0 < work.columns; x0 += width)
        tasks.push_back(
            {c, {work.x0 + x0, work.y0 + y0, std::min(width, work.columns - x0), std::min(rows, work.rows - y0)}});
  }
  parallel_for(static_cast<std::int64_t>(tasks.size()), 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      tile(channels[tasks[i].channel], flat[tasks[i].channel], tasks[i].area);
  });
}

}  // namespace mtf::taps
