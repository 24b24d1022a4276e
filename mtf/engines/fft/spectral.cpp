// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/spectral.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <numeric>

#include "mtf/engines/mean_and_deviation.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

static_assert(kRow == kernels::kColumns);

constexpr std::int64_t round_up(std::int64_t n, std::int64_t step) { return (n + step - 1) / step * step; }

// Rows of one block of a buffer: whole groups of lines, and one more for the value of a constant border, which also
// keeps the blocks of one row out of the same cache sets.
constexpr std::int64_t block_rows(std::int64_t lines) { return round_up(lines, kRow) + 1; }

/// work(group, place in the list) for all groups of a list.
void for_groups(const std::vector<std::int64_t>& groups, int threads, const auto& work) {
  parallel_for_each(std::ssize(groups), 1, threads,
                    [&](std::int64_t i) { work(groups[static_cast<std::size_t>(i)], static_cast<std::size_t>(i)); });
}

template <class S>
void add(const S* __restrict from, std::int64_t count, S* __restrict to) {
  for (std::int64_t i = 0; i < count; ++i) to[i] += from[i];
}

}  // namespace

std::vector<OtfPart> otf_parts(const AxisTransform& x, const AxisTransform& y, const Parities& parities) {
  if (x.frequency.basis == Basis::fourier) return {OtfPart{}};
  std::vector<OtfPart> parts;
  for (const OtfPart part : kOtfParts)
    if (parities.has(part) && (x.odd || part.x == Parity::even) && (y.odd || part.y == Parity::even))
      parts.push_back(part);
  return parts;
}

template <class S>
SpectralEngine<S>::SpectralEngine(const AxisTransform& x, const AxisTransform& y, Lines lines, fft::Rigor rigor)
    : x_(x, true, rigor), y_(y, false, rigor), lines_(lines) {
  assert(x.frequency.basis == Basis::fourier ? !y.odd : y.frequency.basis == Basis::cosine);
}

template <class S>
OtfBlocks<S> SpectralEngine<S>::make_blocks(const Parities& parities) const {
  const std::vector<OtfPart> parts = otf_parts(x(), y(), parities);
  const auto rows = static_cast<std::int64_t>(otf_frequencies(y()).size());
  const auto count = static_cast<std::int64_t>(parts.size()) * blocks() * rows * kRow;
  return {!parities.is_real() && x().frequency.basis == Basis::fourier, parts, blocks(), rows,
          BufferPool::Loan<S>(pool_, static_cast<std::size_t>(count))};
}

template <class S>
double SpectralEngine<S>::otf_scale() const {
  return 1.0 / (static_cast<double>(x().frequency.length) * static_cast<double>(y().frequency.length));
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
  const std::int64_t numbers = planes * channels * blocks() * block_rows(std::max(y().samples, y().outputs)) +
                               std::int64_t{std::max(threads, 1)} * rows;
  return numbers * kRow * static_cast<std::int64_t>(sizeof(S));
}

template <class S>
void SpectralEngine<S>::run(const std::vector<Channel>& channels, const OtfBlocks<S>& otf, int threads) const {
  std::vector<BufferPool::Loan<S>> loans;
  const auto buffers = [&](std::int64_t lines) {
    const auto buffer = [&] {
      loans.emplace_back(pool_, static_cast<std::size_t>(blocks() * block_rows(lines) * kRow));
      return loans.back().data();
    };
    S* even = buffer();
    return Buffers{even, x().odd ? buffer() : nullptr, block_rows(lines)};
  };
  std::vector<Plane> planes;
  for (const Channel& channel : channels) {
    const bool known = channel.kept != nullptr && channel.kept->spectrum.key == key_of(channel);
    planes.push_back(known ? recall(channel, buffers(y().outputs))
                           : read(channel, buffers(std::max(y().samples, y().outputs)), threads));
    Plane& plane = planes.back();
    const auto any = [&](Parity along_x) {
      return std::any_of(otf.parts.begin(), otf.parts.end(), [&](const OtfPart& part) { return part.x == along_x; });
    };
    plane.even = any(Parity::even);
    plane.odd = any(Parity::odd);
    if (channel.allowance > 0.0) plane.over_uniform = groups_over_uniform(plane.input, x(), y());
    plane.energies.resize(plane.over_uniform.size() * static_cast<std::size_t>(blocks()));
  }
  columns(planes, otf, threads);
  for (const Channel& channel : channels)  // whose spectra are complete; after an exception nothing is kept
    if (channel.kept != nullptr) channel.kept->spectrum.key = key_of(channel);
  for (const Plane& plane : planes) lines_inverse(plane, threads);
}

