// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/fftw.h"

#include <fftw3.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <mutex>

#include "mtf/error.h"

namespace mtf::fft {
namespace {

std::mutex& planner() {
  static std::mutex lock;
  return lock;
}

int checked(std::int64_t n) {
  if (n < 1 || n > std::numeric_limits<int>::max())
    throw UsageError("a transform of length " + std::to_string(n) + " is out of range");
  return static_cast<int>(n);
}

unsigned flags(Rigor rigor) { return rigor == Rigor::measure ? FFTW_MEASURE : FFTW_ESTIMATE; }

fftwf_complex* complexes(float* p) { return reinterpret_cast<fftwf_complex*>(p); }

template <class S>
struct Api;
template <>
struct Api<float> {
  using Plan = fftwf_plan;
  using Dimension = fftwf_iodim;
  static constexpr auto make = fftwf_plan_guru_split_dft;
  static constexpr auto execute = fftwf_execute_split_dft;
  static constexpr auto destroy = fftwf_destroy_plan;
};
template <>
struct Api<double> {
  using Plan = fftw_plan;
  using Dimension = fftw_iodim;
  static constexpr auto make = fftw_plan_guru_split_dft;
  static constexpr auto execute = fftw_execute_split_dft;
  static constexpr auto destroy = fftw_destroy_plan;
};

template <class S>
std::shared_ptr<void> planned(const auto& make) {
  typename Api<S>::Plan plan = nullptr;
  {  // the lock is released before the plan gets its owner, whose deleter takes it again
    const std::scoped_lock lock(planner());
    plan = make();
  }
  if (plan == nullptr) throw RuntimeError("FFTW could not plan a transform");
  return {plan, [](void* p) {
            const std::scoped_lock lock(planner());
            Api<S>::destroy(static_cast<typename Api<S>::Plan>(p));
          }};
}

fftw_complex* complexes(Complex<double>* p) {
  static_assert(sizeof(Complex<double>) == sizeof(fftw_complex));
  return reinterpret_cast<fftw_complex*>(p);
}

// Sign -1 on (re, im).
template <class S>
std::shared_ptr<void> plan_split(int length, int lanes, S* re, S* im, Rigor rigor) {
  const typename Api<S>::Dimension transform{length, 2 * lanes, 2 * lanes}, batch{lanes, 1, 1};
  return planned<S>([&] { return Api<S>::make(1, &transform, 1, &batch, re, im, re, im, flags(rigor)); });
}

template <class S>
void execute_split(const std::shared_ptr<void>& plan, S* re, S* im) {
  Api<S>::execute(static_cast<typename Api<S>::Plan>(plan.get()), re, im, re, im);
}

}  // namespace

// FFTW transforms split data with sign -1 only; sign +1 is the same with re and im exchanged.
template <class S>
Split<S>::Split(std::int64_t n, int lanes, Rigor rigor) {
  const int length = checked(n);
  const AlignedBuffer<S> scratch(2 * static_cast<std::size_t>(n) * static_cast<std::size_t>(lanes));
  forward_ = plan_split(length, lanes, scratch.data(), scratch.data() + lanes, rigor);
  inverse_ = plan_split(length, lanes, scratch.data() + lanes, scratch.data(), rigor);
}

template <class S>
void Split<S>::forward(S* re, S* im) const {
  execute_split(forward_, re, im);
}

template <class S>
void Split<S>::inverse(S* re, S* im) const {
  execute_split(inverse_, im, re);
}

template class Split<float>;
template class Split<double>;

RealForward::RealForward(std::int64_t n, Rigor rigor) {
  const int length = checked(n);
  const AlignedBuffer<float> in(static_cast<std::size_t>(n)), out(static_cast<std::size_t>(n) + 2);
  plan_ = planned<float>([&] {
    return fftwf_plan_dft_r2c_1d(length, in.data(), complexes(out.data()), flags(rigor) | FFTW_DESTROY_INPUT);
  });
}

void RealForward::execute(float* in, float* out) const {
  fftwf_execute_dft_r2c(static_cast<fftwf_plan>(plan_.get()), in, complexes(out));
}

ComplexDouble::ComplexDouble(std::int64_t n, bool forward) {
  const int length = checked(n);
  const AlignedBuffer<Complex<double>> scratch(static_cast<std::size_t>(n));
  fftw_complex* data = complexes(scratch.data());
  plan_ = planned<double>(
      [&] { return fftw_plan_dft_1d(length, data, data, forward ? FFTW_FORWARD : FFTW_BACKWARD, FFTW_ESTIMATE); });
}

void ComplexDouble::execute(Complex<double>* data) const {
  fftw_execute_dft(static_cast<fftw_plan>(plan_.get()), complexes(data), complexes(data));
}

RealPair2d::RealPair2d(std::int64_t width, std::int64_t height, Place place, Rigor rigor)
    : real_(place == Place::in ? 0 : static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      half_(2 * static_cast<std::size_t>(height) * static_cast<std::size_t>(width / 2 + 1)) {
  const int w = checked(width), h = checked(height);
  fftwf_complex* spectrum = complexes(half_.data());
  float* real = place == Place::in ? half_.data() : real_.data();  // in place FFTW pads each row by itself
  forward_ = planned<float>([&] { return fftwf_plan_dft_r2c_2d(h, w, real, spectrum, flags(rigor)); });
  backward_ = planned<float>([&] { return fftwf_plan_dft_c2r_2d(h, w, spectrum, real, flags(rigor)); });
  std::fill_n(real_.data(), real_.size(), 0.0F);  // zeros stay zeros: the inverse is unnormalised
  std::fill_n(half_.data(), half_.size(), 0.0F);
}

void RealPair2d::execute() const {
  fftwf_execute(static_cast<fftwf_plan>(forward_.get()));
  fftwf_execute(static_cast<fftwf_plan>(backward_.get()));
}

void inverse(std::vector<Complex<double>>& data) {
  fftw_complex* p = complexes(data.data());
  const int length = checked(static_cast<std::int64_t>(data.size()));
  const auto plan = planned<double>([&] { return fftw_plan_dft_1d(length, p, p, FFTW_BACKWARD, FFTW_ESTIMATE); });
  fftw_execute(static_cast<fftw_plan>(plan.get()));
}

bool import_wisdom(const std::string& text) {
  const std::scoped_lock lock(planner());
  return fftwf_import_wisdom_from_string(text.c_str()) != 0;
}

std::string export_wisdom() {
  const std::scoped_lock lock(planner());
  const std::unique_ptr<char, decltype(&std::free)> text(fftwf_export_wisdom_to_string(), &std::free);
  return text ? std::string(text.get()) : std::string();
}

std::string version() { return fftwf_version; }

}  // namespace mtf::fft
