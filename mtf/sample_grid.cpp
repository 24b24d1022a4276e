// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "mtf/sample.h"

namespace mtf {

OtfSampler::Grid::Grid(const OtfSampler& sampler, std::vector<double> fx, std::vector<double> fy)
    : sampler_(&sampler), fx_(std::move(fx)), fy_(std::move(fy)) {
  const Context<double> ctx = sampler.system_.context();
  const auto vector = [&](const std::vector<double>& f, Axis axis) {
    std::vector<Freq<double>> freq(f.size());
    std::vector<Complex<double>> h(f.size());
    for (std::size_t i = 0; i < f.size(); ++i) {
      freq[i] = axis == Axis::x ? Freq<double>{f[i], 0.0} : Freq<double>{0.0, f[i]};
      h[i] = {sampler.aperture_factor(axis, f[i]), 0.0};
    }
    for (const Entry<double>* entry : sampler.separable_) entry->component.multiply(freq, ctx, h);
    std::vector<Complex<float>> narrow(f.size());
    for (std::size_t i = 0; i < f.size(); ++i) narrow[i] = {static_cast<float>(h[i].re), static_cast<float>(h[i].im)};
    return narrow;
  };
  x_ = vector(fx_, Axis::x);
  y_ = vector(fy_, Axis::y);
  const double end = sampler.table_ ? sampler.table_->end() : 1.0;
  for (const double f : fx_) fx2_.push_back(static_cast<float>(f / end * (f / end)));
  for (const double f : fy_) fy2_.push_back(static_cast<float>(f / end * (f / end)));
}

void OtfSampler::Grid::real_row(std::size_t j, std::span<float> value) const {
  const float y = y_[j].re;
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = x_[i].re * y;
  if (sampler_->table_) sampler_->table_->multiply(std::span(fx2_).first(value.size()), fy2_[j], value);
  if (!sampler_->has_general()) return;
  for (std::size_t i = 0; i < value.size(); ++i) value[i] *= static_cast<float>(sampler_->general({fx_[i], fy_[j]}).re);
}

void OtfSampler::Grid::complex_row(std::size_t j, std::span<Complex<float>> value) const {
  std::vector<float> radial(value.size(), 1.0F);
  if (sampler_->table_) sampler_->table_->multiply(std::span(fx2_).first(value.size()), fy2_[j], radial);
  for (std::size_t i = 0; i < value.size(); ++i) {
    Complex<float> h = x_[i] * y_[j];
    if (sampler_->has_general()) {
      const Complex<double> g = sampler_->general({fx_[i], fy_[j]});
      h = h * Complex<float>{static_cast<float>(g.re), static_cast<float>(g.im)};
    }
    value[i] = {h.re * radial[i], h.im * radial[i]};
  }
}

}  // namespace mtf
