// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fftw.h"

#include <fftw3.h>

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <limits>
#include <mutex>

#include "mtf/error.h"
#include "mtf/image.h"

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

// The lock is released before the plan gets its owner, whose deleter takes it again.
fftwf_plan planned(const auto& make) {
  const std::scoped_lock lock(planner());
  return make();
}

std::shared_ptr<void> own(fftwf_plan plan) {
  if (plan == nullptr) throw RuntimeError("FFTW could not plan a transform");
  return {plan, [](void* p) {
            const std::scoped_lock lock(planner());
            fftwf_destroy_plan(static_cast<fftwf_plan>(p));
          }};
}

fftwf_complex* complexes(float* p) { return reinterpret_cast<fftwf_complex*>(p); }
fftw_complex* complexes(Complex<double>* p) {
  static_assert(sizeof(Complex<double>) == sizeof(fftw_complex));
  return reinterpret_cast<fftw_complex*>(p);
}

}  // namespace

Lanes::Lanes(std::int64_t n, int lanes, bool forward, Rigor rigor) {
  const int length = checked(n);
  const AlignedBuffer<float> scratch(2 * static_cast<std::size_t>(n) * static_cast<std::size_t>(lanes));
  fftwf_complex* data = complexes(scratch.data());
  plan_ = own(planned([&] {
    return fftwf_plan_many_dft(1, &length, lanes, data, nullptr, lanes, 1, data, nullptr, lanes, 1,
                               forward ? FFTW_FORWARD : FFTW_BACKWARD, flags(rigor));
  }));
}

void Lanes::execute(float* data) const {
  fftwf_execute_dft(static_cast<fftwf_plan>(plan_.get()), complexes(data), complexes(data));
}

RealForward::RealForward(std::int64_t n, Rigor rigor) {
  const int length = checked(n);
  const AlignedBuffer<float> in(static_cast<std::size_t>(n)), out(static_cast<std::size_t>(n) + 2);
  plan_ = own(planned([&] {
    return fftwf_plan_dft_r2c_1d(length, in.data(), complexes(out.data()), flags(rigor) | FFTW_DESTROY_INPUT);
  }));
}

void RealForward::execute(float* in, float* out) const {
  fftwf_execute_dft_r2c(static_cast<fftwf_plan>(plan_.get()), in, complexes(out));
}

RealInverse::RealInverse(std::int64_t n, Rigor rigor) {
  const int length = checked(n);
  const AlignedBuffer<float> in(static_cast<std::size_t>(n) + 2), out(static_cast<std::size_t>(n));
  plan_ = own(planned([&] {
    return fftwf_plan_dft_c2r_1d(length, complexes(in.data()), out.data(), flags(rigor) | FFTW_DESTROY_INPUT);
  }));
}

void RealInverse::execute(float* in, float* out) const {
  fftwf_execute_dft_c2r(static_cast<fftwf_plan>(plan_.get()), complexes(in), out);
}

ComplexDouble::ComplexDouble(std::int64_t n, bool forward) {
  const int length = checked(n);
  const AlignedBuffer<Complex<double>> scratch(static_cast<std::size_t>(n));
  fftw_complex* data = complexes(scratch.data());
  fftw_plan plan = nullptr;
  {
    const std::scoped_lock lock(planner());
    plan = fftw_plan_dft_1d(length, data, data, forward ? FFTW_FORWARD : FFTW_BACKWARD, FFTW_ESTIMATE);
  }
  if (plan == nullptr) throw RuntimeError("FFTW could not plan a transform");
  plan_ = {plan, [](void* p) {
             const std::scoped_lock lock(planner());
             fftw_destroy_plan(static_cast<fftw_plan>(p));
           }};
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
  forward_ = own(planned([&] { return fftwf_plan_dft_r2c_2d(h, w, real, spectrum, flags(rigor)); }));
  backward_ = own(planned([&] { return fftwf_plan_dft_c2r_2d(h, w, spectrum, real, flags(rigor)); }));
  std::fill_n(real_.data(), real_.size(), 0.0F);  // zeros stay zeros: the inverse is unnormalised
  std::fill_n(half_.data(), half_.size(), 0.0F);
}

void RealPair2d::execute() const {
  fftwf_execute(static_cast<fftwf_plan>(forward_.get()));
  fftwf_execute(static_cast<fftwf_plan>(backward_.get()));
}

void inverse(std::vector<Complex<double>>& data) {
  fftw_complex* p = complexes(data.data());
  fftw_plan plan = nullptr;
  {
    const std::scoped_lock lock(planner());
    plan = fftw_plan_dft_1d(checked(static_cast<std::int64_t>(data.size())), p, p, FFTW_BACKWARD, FFTW_ESTIMATE);
  }
  if (plan == nullptr) throw RuntimeError("FFTW could not plan a transform");
  fftw_execute(plan);
  const std::scoped_lock lock(planner());
  fftw_destroy_plan(plan);
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