template <class S>
auto SpectralEngine<S>::recall(const Channel& channel, const Buffers& buffers) const -> Plane {
  const KeptSpectrum& kept = channel.kept->spectrum;
  Plane plane{channel, buffers, kept.input, kept.std, reinterpret_cast<S*>(kept.numbers.data()), true};
  plane.channel.mean = kept.mean;
  plane.channel.scale = kept.scale;
  return plane;
}

template <class S>
auto SpectralEngine<S>::read(const Channel& channel, const Buffers& buffers, int threads) const -> Plane {
  Plane plane{channel, buffers, input_groups(channel, lines_, x(), y(), threads)};
  const std::int64_t samples = x().samples * y().samples;
  kernels::Moments all = lines_forward(plane, threads);
  if (channel.sampled && !is_near(all, samples)) {
    plane.channel = recentred(channel, x().border, threads);
    all = lines_forward(plane, threads);
  }
  plane.std = std_of(all, samples);
  if (!plane.input.uniform.empty()) plane.canvas = canvas_without_uniform(plane.input);
  if (channel.kept != nullptr) {
    KeptSpectrum& kept = channel.kept->spectrum;
    const auto bytes = static_cast<std::size_t>(blocks() * y().frequency.length * kRow) * sizeof(S);
    kept.key = {};
    if (kept.numbers.size() != bytes) {
      kept.numbers = {};  // given back before others are taken
      kept.numbers = AlignedBuffer<std::byte>(bytes);
    }
    kept.mean = plane.channel.mean;
    kept.scale = plane.channel.scale;
    kept.std = plane.std;
    kept.input = plane.input;
    plane.spectrum = reinterpret_cast<S*>(kept.numbers.data());
  }
  return plane;
}

// A cosine coefficient is a row of 2 x kLanes lines: a tile of kLanes frequencies fills half the width of a block. A
// complex one is two rows, of the first and the last kLanes lines, and its real and imaginary parts fill both halves.
template <class S>
void SpectralEngine<S>::for_tiles(auto* coefficients, auto* buffer, std::int64_t rows, std::int64_t first_row,
                                  const auto& tile) const {
  const bool pairs = x_.rows_per_coefficient() == 2;
  for (std::int64_t b = 0; b < blocks(); ++b)
    for (int half = 0; half < 2; ++half)
      for (int lines = 0; lines < 2; ++lines) {
        auto* from = coefficients + b * kRow * kRow;
        from += pairs ? lines * kRow + half * kLanes : half * kLanes * kRow + lines * kLanes;
        tile(from, buffer + (b * rows + first_row + lines * kLanes) * kRow + half * kLanes);
      }
}

// Samples of lines begin .. end - 1 about the mean, a line a lane; lines that are missing are zeros.
template <class S>
kernels::Moments SpectralEngine<S>::load(const Channel& channel, std::int64_t begin, std::int64_t end,
                                         S* samples) const {
  const std::int64_t n = x().samples;
  if (lines_ == Lines::columns) {
    kernels::center_columns(channel.in.data + begin, channel.in.stride, n, end - begin, channel.mean, channel.scale,
                            samples);
    kernels::MomentSums all;
    kernels::add(samples, n * kRow, all);
    return all.total();
  }
  const std::int64_t stride = line_stride();
  const BufferPool::Loan<S> lines(pool_, static_cast<std::size_t>(kRow * stride));
  kernels::MomentSums all;
  for (std::int64_t i = 0; i < kRow; ++i) {
    S* line = lines.data() + i * stride;
    if (begin + i < end) {
      kernels::center(channel.in.row(begin + i), n, channel.mean, channel.scale, line);
      kernels::add(line, n, all);
    } else {
      std::fill_n(line, n, S(0));
    }
  }
  lanes::lines_to_lanes(lines.data(), stride, n, samples);
  return all.total();
}

