// SPDX-License-Identifier: Apache-2.0
// Basis and length of both axes of an FFT method.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mtf/plan/padding.h"
#include "mtf/plan/plan_cost.h"
#include "mtf/plan/plan_parts.h"

namespace mtf {
namespace {

/// How an axis is expanded: `odd` as in AxisTransform.
struct Expansion {
  Basis basis = Basis::fourier;
  bool odd = false;
};

AxisTransform axis_job(const CanvasRequest& request, Expansion expansion, std::int64_t length, std::int64_t outputs) {
  AxisTransform job;
  job.frequency = {expansion.basis, length, request.step_um};
  job.border = request.border;
  job.samples = request.samples;
  job.outputs = outputs;
  job.pitch_um = request.pitch_um;
  const double pitches = static_cast<double>(length) * request.step_um / request.pitch_um;
  job.resampling = is_whole(pitches) ? Resampling::fold : Resampling::chirp;
  if (job.resampling == Resampling::fold) job.out_length = std::llround(pitches);
  job.keep = job.frequency.half_count();
  job.odd = expansion.odd;
  return job;
}

// The least that an axis costs, whatever canvas it may need.
AxisTransform least_job(const CanvasRequest& request, Expansion expansion, std::int64_t outputs) {
  if (expansion.basis == Basis::cosine) return axis_job(request, expansion, request.samples, outputs);
  AxisTransform job = axis_job(request, expansion, next_smooth(request.samples), outputs);
  job.resampling = Resampling::fold;
  job.out_length = next_smooth(outputs);
  return job;
}

/// Layouts as alternatives to one that costs `below_ms`.
class Layouts {
 public:
  explicit Layouts(const PlanTask& task) : task_(task) {
    const SampleGrid &in = task.in, &out = task.out;
    const double density = std::sqrt(std::max(1.0, out.step_x_um / in.step_x_um * (out.step_y_um / in.step_y_um)));
    const double norm = task.norm * density, budget = 0.5 * kWrapShare * task.options.tolerance;
    const Border border = task.options.border;
    x_ = {Axis::x, border, in.width, in.step_x_um, 500.0 / in.step_y_um, out.step_x_um, norm, budget};
    y_ = {Axis::y, border, in.height, in.step_y_um, 500.0 / in.step_x_um, out.step_y_um, norm, budget};
  }

  /// Nothing where it would cost `below_ms` or more.
  std::optional<Layout> make(Expansion x, Expansion y,
                             double below_ms = std::numeric_limits<double>::infinity()) const {
    const std::int64_t width = task_.out.width, height = task_.out.height;
    const AxisTransform least_x = least_job(x_, x, width), least_y = least_job(y_, y, height);
    const double room = below_ms / cost_ms(least_x, least_y);
    if (!(room > 1.0)) return std::nullopt;
    Layout layout;
    const auto place = [&](const CanvasRequest& request, Expansion expansion, std::int64_t outputs,
                           AxisTransform& job) {
      CanvasLength canvas{request.samples, 0.0};
      if (expansion.basis == Basis::fourier) canvas = choose_canvas(task_.sampler, longest(request, room));
      layout.wrap += canvas.bound;
      job = axis_job(request, expansion, canvas.length, outputs);
    };
    place(x_, x, width, layout.x);
    if (!(cost_ms(layout.x, least_y) < below_ms)) return std::nullopt;
    place(y_, y, height, layout.y);
    if (!(cost_ms(layout.x, layout.y) < below_ms)) return std::nullopt;
    return layout;
  }
  double cost_ms(const AxisTransform& x, const AxisTransform& y) const {
    return fft_cost_ms(x, y, task_.sampler.is_real());
  }

 private:
  // Costs grow with the length of a canvas.
  static CanvasRequest longest(CanvasRequest request, double room) {
    const double length = room * static_cast<double>(next_smooth(request.samples));
    if (length < static_cast<double>(request.longest)) request.longest = static_cast<std::int64_t>(length);
    return request;
  }

  const PlanTask& task_;
  CanvasRequest x_, y_;
};

}  // namespace

// Cosines are exact without padding. Where they are many series (an OTF that is not even) or of an awkward length (a
// large prime, not a whole number of pitches) a padded canvas may be cheaper all the same.
std::vector<Layout> fft_layouts(const PlanTask& task) {
  const FactoredOtf& sampler = task.sampler;
  constexpr Expansion fourier{Basis::fourier, false}, cosine{Basis::cosine, false};
  const Layouts layouts(task);
  if (task.options.border != Border::reflect) return {*layouts.make(fourier, fourier)};
  // An OTF that is real and even along one axis is even along both.
  const bool even = sampler.is_real() && (sampler.is_even_x() || sampler.is_even_y());
  const bool odd_x = !even && !sampler.is_even_x(), odd_y = !even && !sampler.is_even_y();
  std::vector<Layout> list{*layouts.make({Basis::cosine, odd_x}, {Basis::cosine, odd_y})};
  const auto dear = [](const AxisTransform& job) {
    return job.odd || job.resampling == Resampling::chirp || !is_smooth(job.frequency.length);
  };
  const bool try_x = dear(list[0].x), try_y = dear(list[0].y);
  const auto consider = [&](Expansion x, Expansion y) {
    const std::optional<Layout> other = layouts.make(x, y, layouts.cost_ms(list[0].x, list[0].y));
    if (!other) return;
    if (list.size() > 1) list.erase(list.begin());
    list.insert(list.begin(), *other);
  };
  if (try_x && !odd_y) consider(fourier, cosine);
  if (try_y) consider(fourier, fourier);
  return list;
}

}  // namespace mtf
