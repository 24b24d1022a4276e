// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/line_groups.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "mtf/engines/kernels.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

std::int64_t groups_of(std::int64_t lines) { return (lines + kRow - 1) / kRow; }

LineGroups split(const std::vector<char>& uniform) {
  LineGroups groups;
  for (std::size_t g = 0; g < uniform.size(); ++g)
    (uniform[g] != 0 ? groups.uniform : groups.transformed).push_back(static_cast<std::int64_t>(g));
  return groups;
}

// Whether a line whose samples all have this value has it on all of its canvas.
bool border_continues(const Channel& channel, Border border, float value) {
  return std::isfinite(value) && (border != Border::constant || value == static_cast<float>(channel.border_value));
}

std::vector<char> uniform_rows(const Channel& channel, const AxisTransform& x, std::int64_t rows, int threads) {
  std::vector<char> uniform(static_cast<std::size_t>(groups_of(rows)), 1);
  const auto is_uniform = [&](std::int64_t row) {
    return border_continues(channel, x.border, channel.in.at(0, row)) &&
           kernels::all_alike(channel.in.row(row), x.samples);
  };
  parallel_for(rows, kRow, threads, [&](std::int64_t begin, std::int64_t end) {
    char& all = uniform[static_cast<std::size_t>(begin / kRow)];
    for (std::int64_t row = begin; row < end && all != 0; ++row) all = is_uniform(row) ? 1 : 0;
  });
  return uniform;
}

/// Columns first .. end - 1, whole groups but for the last one.
struct ColumnRange {
  std::int64_t first, end;
};

void append(const ColumnRange& range, std::vector<ColumnRange>& ranges) {
  if (!ranges.empty() && ranges.back().end == range.first)
    ranges.back().end = range.end;
  else
    ranges.push_back(range);
}

// Columns are uniform where every row equals the first one. Memory is read fastest by rows, and ranges of groups that
// are uniform so far are compared whole.
std::vector<char> uniform_columns(const Channel& channel, const AxisTransform& x, std::int64_t columns, int threads) {
  const float* const first_row = channel.in.data;
  const auto equal = [&](const float* row, const ColumnRange& r) {
    return kernels::same(row + r.first, first_row + r.first, r.end - r.first);
  };
  std::vector<ColumnRange> candidates;
  for (std::int64_t k = 0; k < columns; k += kRow) {
    const ColumnRange group{k, std::min(k + kRow, columns)};
    if (std::all_of(first_row + group.first, first_row + group.end,
                    [&](float value) { return border_continues(channel, x.border, value); }))
      append(group, candidates);
  }
  const auto equal_groups = [&](const std::vector<ColumnRange>& ranges, const float* row) {
    std::vector<ColumnRange> kept;
    for (const auto& [first, end] : ranges)
      for (std::int64_t k = first; k < end; k += kRow)
        if (const ColumnRange group{k, std::min(k + kRow, end)}; equal(row, group)) append(group, kept);
    return kept;
  };
  std::vector<char> uniform(static_cast<std::size_t>(groups_of(columns)), 1);
  std::mutex lock;
  parallel_for(x.samples, 64, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<ColumnRange> ranges = candidates;
    for (std::int64_t i = begin; i < end && !ranges.empty(); ++i) {
      const float* row = channel.in.row(i);
      const ColumnRange& next = ranges.front();
      if (i + 1 < end) kernels::prefetch(channel.in.row(i + 1) + next.first, next.end - next.first);
      if (!std::all_of(ranges.begin(), ranges.end(), [&](const ColumnRange& r) { return equal(row, r); }))
        ranges = equal_groups(ranges, row);
    }
    std::vector<char> here(uniform.size(), 0);
    for (const auto& [first, last] : ranges) std::fill(here.begin() + first / kRow, here.begin() + groups_of(last), 1);
    const std::scoped_lock guard(lock);
    std::transform(uniform.begin(), uniform.end(), here.begin(), uniform.begin(), std::bit_and<char>());
  });
  return uniform;
}

}  // namespace

LineGroups input_groups(const Channel& channel, Lines lines, const AxisTransform& x, const AxisTransform& y,
                        int threads) {
  return split(lines == Lines::rows ? uniform_rows(channel, x, y.samples, threads)
                                    : uniform_columns(channel, x, y.samples, threads));
}

std::vector<std::int64_t> groups_over_uniform(const LineGroups& input, const AxisTransform& x, const AxisTransform& y) {
  std::vector<std::int64_t> over;
  if (input.uniform.empty() || x.resampling != Resampling::fold) return over;
  const double ratio = y.pitch_um / y.frequency.step_um;
  const auto is_over_uniform = [&](std::int64_t output) {
    const auto middle = static_cast<std::int64_t>((static_cast<double>(output) + 0.5) * ratio);
    return std::binary_search(input.uniform.begin(), input.uniform.end(), std::min(middle, y.samples - 1) / kRow);
  };
  for (std::int64_t g = 0; g < groups_of(y.outputs); ++g)
    if (is_over_uniform(g * kRow) && is_over_uniform(std::min((g + 1) * kRow, y.outputs) - 1)) over.push_back(g);
  return over;
}

// The samples of a series sum c_k (1 or 2 cos, by k) have the mean square sum 2 c_k^2; where frequencies fold onto one
// another, or the canvas is longer than the image, that much more.
LineGroups output_groups(std::span<const std::int64_t> over_uniform, std::span<const double> energies, double allowance,
                         const AxisTransform& x, const AxisTransform& y) {
  std::vector<char> negligible(static_cast<std::size_t>(groups_of(y.outputs)), 0);
  if (over_uniform.empty()) return split(negligible);
  const double period = static_cast<double>(x.out_length) * (x.frequency.basis == Basis::cosine ? 2.0 : 1.0);
  const double aliases = std::ceil((2.0 * static_cast<double>(x.keep) - 1.0) / period);
  const double mean_square = (aliases > 1.0 ? 4.0 * aliases : 2.0) * (x.odd ? 2.0 : 1.0) *
                             static_cast<double>(x.out_length) / static_cast<double>(x.outputs);
  std::vector<std::pair<double, std::int64_t>> least_first;
  for (std::size_t i = 0; i < over_uniform.size(); ++i) least_first.emplace_back(energies[i], over_uniform[i]);
  std::sort(least_first.begin(), least_first.end());
  double room = allowance * allowance * static_cast<double>(y.outputs) / mean_square;
  for (const auto& [energy, group] : least_first) {
    if (!(energy <= room)) break;
    room -= energy;
    negligible[static_cast<std::size_t>(group)] = 1;
  }
  return split(negligible);
}

}  // namespace mtf