template <class S>
void SpectralEngine<S>::store(const Channel& channel, std::int64_t begin, std::int64_t end, const S* samples) const {
  const double unscale = 1.0 / channel.scale, mean = channel.out_mean();
  if (lines_ == Lines::columns) {
    if (!channel.take)
      return kernels::restore_columns(samples, x_.out_rows(), end - begin, mean, unscale, channel.out.stride,
                                      channel.out.data + begin);
    const BufferPool::Loan<float> columns(pool_, static_cast<std::size_t>(x().outputs * kRow));
    kernels::restore_columns(samples, x_.out_rows(), end - begin, mean, unscale, kRow, columns.data());
    for (std::int64_t y = 0; y < x().outputs; ++y)
      channel.take(y, begin, {columns.data() + y * kRow, static_cast<std::size_t>(end - begin)});
    return;
  }
  const std::int64_t stride = line_stride();
  const BufferPool::Loan<S> lines(pool_, static_cast<std::size_t>(kRow * stride));
  lanes::lanes_to_lines<S>(samples, x_.out_rows(), lines.data(), stride);
  std::optional<BufferPool::Loan<float>> row;
  if (channel.take) row.emplace(pool_, static_cast<std::size_t>(x().outputs));
  for (std::int64_t i = begin; i < end; ++i) {
    float* const to = row ? row->data() : channel.out.row(i);
    kernels::restore(lines.data() + (i - begin) * stride, x().outputs, mean, unscale, to);
    if (row) channel.take(i, 0, {to, static_cast<std::size_t>(x().outputs)});
  }
}

template <class S>
kernels::Moments SpectralEngine<S>::lines_forward(const Plane& plane, int threads) const {
  const Channel& channel = plane.channel;
  const std::int64_t used = x().keep * x_.rows_per_coefficient();
  const auto moments_of = [&](std::int64_t group) {
    const std::int64_t begin = group * kRow, end = std::min(begin + kRow, y().samples);
    const BufferPool::Loan<S> samples(pool_, static_cast<std::size_t>((x().samples + 1) * kRow)),
        work(pool_, static_cast<std::size_t>(x_.rows() * kRow)),
        coefficients(pool_, static_cast<std::size_t>(coefficient_rows() * kRow));
    const kernels::Moments moments = load(channel, begin, end, samples.data());
    std::fill_n(samples.data() + x().samples * kRow, kRow, border_sample(channel));
    x_.forward(samples.data(), x_.canvas(), work.data());
    x_.coefficients(work.data(), coefficients.data());
    std::fill_n(coefficients.data() + used * kRow, (coefficient_rows() - used) * kRow, S(0));
    const std::int64_t step = kRow * x_.rows_per_coefficient();
    for_tiles(coefficients.data(), plane.buffers.even, plane.buffers.rows, begin,
              [&](const S* from, S* to) { lanes::transpose(from, step, to, kRow); });
    return moments;
  };
  const std::vector<std::int64_t>& groups = plane.input.transformed;
  std::vector<kernels::Moments> moments(groups.size());
  for_groups(groups, threads, [&](std::int64_t group, std::size_t i) { moments[i] = moments_of(group); });
  kernels::Moments all;
  for (const kernels::Moments& group : moments) all += group;
  for (const std::int64_t group : plane.input.uniform)
    all += uniform_forward(plane, group * kRow, std::min((group + 1) * kRow, y().samples));
  return all;
}

