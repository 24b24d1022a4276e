// SPDX-License-Identifier: Apache-2.0
#include "apps/check/reference_fft.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "mtf/engines/fft/fftw.h"
#include "mtf/parallel.h"
#include "mtf/plan/plan.h"

namespace apps::check {
namespace {

using C = mtf::Complex<double>;

constexpr std::int64_t kLanes = 8;    // sequences that share the phases of a trigonometric sum
constexpr std::int64_t kReseed = 64;  // rotations in a row before the phase is computed afresh

std::size_t at(std::int64_t i) { return static_cast<std::size_t>(i); }

// exp(2 pi i turns).
C phase(long double turns) {
  turns -= std::round(turns);
  const auto angle = static_cast<double>(2.0L * 3.14159265358979323846264338327950288L * turns);
  return {std::cos(angle), std::sin(angle)};
}

/// One axis: the canvas, its frequencies, and the sums from coefficients to detector samples.
class Axis {
 public:
  Axis(mtf::Border border, std::int64_t samples, double step_um, std::int64_t outputs, double pitch_um)
      : border_(border),
        samples_(samples),
        length_(mtf::canvas_length(border, samples)),
        outputs_(outputs),
        period_um_(static_cast<double>(length_) * step_um),
        turns_at_first_(0.5L * (static_cast<long double>(pitch_um) - step_um) / period_um_),
        turns_per_output_(static_cast<long double>(pitch_um) / period_um_),
        forward_(length_, true) {
    const double pitches = period_um_ / pitch_um;
    if (!mtf::is_whole(pitches)) return;
    fold_ = std::llround(pitches);
    turns_per_output_ = 1.0L / static_cast<long double>(fold_);
    backward_ = mtf::fft::ComplexDouble(fold_, false);
  }

  std::int64_t length() const { return length_; }
  std::int64_t outputs() const { return outputs_; }
  /// Frequencies k = 0 .. highest(); an even length has its last one at both signs, half each.
  std::int64_t highest() const { return length_ / 2; }
  double weight(std::int64_t k) const { return 2 * std::abs(k) == length_ ? 0.5 : 1.0; }
  double cy_mm(std::int64_t k) const { return static_cast<double>(k) / period_um_ * 1e3; }

  /// The canvas of `sample(i)`, i = 0 .. samples-1, beyond them `border` where that is constant, transformed.
  template <class Sample>
  void analyse(const Sample& sample, const C& border, C* canvas) const {
    for (std::int64_t i = 0; i < length_; ++i) {
      const std::int64_t source = mtf::border_source(border_, i, samples_);
      canvas[i] = source < 0 ? border : sample(source);
    }
    forward_.execute(canvas);
  }

  /// value[j kLanes + l] = sum over k of coefficient[(k - first) kLanes + l] exp(2 pi i k x_j / period), `count`
  /// frequencies from `first` on.
  void synthesise(std::int64_t first, const std::vector<C>& coefficient, std::vector<C>& value) const {
    const auto count = static_cast<std::int64_t>(coefficient.size()) / kLanes;
    value.assign(at(outputs_ * kLanes), C{});
    if (fold_ > 0)
      fold(first, count, coefficient, value);
    else
      sum(first, count, coefficient, value);
  }

 private:
  void fold(std::int64_t first, std::int64_t count, const std::vector<C>& coefficient, std::vector<C>& value) const {
    const mtf::AlignedBuffer<C> work(at(fold_));
    std::vector<C> shift(at(count));
    for (std::int64_t i = 0; i < count; ++i)
      shift[at(i)] = phase(static_cast<long double>(first + i) * turns_at_first_);
    for (std::int64_t lane = 0; lane < kLanes; ++lane) {
      std::fill_n(work.data(), fold_, C{});
      for (std::int64_t i = 0; i < count; ++i) {
        C& sample = work[at(((first + i) % fold_ + fold_) % fold_)];
        sample = sample + coefficient[at(i * kLanes + lane)] * shift[at(i)];
      }
      backward_.execute(work.data());
      for (std::int64_t j = 0; j < outputs_; ++j) value[at(j * kLanes + lane)] = work[at(j)];
    }
  }

  void sum(std::int64_t first, std::int64_t count, const std::vector<C>& coefficient, std::vector<C>& value) const {
    for (std::int64_t i = 0; i < count; ++i) {
      const auto k = static_cast<long double>(first + i);
      const C* g = coefficient.data() + i * kLanes;
      const C step = phase(k * turns_per_output_);
      C w;
      for (std::int64_t j = 0; j < outputs_; ++j) {
        w = j % kReseed == 0 ? phase(k * (turns_at_first_ + static_cast<long double>(j) * turns_per_output_))
                             : w * step;
        C* v = value.data() + j * kLanes;
        for (std::int64_t lane = 0; lane < kLanes; ++lane) v[lane] = v[lane] + g[lane] * w;
      }
    }
  }

