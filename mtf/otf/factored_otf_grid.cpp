// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "mtf/otf/factored_otf.h"

namespace mtf {
namespace {

Complex<float> narrow(const Complex<double>& h) { return {static_cast<float>(h.re), static_cast<float>(h.im)}; }

}  // namespace

FactoredOtf::Grid::Grid(const FactoredOtf& sampler, std::vector<double> fx, std::vector<double> fy)
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
    return h;
  };
  x_ = vector(fx_, Axis::x);
  y_ = vector(fy_, Axis::y);
  for (const Complex<double>& h : x_) narrow_x_.push_back(narrow(h));
  for (const Complex<double>& h : y_) narrow_y_.push_back(narrow(h));
  const double end = sampler.table_ ? sampler.table_->end() : 1.0;
  for (const double f : fx_) fx2_.push_back(static_cast<float>(f / end * (f / end)));
  for (const double f : fy_) fy2_.push_back(static_cast<float>(f / end * (f / end)));
  for (const FactoredOtf::Line& line : sampler.lines_) {
    const double x = line.direction.x / line.table.end(), y = line.direction.y / line.table.end();
    std::vector<float>& along_x = line_x_.emplace_back();
    std::vector<float>& along_y = line_y_.emplace_back();
    for (const double f : fx_) along_x.push_back(static_cast<float>(x * f));
    for (const double f : fy_) along_y.push_back(static_cast<float>(y * f));
  }
  for (const Entry<double>* entry : sampler.general_) rows_.push_back(entry->component.rows(fx_, ctx));
}

void FactoredOtf::Grid::multiply_radial(std::size_t j, std::span<float> value) const {
  if (sampler_->table_) sampler_->table_->multiply(std::span(fx2_).first(value.size()), fy2_[j], value);
}

void FactoredOtf::Grid::multiply_lines(std::size_t j, std::span<float> value, bool mirrored) const {
  for (std::size_t k = 0; k < line_x_.size(); ++k) {
    const float y = mirrored ? -line_y_[k][j] : line_y_[k][j];
    sampler_->lines_[k].table.multiply_line(std::span(line_x_[k]).first(value.size()), y, value);
  }
}

std::vector<Complex<double>> FactoredOtf::Grid::general_row(std::size_t j, std::size_t count, bool mirrored) const {
  const double fy = mirrored ? -fy_[j] : fy_[j];
  std::vector<Complex<double>> product(count, {1.0, 0.0});
  if (sampler_->radial_per_sample_)
    for (std::size_t i = 0; i < count; ++i) product[i].re = sampler_->radial_product(std::hypot(fx_[i], fy));
  for (const auto& multiply : rows_) multiply(fy, product);
  for (const Slow& slow : sampler_->polar_) slow.table->multiply(fx_, fy, product);
  if (sampler_->chromatic_general_.empty()) return product;
  for (std::size_t i = 0; i < count; ++i) product[i] = product[i] * sampler_->chromatic_product({fx_[i], fy});
  if (sampler_->options_.progress) sampler_->options_.progress(static_cast<std::int64_t>(count));
  return product;
}

void FactoredOtf::Grid::even_row(std::size_t j, std::span<float> value) const {
  const float y = narrow_y_[j].re;
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = narrow_x_[i].re * y;
  multiply_radial(j, value);
}

void FactoredOtf::Grid::multiply_uneven(std::size_t j, std::span<float> value, bool mirrored) const {
  multiply_lines(j, value, mirrored);
  if (!sampler_->has_general()) return;
  const std::vector<Complex<double>> general = general_row(j, value.size(), mirrored);
  for (std::size_t i = 0; i < value.size(); ++i) value[i] *= static_cast<float>(general[i].re);
}

void FactoredOtf::Grid::real_row(std::size_t j, std::span<float> value, bool mirrored) const {
  even_row(j, value);
  multiply_uneven(j, value, mirrored);
}

void FactoredOtf::Grid::real_rows(std::size_t j, std::span<float> value, std::span<float> mirrored) const {
  even_row(j, value);
  std::copy(value.begin(), value.end(), mirrored.begin());
  multiply_uneven(j, value, false);
  multiply_uneven(j, mirrored, true);
}

void FactoredOtf::Grid::complex_row(std::size_t j, std::span<Complex<float>> value, bool mirrored) const {
  std::vector<float> tables(value.size(), 1.0F);
  multiply_radial(j, tables);
  multiply_lines(j, tables, mirrored);
  const Complex<float> y{narrow_y_[j].re, mirrored ? -narrow_y_[j].im : narrow_y_[j].im};
  for (std::size_t i = 0; i < value.size(); ++i) {
    const Complex<float> h = narrow_x_[i] * y;
    value[i] = {h.re * tables[i], h.im * tables[i]};
  }
  if (!sampler_->has_general()) return;
  const std::vector<Complex<double>> general = general_row(j, value.size(), mirrored);
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = value[i] * narrow(general[i]);
}

void FactoredOtf::Grid::real_row(std::size_t j, std::span<double> value, bool mirrored) const {
  std::vector<Complex<double>> h(value.size());
  complex_row(j, std::span(h), mirrored);
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = h[i].re;
}

void FactoredOtf::Grid::real_rows(std::size_t j, std::span<double> value, std::span<double> mirrored) const {
  real_row(j, value);
  real_row(j, mirrored, true);
}

void FactoredOtf::Grid::complex_row(std::size_t j, std::span<Complex<double>> value, bool mirrored) const {
  std::vector<float> tables(value.size(), 1.0F);
  multiply_radial(j, tables);
  multiply_lines(j, tables, mirrored);
  const std::vector<Complex<double>> general = general_row(j, value.size(), mirrored);
  const Complex<double> y{y_[j].re, mirrored ? -y_[j].im : y_[j].im};
  for (std::size_t i = 0; i < value.size(); ++i) {
    const Complex<double> h = x_[i] * y * general[i];
    value[i] = {h.re * tables[i], h.im * tables[i]};
  }
}

}  // namespace mtf
