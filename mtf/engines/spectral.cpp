// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/spectral.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>

#include "mtf/engines/kernels.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

static_assert(kRow == kernels::kColumns && kRow % FlatMap::kGroup == 0);

constexpr std::int64_t round_up(std::int64_t n, std::int64_t step) { return (n + step - 1) / step * step; }

template <class S>
void add(const S* __restrict from, std::int64_t count, S* __restrict to) {
  for (std::int64_t i = 0; i < count; ++i) to[i] += from[i];
}

}  // namespace

std::vector<OtfPart> otf_parts(const AxisJob& x, const AxisJob& y, bool real) {
  std::vector<OtfPart> parts{{Parity::even, Parity::even}};
  if (y.odd && !real) parts.push_back({Parity::even, Parity::odd});
  if (x.odd && !real) parts.push_back({Parity::odd, Parity::even});
  if (x.odd && y.odd) parts.push_back({Parity::odd, Parity::odd});
  return parts;
}

template <class S>
SpectralEngine<S>::SpectralEngine(const AxisJob& x, const AxisJob& y, Lines lines, fft::Rigor rigor)
    : x_(x, true, rigor), y_(y, false, rigor), lines_(lines) {
  assert(x.frequency.basis == Basis::fourier ? !y.odd : y.frequency.basis == Basis::cosine);
}

template <class S>
OtfBlocks<S> SpectralEngine<S>::make_blocks(bool real) const {
  const std::vector<OtfPart> parts = otf_parts(x(), y(), real);
  const auto rows = static_cast<std::int64_t>(otf_frequencies(y()).size());
  const auto count = static_cast<std::int64_t>(parts.size()) * blocks() * rows * kRow;
  return {!real && x().frequency.basis == Basis::fourier, parts, blocks(), rows,
          BufferPool::Loan<S>(pool_, static_cast<std::size_t>(count))};
}

template <class S>
double SpectralEngine<S>::otf_scale() const {
  return 1.0 / (static_cast<double>(x().frequency.length) * static_cast<double>(y().frequency.length));
}

template <class S>
std::int64_t SpectralEngine<S>::block_rows() const {
  // Whole groups of rows, and one more for the level beyond a border, which also keeps the blocks of one row out of the
  // same cache sets.
  return round_up(std::max(y().samples, y().outputs), kRow) + 1;
}

template <class S>
std::int64_t SpectralEngine<S>::coefficient_rows() const {
  return blocks() * kRow;
}

template <class S>
std::int64_t SpectralEngine<S>::line_stride() const {
  return round_up(std::max(x().samples, x().outputs), kLanes) + kLanes;
}

template <class S>
std::int64_t SpectralEngine<S>::run_bytes(std::int64_t channels, int threads) const {
  const std::int64_t planes = x().odd ? 2 : 1, areas = x().odd || y().odd ? 3 : 2;
  const std::int64_t rows =
      coefficient_rows() + line_stride() + x().samples + 1 + areas * std::max(x_.rows(), y_.rows());
  const std::int64_t numbers = planes * channels * blocks() * block_rows() + std::int64_t{std::max(threads, 1)} * rows;
  return numbers * kRow * static_cast<std::int64_t>(sizeof(S));
}

template <class S>
void SpectralEngine<S>::run(const std::vector<Channel>& channels, const OtfBlocks<S>& otf, int threads) const {
  std::vector<BufferPool::Loan<S>> loans;
  const auto buffer = [&] {
    loans.emplace_back(pool_, static_cast<std::size_t>(blocks() * block_rows() * kRow));
    return loans.back().data();
  };
  std::vector<Buffers> buffers;
  for (const Channel& channel : channels) {
    buffers.push_back({buffer(), x().odd ? buffer() : nullptr});
    lines_forward(channel, buffers.back().even, threads);
  }
  columns(channels, buffers, otf, threads);
  for (std::size_t c = 0; c < channels.size(); ++c) lines_inverse(channels[c], buffers[c], threads);
}

