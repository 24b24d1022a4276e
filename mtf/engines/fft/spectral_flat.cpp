// SPDX-License-Identifier: Apache-2.0
// Lines of one level in the spectral engine, before and behind the filter.
#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <numeric>
#include <utility>

#include "mtf/engines/fft/spectral.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

// A line of this level has it on all of its canvas.
bool goes_on(const Channel& channel, Border border, float level) {
  return std::isfinite(level) && (border != Border::constant || level == static_cast<float>(channel.border_value));
}

struct LineRun {
  std::int64_t first, end;
};

using Runs = std::vector<LineRun>;

void add_run(const LineRun& run, Runs& runs) {
  if (!runs.empty() && runs.back().end == run.first)
    runs.back().end = run.end;
  else
    runs.push_back(run);
}

}  // namespace

// Whether rows begin .. end - 1 are of one level each.
template <class S>
bool SpectralEngine<S>::level_rows(const Channel& channel, std::int64_t begin, std::int64_t end) const {
  for (std::int64_t k = begin; k < end; ++k)
    if (!goes_on(channel, x().border, channel.in.at(0, k)) || !kernels::all_alike(channel.in.row(k), x().samples))
      return false;
  return true;
}

// Groups of columns that are of one level each: all rows are the same there. Looked at by rows, which memory is read by
// fastest, and by runs of groups while these are alike.
template <class S>
std::vector<char> SpectralEngine<S>::level_columns(const Channel& channel, int threads) const {
  const ImageView<const float>& in = channel.in;
  const std::int64_t n = y().samples;
  Runs candidates;
  for (std::int64_t k = 0; k < n; k += kRow) {
    const float *first = in.data + k, *last = in.data + std::min(k + kRow, n);
    if (std::all_of(first, last, [&](float v) { return goes_on(channel, x().border, v); }))
      add_run({k, std::min(k + kRow, n)}, candidates);
  }
  std::vector<char> level(static_cast<std::size_t>(groups_in()), 1);
  const auto split = [&](const Runs& runs, const float* row) {
    Runs alike;
    for (const auto& [first, end] : runs)
      for (std::int64_t k = first; k < end; k += kRow)
        if (const std::int64_t next = std::min(k + kRow, end); kernels::same(row + k, in.data + k, next - k))
          add_run({k, next}, alike);
    return alike;
  };
  std::mutex all;
  parallel_for(x().samples, 64, threads, [&](std::int64_t begin, std::int64_t end) {
    Runs runs = candidates;
    for (std::int64_t i = begin; i < end && !runs.empty(); ++i) {
      const float* row = in.row(i);
      if (i + 1 < end) kernels::prefetch(in.row(i + 1) + runs.front().first, runs.front().end - runs.front().first);
      const auto is_same = [&](const LineRun& r) {
        return kernels::same(row + r.first, in.data + r.first, r.end - r.first);
      };
      if (!std::all_of(runs.begin(), runs.end(), is_same)) runs = split(runs, row);
    }
    std::vector<char> here(level.size(), 0);
    for (const auto& [first, last] : runs)
      std::fill(here.begin() + first / kRow, here.begin() + (last + kRow - 1) / kRow, 1);
    const std::scoped_lock guard(all);
    std::transform(level.begin(), level.end(), here.begin(), level.begin(), std::bit_and<char>());
  });
  return level;
}

// Writes the coefficients of a group of lines of one level: one each, in the first block. The others' are not read
// (leave_out_levels).
template <class S>
kernels::Moments SpectralEngine<S>::read_levels(const Channel& channel, std::int64_t begin, std::int64_t end,
                                                S* buffer) const {
  const double n = static_cast<double>(x().samples);
  S* coefficients = buffer + begin * kRow;
  std::fill_n(coefficients, kRow * kRow, S(0));
  kernels::Moments all;
  for (std::int64_t k = begin; k < end; ++k, coefficients += kRow) {
    const double value = lines_ == Lines::rows ? channel.in.at(0, k) : channel.in.at(k, 0);
    // Squared as samples are: what is too large for S shows.
    const S level = static_cast<S>((value - channel.mean) * channel.scale);
    all += {n * static_cast<double>(level), n * static_cast<double>(level * level)};
    *coefficients = level * static_cast<S>(x().frequency.length);
  }
  return all;
}

// In the columns of all blocks but the first, lines of one level are like the row of the level there: zeros.
template <class S>
void SpectralEngine<S>::leave_out_levels(Plane& plane) const {
  const auto is_level = [&](std::int64_t line) { return plane.level[static_cast<std::size_t>(line / kRow)] != 0; };
  if (std::find(plane.level.begin(), plane.level.end(), 1) == plane.level.end()) return;
  plane.canvas.assign(y_.canvas().begin(), y_.canvas().end());
  for (std::int32_t& line : plane.canvas)
    if (line < y().samples && is_level(line)) line = static_cast<std::int32_t>(y().samples);
  if (!(plane.channel.allowance > 0.0) || x().resampling != Resampling::fold) return;
  const double ratio = y().pitch_um / y().frequency.step_um;
  for (std::int64_t g = 0; g < groups_out(); ++g) {
    const auto middle = [&](std::int64_t line) {
      return std::min(static_cast<std::int64_t>((static_cast<double>(line) + 0.5) * ratio), y().samples - 1);
    };
    if (is_level(middle(g * kRow)) && is_level(middle(std::min((g + 1) * kRow, y().outputs) - 1)))
      plane.over.push_back(g);
  }
  plane.energies.resize(plane.over.size() * static_cast<std::size_t>(blocks()));
}