// A uniform line has one coefficient, in the first block. The others are not read (canvas_without_uniform).
template <class S>
kernels::Moments SpectralEngine<S>::uniform_forward(const Plane& plane, std::int64_t begin, std::int64_t end) const {
  const Channel& channel = plane.channel;
  const double n = static_cast<double>(x().samples);
  S* coefficients = plane.buffers.even + begin * kRow;
  std::fill_n(coefficients, kRow * kRow, S(0));
  kernels::Moments all;
  for (std::int64_t k = begin; k < end; ++k, coefficients += kRow) {
    const float sample = lines_ == Lines::rows ? channel.in.at(0, k) : channel.in.at(k, 0);
    // Squared in S as samples are, so that what is too large for S shows.
    const S value = static_cast<S>((sample - channel.mean) * channel.scale);
    all += {n * static_cast<double>(value), n * static_cast<double>(value * value)};
    *coefficients = value * static_cast<S>(x().frequency.length);
  }
  return all;
}

// In all blocks but the first, uniform lines are zeros, as the row of a constant border is that stands after the lines.
template <class S>
std::vector<std::int32_t> SpectralEngine<S>::canvas_without_uniform(const LineGroups& input) const {
  std::vector<std::int32_t> canvas(y_.canvas().begin(), y_.canvas().end());
  for (std::int32_t& line : canvas)
    if (line < y().samples && std::binary_search(input.uniform.begin(), input.uniform.end(), line / kRow))
      line = static_cast<std::int32_t>(y().samples);
  return canvas;
}

template <class S>
void SpectralEngine<S>::columns(std::vector<Plane>& planes, const OtfBlocks<S>& otf, int threads) const {
  parallel_for(blocks(), 1, threads, [&](std::int64_t b, std::int64_t) {
    const auto area = static_cast<std::size_t>(y_.rows() * kRow);
    const BufferPool::Loan<S> work(pool_, area), target(pool_, area);
    std::optional<BufferPool::Loan<S>> other;
    if (otf.parts.size() > 1) other.emplace(pool_, area);
    for (Plane& plane : planes) {
      if (plane.spectrum != nullptr)
        column_block(plane, otf, b, {plane.spectrum + b * y().frequency.length * kRow, target.data(), work.data()});
      else
        column_block(plane, otf, b, {work.data(), target.data(), other ? other->data() : nullptr});
      add_energies(plane, b);
    }
  });
}