  mtf::Border border_;
  std::int64_t samples_, length_, outputs_, fold_ = 0;
  double period_um_;
  long double turns_at_first_, turns_per_output_;
  mtf::fft::ComplexDouble forward_, backward_;
};

// The spectrum of every image row, frequencies k >= 0: row y at [y (highest + 1)].
template <class T>
std::vector<C> transform_rows(mtf::ImageView<const T> scene, const Axis& axis, double border_value, int threads) {
  const std::int64_t half = axis.highest() + 1;
  std::vector<C> rows(at(scene.height * half));
  mtf::parallel_for(scene.height, 16, threads, [&](std::int64_t begin, std::int64_t end) {
    const mtf::AlignedBuffer<C> canvas(at(axis.length()));
    for (std::int64_t y = begin; y < end; ++y) {
      const auto sample = [&](std::int64_t x) { return C{static_cast<double>(scene.at(x, y)), 0.0}; };
      axis.analyse(sample, {border_value, 0.0}, canvas.data());
      std::copy_n(canvas.data(), half, rows.data() + y * half);
    }
  });
  return rows;
}

// Columns transformed, filtered and sampled along y: coefficient q of output row j at [j (highest + 1) + q].
std::vector<C> filter_columns(const std::vector<C>& rows, const Axis& ax, const Axis& ay, const OtfColumn& otf,
                              double border_value, int threads) {
  const std::int64_t half = ax.highest() + 1, top = ay.highest(), count = 2 * top + 1;
  const double scale = 1.0 / (static_cast<double>(ax.length()) * static_cast<double>(ay.length()));
  std::vector<double> fy(at(count));
  for (std::int64_t p = -top; p <= top; ++p) fy[at(p + top)] = ay.cy_mm(p);
  std::vector<C> filtered(at(ay.outputs() * half));
  mtf::parallel_for(half, kLanes, threads, [&](std::int64_t begin, std::int64_t end) {
    const mtf::AlignedBuffer<C> canvas(at(ay.length()));
    std::vector<C> coefficient(at(count * kLanes)), value;
    std::vector<std::complex<double>> h(at(count));
    for (std::int64_t q = begin; q < end; ++q) {
      // Beyond a constant border whole rows have its value: a spectrum of one line.
      const C border{q == 0 ? border_value * static_cast<double>(ax.length()) : 0.0, 0.0};
      ay.analyse([&](std::int64_t y) { return rows[at(y * half + q)]; }, border, canvas.data());
      otf(ax.cy_mm(q), fy, h);
      // Frequencies q and -q are conjugates of one another: the real part counts both.
      const double weight = (q == 0 ? 1.0 : 2.0) * ax.weight(q) * scale;
      for (std::int64_t p = -top; p <= top; ++p) {
        const C s = canvas[at(p < 0 ? p + ay.length() : p)];
        const std::complex<double> factor = h[at(p + top)] * (weight * ay.weight(p));
        coefficient[at((p + top) * kLanes + q - begin)] = s * C{factor.real(), factor.imag()};
      }
    }
    ay.synthesise(-top, coefficient, value);
    for (std::int64_t j = 0; j < ay.outputs(); ++j)
      for (std::int64_t q = begin; q < end; ++q) filtered[at(j * half + q)] = value[at(j * kLanes + q - begin)];
  });
  return filtered;
}

template <class T>
std::vector<double> reference(mtf::ImageView<const T> scene, const mtf::SampleGrid& in, const mtf::SampleGrid& out,
                              const OtfColumn& otf, mtf::Border border, double border_value, int threads) {
  const Axis ax(border, in.width, in.step_x_um, out.width, out.step_x_um);
  const Axis ay(border, in.height, in.step_y_um, out.height, out.step_y_um);
  const std::int64_t half = ax.highest() + 1;
  const std::vector<C> filtered =
      filter_columns(transform_rows(scene, ax, border_value, threads), ax, ay, otf, border_value, threads);
  std::vector<double> image(at(out.width * out.height));
  mtf::parallel_for(out.height, kLanes, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<C> coefficient(at(half * kLanes)), value;
    for (std::int64_t q = 0; q < half; ++q)
      for (std::int64_t j = begin; j < end; ++j) coefficient[at(q * kLanes + j - begin)] = filtered[at(j * half + q)];
    ax.synthesise(0, coefficient, value);
    for (std::int64_t j = begin; j < end; ++j)
      for (std::int64_t i = 0; i < out.width; ++i) image[at(j * out.width + i)] = value[at(i * kLanes + j - begin)].re;
  });
  return image;
}

}  // namespace