// Groups of lines of which only the zeroth coefficient counts.
template <class S>
void SpectralEngine<S>::store_levels(const Plane& plane, const std::vector<bool>& silent, int threads) const {
  const Channel& channel = plane.channel;
  std::vector<float> levels(static_cast<std::size_t>(y().outputs));
  Runs runs;
  for (std::int64_t g = 0; g < groups_out(); ++g) {
    if (!silent[static_cast<std::size_t>(g)]) continue;
    const std::int64_t begin = g * kRow, end = std::min(begin + kRow, y().outputs);
    for (std::int64_t k = begin; k < end; ++k)
      levels[static_cast<std::size_t>(k)] =
          static_cast<float>(static_cast<double>(plane.buffers.even[k * kRow]) / channel.scale + channel.out_mean());
    add_run({begin, end}, runs);
  }
  if (lines_ == Lines::rows) {
    for (const auto& [first, last] : runs)
      parallel_for(last - first, kRow, threads, [&, first = first](std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = first + begin; k < first + end; ++k)
          std::fill_n(channel.out.row(k), x().outputs, levels[static_cast<std::size_t>(k)]);
      });
    return;
  }
  parallel_for(x().outputs, kRow, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      for (const auto& [first, last] : runs)
        std::copy(levels.begin() + first, levels.begin() + last, channel.out.row(i) + first);
  });
}

// Sums of the squares of a block's coefficients but the zeroth ones, while they are at hand.
template <class S>
void SpectralEngine<S>::add_energies(Plane& plane, std::int64_t block) const {
  const auto [even, odd] = plane.buffers.of_rows(block * block_rows());
  for (std::size_t i = 0; i < plane.over.size(); ++i) {
    const std::int64_t begin = plane.over[i] * kRow, end = std::min(begin + kRow, y().outputs);
    double& energy = plane.energies[i * static_cast<std::size_t>(blocks()) + static_cast<std::size_t>(block)];
    for (const S* rows : {static_cast<const S*>(even), static_cast<const S*>(odd)}) {
      if (rows == nullptr) continue;
      std::array<S, kRow> squares{};
      for (const S* row = rows + begin * kRow; row < rows + end * kRow; row += kRow)
        for (std::size_t l = 0; l < kRow; ++l) squares[l] += row[l] * row[l];
      energy += std::accumulate(squares.begin() + (block == 0 && rows == even ? 1 : 0), squares.end(), 0.0);
    }
  }
}

// Groups of filtered rows that are left of one level: the quietest, as many as the allowance covers. The samples of a
// series sum c_k (1 or 2 cos, by k) have the mean square sum 2 c_k^2; where frequencies fold onto one another, or the
// canvas is longer than the image, that much more.
template <class S>
std::vector<bool> SpectralEngine<S>::negligible_lines(const Plane& plane) const {
  std::vector<bool> silent(static_cast<std::size_t>(groups_out()), false);
  if (plane.over.empty()) return silent;
  const double period = static_cast<double>(x().out_length) * (x().frequency.basis == Basis::cosine ? 2.0 : 1.0);
  const double aliases = std::ceil((2.0 * static_cast<double>(x().keep) - 1.0) / period);
  const double square = (aliases > 1.0 ? 4.0 * aliases : 2.0) * (plane.buffers.odd != nullptr ? 2.0 : 1.0) *
                        static_cast<double>(x().out_length) / static_cast<double>(x().outputs);
  const double allowance = plane.channel.allowance * plane.std;
  double room = allowance * allowance * static_cast<double>(y().outputs) / square;
  std::vector<std::pair<double, std::int64_t>> groups;
  for (std::size_t i = 0; i < plane.over.size(); ++i) {
    const auto first = plane.energies.begin() + static_cast<std::int64_t>(i) * blocks();
    groups.emplace_back(std::accumulate(first, first + blocks(), 0.0), plane.over[i]);
  }
  std::sort(groups.begin(), groups.end());
  for (const auto& [energy, g] : groups) {
    if (!(energy <= room)) break;
    room -= energy;
    silent[static_cast<std::size_t>(g)] = true;
  }
  return silent;
}

// Of this file only: the others are where the class is.
#define MTFKIT_INSTANTIATE(S)                                                                                     \
  template bool SpectralEngine<S>::level_rows(const Channel&, std::int64_t, std::int64_t) const;                  \
  template std::vector<char> SpectralEngine<S>::level_columns(const Channel&, int) const;                         \
  template kernels::Moments SpectralEngine<S>::read_levels(const Channel&, std::int64_t, std::int64_t, S*) const; \
  template void SpectralEngine<S>::leave_out_levels(Plane&) const;                                                \
  template void SpectralEngine<S>::store_levels(const Plane&, const std::vector<bool>&, int) const;               \
  template void SpectralEngine<S>::add_energies(Plane&, std::int64_t) const;                                      \
  template std::vector<bool> SpectralEngine<S>::negligible_lines(const Plane&) const;
MTFKIT_INSTANTIATE(float)
MTFKIT_INSTANTIATE(double)
#undef MTFKIT_INSTANTIATE

}  // namespace mtf