// A cosine coefficient is a row of 2 x kLanes lines: a tile of kLanes frequencies fills half the width of a block. A
// complex one is two rows, of the first and the last kLanes lines, and its real and imaginary parts fill both halves.
template <class S>
void SpectralEngine<S>::for_tiles(auto* coefficients, auto* buffer, std::int64_t first_row, const auto& tile) const {
  const bool pairs = x_.rows_per_coefficient() == 2;
  for (std::int64_t b = 0; b < blocks(); ++b)
    for (int half = 0; half < 2; ++half)
      for (int lines = 0; lines < 2; ++lines) {
        auto* from = coefficients + b * kRow * kRow;
        from += pairs ? lines * kRow + half * kLanes : half * kLanes * kRow + lines * kLanes;
        tile(from, buffer + (b * block_rows() + first_row + lines * kLanes) * kRow + half * kLanes);
      }
}

// Samples of lines begin .. end - 1 about the mean, a line a lane; lines that are missing are zeros.
template <class S>
void SpectralEngine<S>::load(const Channel& channel, std::int64_t begin, std::int64_t end, S* samples) const {
  const std::int64_t n = x().samples;
  if (lines_ == Lines::columns)
    return kernels::center_columns(channel.in.data + begin, channel.in.stride, n, end - begin, channel.mean,
                                   channel.scale, samples);
  const std::int64_t stride = line_stride();
  const BufferPool::Loan<S> lines(pool_, static_cast<std::size_t>(kRow * stride));
  for (std::int64_t i = 0; i < kRow; ++i) {
    S* line = lines.data() + i * stride;
    if (begin + i < end)
      kernels::center(channel.in.row(begin + i), n, channel.mean, channel.scale, line);
    else
      std::fill_n(line, n, S(0));
  }
  lanes::lines_to_lanes(lines.data(), stride, n, samples);
}

template <class S>
void SpectralEngine<S>::store(const Channel& channel, std::int64_t begin, std::int64_t end, const S* samples) const {
  const double unscale = 1.0 / channel.scale;
  if (lines_ == Lines::columns)
    return kernels::restore_columns(samples, x_.out_rows(), end - begin, channel.out_mean, unscale, channel.out.stride,
                                    channel.out.data + begin);
  const std::int64_t stride = line_stride();
  const BufferPool::Loan<S> lines(pool_, static_cast<std::size_t>(kRow * stride));
  lanes::lanes_to_lines<S>(samples, x_.out_rows(), lines.data(), stride);
  for (std::int64_t i = begin; i < end; ++i)
    kernels::restore(lines.data() + (i - begin) * stride, x().outputs, channel.out_mean, unscale, channel.out.row(i));
}

// Lines begin .. end - 1 of which only the zeroth coefficient counts.
template <class S>
void SpectralEngine<S>::store_levels(const Channel& channel, std::int64_t begin, std::int64_t end,
                                     const S* buffer) const {
  std::array<float, kRow> levels{};
  for (std::int64_t k = begin; k < end; ++k)
    levels[static_cast<std::size_t>(k - begin)] =
        static_cast<float>(static_cast<double>(buffer[k * kRow]) / channel.scale + channel.out_mean);
  if (lines_ == Lines::columns)
    for (std::int64_t i = 0; i < x().outputs; ++i) std::copy_n(levels.data(), end - begin, channel.out.row(i) + begin);
  else
    for (std::int64_t k = begin; k < end; ++k)
      std::fill_n(channel.out.row(k), x().outputs, levels[static_cast<std::size_t>(k - begin)]);
}

template <class S>
void SpectralEngine<S>::lines_forward(const Channel& channel, S* buffer, int threads) const {
  const std::int64_t used = x().keep * x_.rows_per_coefficient();
  parallel_for(y().samples, kRow, threads, [&](std::int64_t begin, std::int64_t end) {
    if (level_lines(channel, begin, end, buffer)) return;
    const BufferPool::Loan<S> samples(pool_, static_cast<std::size_t>((x().samples + 1) * kRow)),
        work(pool_, static_cast<std::size_t>(x_.rows() * kRow)),
        coefficients(pool_, static_cast<std::size_t>(coefficient_rows() * kRow));
    load(channel, begin, end, samples.data());
    std::fill_n(samples.data() + x().samples * kRow, kRow, level(channel));
    x_.forward(samples.data(), work.data());
    x_.coefficients(work.data(), coefficients.data());
    std::fill_n(coefficients.data() + used * kRow, (coefficient_rows() - used) * kRow, S(0));
    const std::int64_t step = kRow * x_.rows_per_coefficient();
    for_tiles(coefficients.data(), buffer, begin,
              [&](const S* from, S* to) { lanes::transpose(from, step, to, kRow); });
  });
}