OtfColumn exact_otf(const mtf::System<double>& system, std::vector<mtf::Stage> stages,
                    const mtf::SceneAperture& aperture, const mtf::SampleGrid& in) {
  const auto owned = std::make_shared<const mtf::System<double>>(system);
  std::shared_ptr<const mtf::FactoredOtf> correction;
  if (aperture.kind != mtf::SceneAperture::Kind::point)
    correction = std::make_shared<const mtf::FactoredOtf>(
        system, std::span<const mtf::Stage>{}, aperture,
        mtf::SamplerOptions{.fx_max = 500.0 / in.step_x_um, .fy_max = 500.0 / in.step_y_um});
  bool even = true;  // along y: half of the values are the other half
  for (const mtf::Stage stage : stages)
    for (const mtf::Entry<double>& entry : owned->list(stage))
      even = even && entry.component.traits(owned->context()).even_y;
  return [owned, correction, stages = std::move(stages), even](double fx, std::span<const double> fy,
                                                               std::span<std::complex<double>> h) {
    const bool mirror = even && !fy.empty() && fy.front() == -fy.back();  // rising and symmetric about 0
    const std::size_t first = mirror ? fy.size() / 2 : 0;
    std::vector<mtf::Freq<double>> f;
    for (const double y : fy.subspan(first)) f.push_back({fx, y});
    std::fill(h.begin(), h.end(), 1.0);
    for (const mtf::Stage stage : stages) {
      const std::vector<C> product = owned->otf(std::span(owned->list(stage)), f);
      for (std::size_t i = 0; i < f.size(); ++i) h[first + i] *= std::complex<double>(product[i].re, product[i].im);
    }
    for (std::size_t i = 0; correction && i < f.size(); ++i) h[first + i] *= correction->at(f[i]).re;
    for (std::size_t i = 0; i < first; ++i) h[i] = h[fy.size() - 1 - i];
  };
}

std::vector<double> reference_image_fft(mtf::ImageView<const float> scene, const mtf::SampleGrid& in,
                                        const mtf::SampleGrid& out, const OtfColumn& otf, mtf::Border border,
                                        double border_value, int threads) {
  return reference(scene, in, out, otf, border, border_value, threads);
}

std::vector<double> reference_image_fft(mtf::ImageView<const double> scene, const mtf::SampleGrid& in,
                                        const mtf::SampleGrid& out, const OtfColumn& otf, mtf::Border border,
                                        double border_value, int threads) {
  return reference(scene, in, out, otf, border, border_value, threads);
}

std::vector<double> reference_image_fft(mtf::ImageView<const float> scene, const mtf::SampleGrid& in,
                                        const mtf::SampleGrid& out, const Otf& otf, mtf::Border border,
                                        double border_value, int threads) {
  const OtfColumn column = [&otf](double fx, std::span<const double> fy, std::span<std::complex<double>> h) {
    for (std::size_t i = 0; i < fy.size(); ++i) h[i] = otf(fx, fy[i]);
  };
  return reference(scene, in, out, column, border, border_value, threads);
}

std::vector<double> reference_sensor_image(const mtf::System<double>& system, mtf::ImageView<const float> scene,
                                           const mtf::SampleGrid& in, const mtf::SceneAperture& aperture,
                                           mtf::Border border, double border_value, int threads) {
  using mtf::Stage;
  const mtf::SampleGrid out = mtf::detector_grid(system, in);
  const OtfColumn presample = exact_otf(system, {Stage::presample}, aperture, in);
  std::vector<double> image = reference(scene, in, out, presample, border, border_value, threads);
  if (system.list(Stage::readout).empty() && system.list(Stage::postsample).empty()) return image;
  std::complex<double> gain;
  const double zero = 0.0;
  presample(0.0, std::span(&zero, 1), std::span(&gain, 1));
  const OtfColumn post = exact_otf(system, {Stage::readout, Stage::postsample}, {}, out);
  const mtf::ImageView<const double> sampled{image.data(), out.width, out.height, out.width};
  return reference(sampled, out, out, post, border, gain.real() * border_value, threads);
}

}  // namespace apps::check
