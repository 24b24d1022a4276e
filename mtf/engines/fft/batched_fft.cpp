// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/batched_fft.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "mtf/error.h"
#include "mtf/math/special.h"

namespace mtf {

using lanes::Pass;
using lanes::run_step;
using lanes::Step;

namespace {

constexpr std::int64_t kNearBytes = 24 << 10;      // of a part that is taken through its remaining steps at once
constexpr std::size_t kKeptTables = 64;            // of the process
constexpr std::int64_t kLongestKept = 1 << 16;     // longer tables are made anew
constexpr std::int64_t kLongest = 0x7fffffff / 2;  // rows are counted in 32 bits

// Few and large radices mean few passes over the data; the largest come first, where the data are farthest. None when n
// has another prime factor.
std::vector<int> radices(std::int64_t n) {
  std::vector<int> list;
  int twos = 0;
  for (; n % 2 == 0; n /= 2) ++twos;
  // 2^5 is 8 x 4 rather than 16 x 2, 2^6 8 x 8 rather than 16 x 4.
  for (; twos >= 7 || twos == 4; twos -= 4) list.push_back(16);
  for (; twos >= 3 && twos != 4; twos -= 3) list.push_back(8);
  if (twos > 0) list.push_back(1 << twos);
  for (const int p : {13, 11, 7, 5, 3})
    for (; n % p == 0; n /= p) list.push_back(p);
  return n == 1 ? list : std::vector<int>{};
}

}  // namespace

bool in_small_steps(std::int64_t n) { return n == 1 || !radices(n).empty(); }

template <class S>
BatchedFft<S>::BatchedFft(std::int64_t n, fft::Rigor rigor) {
  if (n < 1 || n > kLongest) throw UsageError("a transform of length " + std::to_string(n) + " is out of range");
  static std::mutex lock;
  static std::map<std::pair<std::int64_t, fft::Rigor>, std::shared_ptr<const Tables>> kept;
  const std::pair key{n, rigor};
  {
    const std::scoped_lock guard(lock);
    if (const auto found = kept.find(key); found != kept.end()) tables_ = found->second;
  }
  if (tables_) return;
  tables_ = make_tables(n, rigor);
  if (n > kLongestKept) return;
  const std::scoped_lock guard(lock);
  if (kept.size() >= kKeptTables) kept.clear();
  kept.insert_or_assign(key, tables_);
}

template <class S>
auto BatchedFft<S>::make_tables(std::int64_t n, fft::Rigor rigor) -> std::shared_ptr<const Tables> {
  auto tables = std::make_shared<Tables>();
  tables->length = n;
  tables->place.resize(static_cast<std::size_t>(n));
  const std::vector<int> factors = radices(n);
  if (factors.empty() && n > 1) {
    tables->fftw = fft::Split<S>(n, kLanes, rigor);
    for (std::int64_t k = 0; k < n; ++k) tables->place[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(k);
    return tables;
  }
  std::int64_t size = n;
  for (const int radix : factors) {
    Step<S> step{radix, size / radix, {}};
    for (std::int64_t p = 1; p < step.stride; ++p)
      for (int j = 1; j < radix; ++j) {
        const double half_turns = 2.0 * static_cast<double>(p * j % size) / static_cast<double>(size);
        step.twiddles.push_back(static_cast<S>(cos_pi(half_turns)));
        step.twiddles.push_back(static_cast<S>(-sin_pi(half_turns)));
      }
    size = step.stride;
    tables->steps.push_back(std::move(step));
  }
  // A step of radix r puts frequencies k = r q + j into its part j, there at the place of q.
  for (std::int64_t k = 0; k < n; ++k) {
    std::int64_t rest = k, row = 0;
    for (const Step<S>& step : tables->steps) {
      row += rest % step.radix * step.stride;
      rest /= step.radix;
    }
    tables->place[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(row);
  }
  return tables;
}

template <class S>
void BatchedFft<S>::forward_from(std::size_t first, S* data) const {
  const std::vector<Step<S>>& steps = tables_->steps;
  const std::int64_t size = steps[first].radix * steps[first].stride;
  if (size * kRow * static_cast<std::int64_t>(sizeof(S)) <= kNearBytes) {
    for (std::size_t i = first; i < steps.size(); ++i)
      run_step<S, Pass::forward>(steps[i], data, size / (steps[i].radix * steps[i].stride));
    return;
  }
  run_step<S, Pass::forward>(steps[first], data, 1);
  if (first + 1 == steps.size()) return;
  for (int j = 0; j < steps[first].radix; ++j) forward_from(first + 1, data + j * steps[first].stride * kRow);
}

template <class S>
void BatchedFft<S>::inverse_from(std::size_t first, S* data) const {
  const std::vector<Step<S>>& steps = tables_->steps;
  const std::int64_t size = steps[first].radix * steps[first].stride;
  if (size * kRow * static_cast<std::int64_t>(sizeof(S)) <= kNearBytes) {
    for (std::size_t i = steps.size(); i-- > first;)
      run_step<S, Pass::inverse>(steps[i], data, size / (steps[i].radix * steps[i].stride));
    return;
  }
  if (first + 1 < steps.size())
    for (int j = 0; j < steps[first].radix; ++j) inverse_from(first + 1, data + j * steps[first].stride * kRow);
  run_step<S, Pass::inverse>(steps[first], data, 1);
}

template <class S>
void BatchedFft<S>::forward(S* data) const {
  if (!tables_->steps.empty()) return forward_from(0, data);
  if (tables_->length > 1) tables_->fftw.forward(data, data + kLanes);
}

template <class S>
void BatchedFft<S>::forward(const S* from, std::span<const std::int32_t> rows, S* data) const {
  const std::vector<Step<S>>& steps = tables_->steps;
  if (steps.empty()) {
    for (std::size_t n = 0; n < rows.size(); ++n)
      std::copy_n(from + std::int64_t{rows[n]} * kRow, kRow, data + static_cast<std::int64_t>(n) * kRow);
    return forward(data);
  }
  run_step<S, Pass::gather>(steps[0], data, 1, from, rows.data());
  if (steps.size() == 1) return;
  for (int j = 0; j < steps[0].radix; ++j) forward_from(1, data + j * steps[0].stride * kRow);
}

template <class S>
void BatchedFft<S>::inverse(S* data) const {
  if (!tables_->steps.empty()) return inverse_from(0, data);
  if (tables_->length > 1) tables_->fftw.inverse(data, data + kLanes);
}

template class BatchedFft<float>;
template class BatchedFft<double>;

}  // namespace mtf