template <class S>
void SpectralEngine<S>::column_block(const Plane& plane, const OtfBlocks<S>& otf, std::int64_t block,
                                     const std::array<S*, 3>& areas) const {
  const auto [spectrum, target, other] = areas;
  const Buffers buffers = plane.buffers.of_block(block);
  if (!plane.known) {
    // A row of a constant border has one coefficient only: that of frequency zero.
    S* const border_row = buffers.even + y().samples * kRow;
    std::fill_n(border_row, kRow, S(0));
    if (block == 0) border_row[0] = border_sample(plane.channel) * static_cast<S>(x().frequency.length);
    y_.forward(buffers.even, block == 0 || plane.canvas.empty() ? y_.canvas() : plane.canvas, spectrum);
  }
  for (std::size_t p = 0; p < otf.parts.size(); ++p) {
    const auto [along_x, along_y] = otf.parts[p];
    const bool last = p + 1 == otf.parts.size(), more = p > 0 && otf.parts[p - 1].x == along_x;
    S* const work = last && plane.spectrum == nullptr ? spectrum : other;  // what is kept is not worked in
    const S* samples = y_.inverse(along_y, spectrum, otf.row(p, block, 0), otf.complex, target, work);
    S* to = along_x == Parity::even ? buffers.even : buffers.odd;
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

// Sums of the squares of a block's coefficients but the zeroth ones, while the block is in the cache.
template <class S>
void SpectralEngine<S>::add_energies(Plane& plane, std::int64_t block) const {
  const Buffers buffers = plane.buffers.of_block(block);
  for (std::size_t i = 0; i < plane.over_uniform.size(); ++i) {
    const std::int64_t begin = plane.over_uniform[i] * kRow, end = std::min(begin + kRow, y().outputs);
    double& energy = plane.energies[i * static_cast<std::size_t>(blocks()) + static_cast<std::size_t>(block)];
    for (const S* rows : {plane.even ? buffers.even : nullptr, plane.odd ? buffers.odd : nullptr}) {
      if (rows == nullptr) continue;
      std::array<S, kRow> squares{};
      for (const S* row = rows + begin * kRow; row < rows + end * kRow; row += kRow)
        for (std::size_t l = 0; l < kRow; ++l) squares[l] += row[l] * row[l];
      energy += std::accumulate(squares.begin() + (block == 0 && rows == buffers.even ? 1 : 0), squares.end(), 0.0);
    }
  }
}

template <class S>
LineGroups SpectralEngine<S>::output_of(const Plane& plane) const {
  std::vector<double> energies;
  for (auto first = plane.energies.begin(); first != plane.energies.end(); first += blocks())
    energies.push_back(std::accumulate(first, first + blocks(), 0.0));
  return output_groups(plane.over_uniform, energies, plane.channel.allowance * plane.std, x(), y());
}

template <class S>
void SpectralEngine<S>::lines_inverse(const Plane& plane, int threads) const {
  const Channel& channel = plane.channel;
  const Buffers& buffers = plane.buffers;
  const std::int64_t step = kRow * x_.rows_per_coefficient();
  const auto transform = [&](std::int64_t group) {
    const std::int64_t begin = group * kRow;
    const auto area = static_cast<std::size_t>(x_.rows() * kRow);
    const BufferPool::Loan<S> work(pool_, area), target(pool_, area),
        coefficients(pool_, static_cast<std::size_t>(coefficient_rows() * kRow));
    const auto samples_of = [&](Parity parity, const S* buffer, S* a, S* b) {
      for_tiles(coefficients.data(), buffer, buffers.rows, begin,
                [&](S* to, const S* from) { lanes::transpose(from, kRow, to, step); });
      return x_.inverse(parity, coefficients.data(), nullptr, false, a, b);
    };
    S* samples = plane.even ? samples_of(Parity::even, buffers.even, target.data(), work.data())
                            : samples_of(Parity::odd, buffers.odd, target.data(), work.data());
    if (plane.even && plane.odd) {
      const BufferPool::Loan<S> other(pool_, area);
      S* spare = samples == work.data() ? target.data() : work.data();
      add(samples_of(Parity::odd, buffers.odd, spare, other.data()), inverse_length(x()) * kRow, samples);
    }
    store(channel, begin, std::min(begin + kRow, y().outputs), samples);
  };
  const LineGroups output = output_of(plane);
  uniform_inverse(plane, output.uniform, threads);
  for_groups(output.transformed, threads, [&](std::int64_t group, std::size_t) { transform(group); });
}

// Groups of lines that come out uniform: the zeroth coefficient is their value.
template <class S>
void SpectralEngine<S>::uniform_inverse(const Plane& plane, const std::vector<std::int64_t>& groups,
                                        int threads) const {
  const Channel& channel = plane.channel;
  std::vector<float> values(static_cast<std::size_t>(y().outputs));
  for (std::int64_t k = 0; k < y().outputs; ++k)
    values[static_cast<std::size_t>(k)] = static_cast<float>(
        (plane.even ? static_cast<double>(plane.buffers.even[k * kRow]) / channel.scale : 0.0) + channel.out_mean());
  if (lines_ == Lines::rows) {
    for_groups(groups, threads, [&](std::int64_t group, std::size_t) {
      for (std::int64_t k = group * kRow; k < std::min((group + 1) * kRow, y().outputs); ++k)
        if (channel.take) {
          const std::vector<float> row(static_cast<std::size_t>(x().outputs), values[static_cast<std::size_t>(k)]);
          channel.take(k, 0, row);
        } else {
          std::fill_n(channel.out.row(k), x().outputs, values[static_cast<std::size_t>(k)]);
        }
    });
    return;
  }
  parallel_for_each(x().outputs, kRow, threads, [&](std::int64_t i) {
    for (const std::int64_t group : groups) {
      const std::span<const float> here =
          std::span(values).subspan(static_cast<std::size_t>(group * kRow),
                                    static_cast<std::size_t>(std::min<std::int64_t>(kRow, y().outputs - group * kRow)));
      if (channel.take)
        channel.take(i, group * kRow, here);
      else
        std::copy(here.begin(), here.end(), channel.out.row(i) + group * kRow);
    }
  });
}

template class SpectralEngine<float>;
template class SpectralEngine<double>;

}  // namespace mtf