// Writes the coefficients of a group of lines where each is of one level on all of its canvas.
template <class S>
bool SpectralEngine<S>::level_lines(const Channel& channel, std::int64_t begin, std::int64_t end, S* buffer) const {
  if (channel.flat == nullptr || !channel.flat->any()) return false;
  const FlatMap& flat = *channel.flat;
  const bool by_row = lines_ == Lines::rows;
  const std::int64_t places = by_row ? flat.groups() : x().samples;
  const std::int64_t together = by_row ? 1 : FlatMap::kGroup;  // columns are flat in groups
  std::array<S, kRow> levels{};
  for (std::int64_t k = begin; k < end; k += together) {
    const auto kind = [&](std::int64_t i) { return by_row ? flat.row(k)[i] : flat.row(i)[k / FlatMap::kGroup]; };
    for (std::int64_t i = 0; i < places; ++i)
      if (kind(i) == 0 || kind(i) != kind(0)) return false;
    const float value = flat.level(kind(0));
    if (x().border == Border::constant && value != static_cast<float>(channel.border_value)) return false;
    const S level = static_cast<S>((value - channel.mean) * channel.scale);
    std::fill_n(levels.begin() + (k - begin), std::min(together, end - k), level);
  }
  for (std::int64_t b = 0; b < blocks(); ++b) {
    S* rows = buffer + (b * block_rows() + begin) * kRow;
    std::fill_n(rows, kRow * kRow, S(0));
    for (std::size_t i = 0; b == 0 && i < kRow; ++i) rows[i * kRow] = levels[i] * static_cast<S>(x().frequency.length);
  }
  return true;
}

// Sum of the squares of all coefficients of filtered rows but the zeroth ones; what is above `limit` need not be exact.
template <class S>
double SpectralEngine<S>::energy(const Buffers& buffers, std::int64_t begin, std::int64_t end, double limit) const {
  double sum = 0.0;
  for (const S* buffer : {static_cast<const S*>(buffers.even), static_cast<const S*>(buffers.odd)}) {
    for (std::int64_t b = 0; buffer != nullptr && b < blocks() && sum <= limit; ++b) {
      const S* rows = buffer + (b * block_rows() + begin) * kRow;
      std::array<S, kRow> squares{};
      for (std::int64_t i = 0; i < end - begin; ++i)
        for (std::size_t l = 0; l < kRow; ++l)
          squares[l] += rows[i * kRow + static_cast<std::int64_t>(l)] * rows[i * kRow + static_cast<std::int64_t>(l)];
      sum += std::accumulate(squares.begin() + (b == 0 && buffer == buffers.even ? 1 : 0), squares.end(), 0.0);
    }
  }
  return sum;
}

// Groups of filtered rows that are left of one level: the quietest, as many as the allowance covers. The samples of a
// series sum c_k (1 or 2 cos, by k) have the mean square sum 2 c_k^2; where frequencies fold onto one another, or the
// canvas is longer than the image, that much more.
template <class S>
std::vector<bool> SpectralEngine<S>::silent_lines(const Channel& channel, const Buffers& buffers, int threads) const {
  const std::int64_t groups = (y().outputs + kRow - 1) / kRow;
  std::vector<bool> silent(static_cast<std::size_t>(groups), false);
  if (!(channel.allowance > 0.0) || x().resampling != Resampling::fold) return silent;
  const double period = static_cast<double>(x().out_length) * (x().frequency.basis == Basis::cosine ? 2.0 : 1.0);
  const double aliases = std::ceil((2.0 * static_cast<double>(x().keep) - 1.0) / period);
  const double square = (aliases > 1.0 ? 4.0 * aliases : 2.0) * (buffers.odd != nullptr ? 2.0 : 1.0) *
                        static_cast<double>(x().out_length) / static_cast<double>(x().outputs);
  double room = std::pow(channel.allowance * channel.scale, 2) * static_cast<double>(y().outputs) / square;
  std::vector<std::pair<double, std::int64_t>> energies(static_cast<std::size_t>(groups));
  parallel_for(groups, 1, threads, [&](std::int64_t g, std::int64_t) {
    energies[static_cast<std::size_t>(g)] = {energy(buffers, g * kRow, std::min(y().outputs, (g + 1) * kRow), room), g};
  });
  std::sort(energies.begin(), energies.end());
  for (const auto& [sum, g] : energies) {
    if (!(sum <= room)) break;
    room -= sum;
    silent[static_cast<std::size_t>(g)] = true;
  }
  return silent;
}

