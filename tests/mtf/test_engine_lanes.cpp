// SPDX-License-Identifier: Apache-2.0
// Transforms and loops on rows of lanes, against the sums that they stand for.
#include "mtf/engines/fft/batched_fft.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

#include "mtf/engines/fft/lane_kernels.h"
#include "mtf/grid.h"
#include "mtf/image.h"

namespace mtf::test {
namespace {

using L = std::complex<long double>;

template <class S>
AlignedBuffer<S> random_rows(std::int64_t rows, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  AlignedBuffer<S> data(static_cast<std::size_t>(rows * kRow));
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<S>(normal(generator));
  return data;
}

template <class S>
L at(const AlignedBuffer<S>& data, std::int64_t row, std::int64_t lane) {
  const auto i = static_cast<std::size_t>(row * kRow + lane);
  return {data[i], data[i + kLanes]};
}

// rms error of forward, and of forward and inverse, relative to the data and in units of the last place.
template <class S>
double transform_error(std::int64_t n, std::int64_t step) {
  const AlignedBuffer<S> in = random_rows<S>(n, 3), data = random_rows<S>(n, 3);
  const BatchedFft<S> transform(n, fft::Rigor::estimate);
  transform.forward(data.data());
  std::vector<L> roots(static_cast<std::size_t>(n));
  for (std::int64_t j = 0; j < n; ++j)
    roots[static_cast<std::size_t>(j)] = std::polar(
        1.0L, -2.0L * 3.14159265358979323846264L * static_cast<long double>(j) / static_cast<long double>(n));
  long double squares = 0.0L, energy = 0.0L;
  for (const std::int64_t lane : {std::int64_t{0}, std::int64_t{7}, std::int64_t{kLanes - 1}})
    for (std::int64_t k = 0; k < n; k += step) {
      L sum = 0.0L;
      for (std::int64_t j = 0; j < n; ++j) sum += at(in, j, lane) * roots[static_cast<std::size_t>(j * k % n)];
      squares += std::norm(at(data, transform.place(k), lane) - sum);
      energy += std::norm(sum);
    }
  transform.inverse(data.data());
  long double back = 0.0L, whole = 0.0L;
  for (std::int64_t j = 0; j < n; ++j)
    for (std::int64_t lane = 0; lane < kLanes; ++lane) {
      back += std::norm(at(data, j, lane) / static_cast<long double>(n) - at(in, j, lane));
      whole += std::norm(at(in, j, lane));
    }
  const long double unit = std::numeric_limits<S>::epsilon() / 2;
  return static_cast<double>(std::sqrt(std::max(squares / energy, back / whole)) / unit);
}

template <class S>
class EngineLanes : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(EngineLanes, Scalars);

// Plans count on 0.5 units a doubling and axis, and two for the ends (mtf/plan/plan_choice.cpp); lengths with large
// primes are FFTW's.
TYPED_TEST(EngineLanes, every_length_is_a_fourier_transform_and_rounds_less_than_plans_count_on) {
  for (std::int64_t n = 1; n <= 200; ++n) {
    const double doublings = std::log2(1.0 + static_cast<double>(n));
    ASSERT_LT(transform_error<TypeParam>(n, 1), (is_smooth(n) ? 0.5 : 1.0) * doublings + 1.0) << n;
  }
  for (const std::int64_t n : {512, 729, 1001, 1014, 1024, 1280, 2000, 2401, 3125, 4096, 6561})
    ASSERT_LT(transform_error<TypeParam>(n, 97), 0.45 * std::log2(static_cast<double>(n))) << n;
}

TYPED_TEST(EngineLanes, lanes_do_not_see_one_another) {
  for (const std::int64_t n : {1, 60, 77, 512}) {
    const AlignedBuffer<TypeParam> data = random_rows<TypeParam>(n, 1), other = random_rows<TypeParam>(n, 1);
    for (std::int64_t j = 0; j < n; ++j)
      for (std::int64_t lane = 0; lane < kRow; ++lane)
        if (lane % kLanes != 5) other[static_cast<std::size_t>(j * kRow + lane)] = TypeParam(-3);
    const BatchedFft<TypeParam> transform(n, fft::Rigor::estimate);
    transform.forward(data.data());
    transform.forward(other.data());
    for (std::int64_t j = 0; j < n; ++j) ASSERT_EQ(at(data, j, 5), at(other, j, 5)) << n << " " << j;
  }
}

TYPED_TEST(EngineLanes, rows_are_gathered_from_anywhere) {
  for (const std::int64_t n : {1, 2, 16, 17, 60, 512, 1280}) {
    const AlignedBuffer<TypeParam> from = random_rows<TypeParam>(7, 1), gathered = random_rows<TypeParam>(n, 2),
                                   expected = random_rows<TypeParam>(n, 3);
    std::vector<std::int32_t> rows;
    for (std::int64_t i = 0; i < n; ++i) {
      rows.push_back(static_cast<std::int32_t>(i * i % 7));
      std::copy_n(from.data() + rows.back() * kRow, kRow, expected.data() + i * kRow);
    }
    const BatchedFft<TypeParam> transform(n, fft::Rigor::estimate);
    transform.forward(from.data(), rows, gathered.data());
    transform.forward(expected.data());
    for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(gathered[i], expected[i]) << n;
  }
}

TYPED_TEST(EngineLanes, a_square_is_transposed) {
  const AlignedBuffer<TypeParam> from = random_rows<TypeParam>(3 * kLanes, 2), to = random_rows<TypeParam>(kLanes, 3);
  lanes::transpose(from.data(), 3 * kRow, to.data(), kRow);
  for (std::size_t i = 0; i < kLanes; ++i)
    for (std::size_t j = 0; j < kLanes; ++j) ASSERT_EQ(to[j * kRow + i], from[i * 3 * kRow + j]);
}

TYPED_TEST(EngineLanes, lines_become_lanes_and_lines_again) {
  for (const std::int64_t count : {1, 5, 16, 17, 50}) {
    const std::int64_t stride = 80;
    const AlignedBuffer<TypeParam> lines = random_rows<TypeParam>(stride, 4), back = random_rows<TypeParam>(stride, 5),
                                   data = random_rows<TypeParam>(count, 6);
    std::vector<std::int32_t> rows(static_cast<std::size_t>(count));  // any order
    for (std::int64_t i = 0; i < count; ++i)
      rows[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(count - 1 - i);
    lanes::lines_to_lanes(lines.data(), stride, count, data.data());
    lanes::lanes_to_lines<TypeParam>(data.data(), rows, back.data(), stride);
    for (std::int64_t line = 0; line < kRow; ++line)
      for (std::int64_t j = 0; j < count; ++j) {
        ASSERT_EQ(data[static_cast<std::size_t>(j * kRow + line)], lines[static_cast<std::size_t>(line * stride + j)]);
        ASSERT_EQ(back[static_cast<std::size_t>(line * stride + count - 1 - j)],
                  lines[static_cast<std::size_t>(line * stride + j)]);
      }
  }
}

TEST(EngineLanesTables, a_length_out_of_range_is_refused) {
  EXPECT_ANY_THROW(BatchedFft<float>(0, fft::Rigor::estimate));
  EXPECT_ANY_THROW(BatchedFft<float>(std::int64_t{1} << 40, fft::Rigor::estimate));
}

}  // namespace
}  // namespace mtf::test
