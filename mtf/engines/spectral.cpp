// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/spectral.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "mtf/engines/kernels.h"
#include "mtf/parallel.h"
#include "mtf/special.h"

namespace mtf {
namespace {

constexpr std::int64_t kRowChunk = 16, kRowGroup = 4;

// FFTW's arrays all start on a cache line.
constexpr std::int64_t aligned(std::int64_t floats) { return (floats + 15) & ~std::int64_t{15}; }

void copy_row(float* to, const float* from) { std::memcpy(to, from, kRowFloats * sizeof(float)); }

std::vector<float> cosine_twiddles(std::int64_t n) {
  std::vector<float> t(2 * static_cast<std::size_t>(n));
  for (std::int64_t k = 0; k < n; ++k) {
    const double half_turns = static_cast<double>(k) / (2.0 * static_cast<double>(n));
    t[2 * static_cast<std::size_t>(k)] = static_cast<float>(cos_pi(half_turns));
    t[2 * static_cast<std::size_t>(k) + 1] = static_cast<float>(-sin_pi(half_turns));
  }
  return t;
}

// Canvas position -> image sample. The right continuation stands behind the image, the left one at the end of the
// canvas.
std::vector<std::int32_t> canvas_sources(const AxisJob& job) {
  const std::int64_t length = job.frequency.length, n = job.samples;
  std::vector<std::int32_t> source(static_cast<std::size_t>(length));
  const std::int64_t right = n + (length - n + 1) / 2;
  for (std::int64_t i = 0; i < length; ++i)
    source[static_cast<std::size_t>(i)] =
        static_cast<std::int32_t>(border_source(job.border, i < right ? i : i - length, n));
  return source;
}

}  // namespace

SpectralEngine::SpectralEngine(const AxisJob& x, const AxisJob& y, fft::Rigor rigor)
    : x_(x), y_(y), x_terms_(column_terms(x)), y_terms_(column_terms(y)) {
  assert(x.frequency.basis == Basis::fourier || y.frequency.basis == Basis::cosine);
  const bool x_cosine = x.frequency.basis == Basis::cosine, y_cosine = y.frequency.basis == Basis::cosine;
  for (const Term& term : x_terms_) x_folds_ = x_folds_ || term.target != term.source || term.re != 1.0F;
  x_forward_ = fft::RealForward(x.frequency.length, rigor);
  y_forward_ = fft::Lanes(y.frequency.length, kLanes, true, rigor);
  if (x_cosine) x_twiddles_ = cosine_twiddles(x.frequency.length);
  if (y_cosine) y_twiddles_ = cosine_twiddles(y.frequency.length);
  if (!x_cosine) x_source_ = canvas_sources(x);
  if (!y_cosine) y_source_ = canvas_sources(y);
  if (x.resampling == Resampling::chirp) {
    x_chirp_ = Chirp(x, 1, rigor);
  } else {
    x_inverse_ = fft::RealInverse(x.out_length, rigor);
    if (x_cosine) x_out_twiddles_ = cosine_twiddles(x.out_length);
  }
  if (y.resampling == Resampling::chirp) {
    y_chirp_ = Chirp(y, kLanes, rigor);
  } else {
    y_inverse_ = fft::Lanes(y.out_length, kLanes, false, rigor);
    if (y_cosine) y_out_twiddles_ = cosine_twiddles(y.out_length);
  }
}

std::int64_t SpectralEngine::columns_per_block() const {
  return x_.frequency.basis == Basis::cosine ? kRowFloats : kLanes;
}

std::int64_t SpectralEngine::blocks() const { return (x_.keep + columns_per_block() - 1) / columns_per_block(); }

double SpectralEngine::otf_scale() const {
  return 1.0 / (static_cast<double>(x_.frequency.length) * static_cast<double>(y_.frequency.length));
}

std::int64_t SpectralEngine::block_rows() const {
  // An odd number of cache lines keeps the blocks of one row out of the same cache sets.
  return std::max(y_.samples, y_.outputs) | 1;
}

std::int64_t SpectralEngine::work_rows() const { return std::max(y_.frequency.length, inverse_length(y_)); }

std::int64_t SpectralEngine::run_bytes(std::int64_t channels, int threads) const {
  const std::int64_t buffers = channels * blocks() * block_rows() * kRowFloats * 4;
  return buffers + std::int64_t{std::max(threads, 1)} * 2 * work_rows() * kRowFloats * 4;
}

void SpectralEngine::run(const std::vector<Channel>& channels, const OtfBlocks& otf, int threads) const {
  std::vector<AlignedBuffer<float>> buffers;
  for (const Channel& channel : channels) {
    buffers.emplace_back(static_cast<std::size_t>(blocks() * block_rows() * kRowFloats));
    rows_forward(channel, buffers.back().data(), threads);
  }
  columns(channels, buffers, otf, threads);
  for (std::size_t c = 0; c < channels.size(); ++c) rows_inverse(channels[c], buffers[c].data(), threads);
}

void SpectralEngine::rows_forward(const Channel& channel, float* buffer, int threads) const {
  const std::int64_t n = x_.samples, length = x_.frequency.length, count = blocks();
  const bool cosine = x_.frequency.basis == Basis::cosine;
  const float level = static_cast<float>((channel.border_value - channel.mean) * channel.scale);
  // Coefficients of a few rows are collected, so that each block is written several cache lines at a time.
  const std::int64_t stride = aligned(std::max(count * kRowFloats, length + 2));
  parallel_for(y_.samples, kRowChunk, threads, [&](std::int64_t begin, std::int64_t end) {
    const AlignedBuffer<float> ordered(static_cast<std::size_t>(length)), half(static_cast<std::size_t>(length + 2));
    const AlignedBuffer<float> rows(static_cast<std::size_t>(kRowGroup * stride));
    std::fill_n(rows.data(), rows.size(), 0.0F);
    for (std::int64_t first = begin; first < end; first += kRowGroup) {
      const std::int64_t group = std::min(kRowGroup, end - first);
      for (std::int64_t g = 0; g < group; ++g) {
        const float* in = channel.in.row(first + g);
        float* coefficients = rows.data() + g * stride;
        if (cosine) {
          kernels::center_ordered(in, n, channel.mean, channel.scale, ordered.data());
          x_forward_.execute(ordered.data(), half.data());
          kernels::cosine_from_half(half.data(), x_twiddles_.data(), n, coefficients);
          continue;
        }
        kernels::center(in, n, channel.mean, channel.scale, ordered.data());
        for (std::int64_t i = n; i < length; ++i) {
          const std::int32_t source = x_source_[static_cast<std::size_t>(i)];
          ordered[static_cast<std::size_t>(i)] = source < 0 ? level : ordered[static_cast<std::size_t>(source)];
        }
        x_forward_.execute(ordered.data(), coefficients);
      }
      for (std::int64_t b = 0; b < count; ++b)
        for (std::int64_t g = 0; g < group; ++g)
          copy_row(buffer + (b * block_rows() + first + g) * kRowFloats, rows.data() + g * stride + b * kRowFloats);
    }
  });
}

void SpectralEngine::columns(const std::vector<Channel>& channels, const std::vector<AlignedBuffer<float>>& buffers,
                             const OtfBlocks& otf, int threads) const {
  parallel_for(blocks(), 1, threads, [&](std::int64_t begin, std::int64_t end) {
    const auto scratch = static_cast<std::size_t>(work_rows() * kRowFloats);
    const AlignedBuffer<float> work(scratch), target(scratch);
    for (std::int64_t b = begin; b < end; ++b)
      for (std::size_t c = 0; c < channels.size(); ++c)
        column_block(channels[c], otf, b, buffers[c].data() + b * block_rows() * kRowFloats, work.data(),
                     target.data());
  });
}

// One block of columns with its border: in Makhoul's order for the cosine basis, as a whole canvas else.
void SpectralEngine::load_columns(const Channel& channel, std::int64_t block, const float* data, float* work) const {
  const std::int64_t n = y_.samples;
  if (y_.frequency.basis == Basis::cosine) {
    for (std::int64_t i = 0; i < (n + 1) / 2; ++i) copy_row(work + i * kRowFloats, data + 2 * i * kRowFloats);
    for (std::int64_t i = 0; i < n / 2; ++i) copy_row(work + (n - 1 - i) * kRowFloats, data + (2 * i + 1) * kRowFloats);
    return;
  }
  // A row of the constant level has one coefficient only: that of frequency zero.
  alignas(64) float level_row[kRowFloats] = {};
  if (block == 0)
    level_row[0] = static_cast<float>((channel.border_value - channel.mean) * channel.scale *
                                      static_cast<double>(x_.frequency.length));
  std::memcpy(work, data, static_cast<std::size_t>(n) * kRowFloats * sizeof(float));
  for (std::int64_t i = n; i < y_.frequency.length; ++i) {
    const std::int32_t source = y_source_[static_cast<std::size_t>(i)];
    copy_row(work + i * kRowFloats, source < 0 ? level_row : data + std::int64_t{source} * kRowFloats);
  }
}

void SpectralEngine::column_block(const Channel& channel, const OtfBlocks& otf, std::int64_t block, float* data,
                                  float* work, float* target) const {
  const bool cosine = y_.frequency.basis == Basis::cosine;
  load_columns(channel, block, data, work);
  y_forward_.execute(work);
  const std::int64_t target_rows = inverse_length(y_);
  if (cosine)
    kernels::spread_cosine(work, otf.row(block, 0), otf.complex, y_terms_, y_twiddles_.data(), y_.samples, target,
                           target_rows);
  else
    kernels::spread_fourier(work, otf.row(block, 0), otf.complex, y_terms_, target, target_rows);

  if (y_.resampling == Resampling::fold && cosine) {
    const std::int64_t m = y_.out_length;
    kernels::unfold_cosine(target, y_out_twiddles_.data(), m, work);
    y_inverse_.execute(work);
    for (std::int64_t i = 0; 2 * i < y_.outputs; ++i) copy_row(data + 2 * i * kRowFloats, work + i * kRowFloats);
    for (std::int64_t i = 0; 2 * i + 1 < y_.outputs; ++i)
      copy_row(data + (2 * i + 1) * kRowFloats, work + (m - 1 - i) * kRowFloats);
    return;
  }
  if (y_.resampling == Resampling::chirp)
    y_chirp_.run(target);
  else
    y_inverse_.execute(target);
  std::memcpy(data, target, static_cast<std::size_t>(y_.outputs) * kRowFloats * sizeof(float));
}

void SpectralEngine::rows_inverse(const Channel& channel, const float* buffer, int threads) const {
  const std::int64_t count = blocks(), stride = aligned(std::max(count * kRowFloats, inverse_length(x_)));
  parallel_for(y_.outputs, kRowChunk, threads, [&](std::int64_t begin, std::int64_t end) {
    const AlignedBuffer<float> rows(static_cast<std::size_t>(kRowGroup * stride));
    const AlignedBuffer<float> work(static_cast<std::size_t>(3 * aligned(2 * inverse_length(x_) + 2)));
    std::fill_n(rows.data(), rows.size(), 0.0F);
    for (std::int64_t first = begin; first < end; first += kRowGroup) {
      const std::int64_t group = std::min(kRowGroup, end - first);
      for (std::int64_t b = 0; b < count; ++b)
        for (std::int64_t g = 0; g < group; ++g)
          copy_row(rows.data() + g * stride + b * kRowFloats, buffer + (b * block_rows() + first + g) * kRowFloats);
      for (std::int64_t g = 0; g < group; ++g)
        row_from_coefficients(channel, rows.data() + g * stride, work.data(), channel.out.row(first + g));
    }
  });
}

void SpectralEngine::row_from_coefficients(const Channel& channel, const float* c, float* work, float* out) const {
  const bool cosine = x_.frequency.basis == Basis::cosine;
  const std::int64_t m = inverse_length(x_);
  const double unscale = 1.0 / channel.scale;
  float* folded = work;
  float* samples = work + aligned(2 * m + 2);
  float* half = samples + aligned(2 * m + 2);
  if (x_.resampling == Resampling::chirp) {
    std::fill_n(folded, 2 * m, 0.0F);
    for (const Term& term : x_terms_) {
      const std::int64_t k = std::abs(term.k);
      const float re = cosine ? c[k] : c[2 * k];
      const float im = cosine ? 0.0F : (term.k < 0 ? -c[2 * k + 1] : c[2 * k + 1]);
      folded[2 * term.target] = re * term.re - im * term.im;
      folded[2 * term.target + 1] = re * term.im + im * term.re;
    }
    x_chirp_.run(folded);
    for (std::int64_t j = 0; j < x_.outputs; ++j) samples[j] = folded[2 * j];
    kernels::restore(samples, x_.outputs, channel.out_mean, unscale, out);
    return;
  }
  if (cosine) {
    if (x_folds_) {
      std::fill_n(folded, m, 0.0F);
      for (const Term& term : x_terms_) folded[term.target] += term.re * c[term.source];
    }
    kernels::half_from_cosine(x_folds_ ? folded : c, x_out_twiddles_.data(), m, half);
    x_inverse_.execute(half, samples);
    kernels::restore_ordered(samples, m, x_.outputs, channel.out_mean, unscale, out);
    return;
  }
  // Half spectrum of the detector row: a term of frequency k, or its mirror, lands in bins 0 .. m/2.
  std::fill_n(half, m + 2, 0.0F);
  for (const Term& term : x_terms_) {
    if (2 * std::int64_t{term.target} > m) continue;  // given by the mirrored term
    const std::int64_t k = std::abs(term.k);
    const float re = c[2 * k], im = term.k < 0 ? -c[2 * k + 1] : c[2 * k + 1];
    half[2 * term.target] += re * term.re - im * term.im;
    half[2 * term.target + 1] += re * term.im + im * term.re;
  }
  x_inverse_.execute(half, samples);
  kernels::restore(samples, x_.outputs, channel.out_mean, unscale, out);
}

}  // namespace mtf