template <class S>
void SpectralEngine<S>::columns(const std::vector<Channel>& channels, const std::vector<Buffers>& buffers,
                                const OtfBlocks<S>& otf, int threads) const {
  parallel_for(blocks(), 1, threads, [&](std::int64_t b, std::int64_t) {
    const auto area = static_cast<std::size_t>(y_.rows() * kRow);
    const BufferPool::Loan<S> work(pool_, area), target(pool_, area);
    std::optional<BufferPool::Loan<S>> other;
    if (otf.parts.size() > 1) other.emplace(pool_, area);
    const std::int64_t first = b * block_rows() * kRow;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto [even, odd] = buffers[c];
      column_block(channels[c], otf, b, {even + first, odd == nullptr ? nullptr : odd + first},
                   {work.data(), target.data(), other ? other->data() : nullptr});
    }
  });
}

template <class S>
void SpectralEngine<S>::column_block(const Channel& channel, const OtfBlocks<S>& otf, std::int64_t block,
                                     const Buffers& data, const std::array<S*, 3>& areas) const {
  const auto [work, target, other] = areas;
  // A row of the constant level has one coefficient only: that of frequency zero.
  S* level_row = data.even + y().samples * kRow;
  std::fill_n(level_row, kRow, S(0));
  if (block == 0) level_row[0] = level(channel) * static_cast<S>(x().frequency.length);
  y_.forward(data.even, work);
  for (std::size_t p = 0; p < otf.parts.size(); ++p) {
    const auto [along_x, along_y] = otf.parts[p];
    const bool last = p + 1 == otf.parts.size(), more = p > 0 && otf.parts[p - 1].x == along_x;
    const S* samples = y_.inverse(along_y, work, otf.row(p, block, 0), otf.complex, target, last ? work : other);
    S* to = along_x == Parity::even ? data.even : data.odd;
    for (const std::int32_t row : y_.out_rows()) {
      const S* sample = samples + std::int64_t{row} * kRow;
      if (more)
        add(sample, kRow, to);
      else
        std::memcpy(to, sample, kRow * sizeof(S));
      to += kRow;
    }
    // Lines come in pairs: what has no partner is one of zeros.
    std::fill_n(to, (round_up(y().outputs, kRow) - y().outputs) * kRow, S(0));
  }
}

template <class S>
void SpectralEngine<S>::lines_inverse(const Channel& channel, const Buffers& buffers, int threads) const {
  const std::int64_t step = kRow * x_.rows_per_coefficient();
  const std::vector<bool> silent = silent_lines(channel, buffers, threads);
  parallel_for(y().outputs, kRow, threads, [&](std::int64_t begin, std::int64_t end) {
    if (silent[static_cast<std::size_t>(begin / kRow)]) return store_levels(channel, begin, end, buffers.even);
    const auto area = static_cast<std::size_t>(x_.rows() * kRow);
    const BufferPool::Loan<S> work(pool_, area), target(pool_, area),
        coefficients(pool_, static_cast<std::size_t>(coefficient_rows() * kRow));
    const auto samples_of = [&](Parity parity, const S* buffer, S* a, S* b) {
      for_tiles(coefficients.data(), buffer, begin,
                [&](S* to, const S* from) { lanes::transpose(from, kRow, to, step); });
      return x_.inverse(parity, coefficients.data(), nullptr, false, a, b);
    };
    S* samples = samples_of(Parity::even, buffers.even, target.data(), work.data());
    if (buffers.odd != nullptr) {
      const BufferPool::Loan<S> other(pool_, area);
      S* spare = samples == work.data() ? target.data() : work.data();
      add(samples_of(Parity::odd, buffers.odd, spare, other.data()), inverse_length(x()) * kRow, samples);
    }
    store(channel, begin, end, samples);
  });
}

template class SpectralEngine<float>;
template class SpectralEngine<double>;

}  // namespace mtf
