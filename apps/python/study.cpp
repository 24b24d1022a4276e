// SPDX-License-Identifier: Apache-2.0

// Trade studies: rows of designs as an array, the front, derivatives and the optimum.

#include "apps/study/study.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <mutex>

#include "apps/python/arrays.h"
#include "apps/python/job.h"
#include "apps/python/sensor.h"
#include "apps/python/topics.h"
#include "apps/study/result_columns.h"
#include "apps/study/rows/sweep_rows.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/sweep/sweep_report.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/parallel.h"

namespace apps::python {
namespace {

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

struct StudyHandle {
  SweepStudy sweep;
  const study::Study& study() const { return *sweep.study; }
};

std::unique_ptr<StudyHandle> load(const FileName& file, std::optional<double> tolerance) {
  const py::gil_scoped_release free;
  return std::make_unique<StudyHandle>(StudyHandle{open_study(file.bytes, tolerance)});
}

py::list columns_of(const StudyHandle& handle) {
  py::list columns;
  for (const study::Column& column : handle.sweep.columns) {
    columns.append(py::dict("name"_a = column.name, "unit"_a = column.unit, "definition"_a = column.definition,
                            "source"_a = column.source, "role"_a = study::role_word(column.role),
                            "levels"_a = column.levels));
  }
  return columns;
}

py::list axes_of(const StudyHandle& handle) {
  py::list axes;
  for (const study::Axis& axis : handle.study().axes) {
    axes.append(py::dict("name"_a = handle.study().parameters[static_cast<std::size_t>(axis.parameter)].name,
                         "points"_a = axis.points(), "levels"_a = axis.levels));
  }
  return axes;
}

std::vector<std::string> goals_of(const study::Study& study) {
  std::vector<std::string> goals;
  for (const study::Objective& objective : study.objectives)
    goals.push_back((objective.maximize ? "maximize " : "minimize ") + objective.text);
  return goals;
}

std::vector<std::string> limits_of(const study::Study& study) {
  std::vector<std::string> limits;
  for (const study::Constraint& constraint : study.constraints) limits.push_back(constraint.text);
  return limits;
}

/// Makers of rows, each in use by one thread at a time.
class Makers {
 public:
  explicit Makers(const std::shared_ptr<const study::Study>& study) : make_(study::row_makers(study)) {}
  study::RowMaker take() {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        study::RowMaker maker = std::move(free_.back());
        free_.pop_back();
        return maker;
      }
    }
    return make_();
  }
  void give_back(study::RowMaker maker) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(maker));
  }

 private:
  std::function<study::RowMaker()> make_;
  std::mutex mutex_;
  std::vector<study::RowMaker> free_;
};

py::array_t<double> rows(const StudyHandle& handle, std::int64_t first, std::int64_t last, int threads,
                         const py::object& progress) {
  if (first < 0 || last < first || last > handle.study().designs)
    throw mtf::UsageError("rows: designs " + std::to_string(first) + " to " + std::to_string(last) +
                          " are not among the " + std::to_string(handle.study().designs) + " of the study");
  const std::int64_t count = last - first;
  const auto width = static_cast<std::int64_t>(handle.sweep.columns.size());
  py::array_t<double> result({count, width});
  double* numbers = result.mutable_data();
  run_job([&](JobControl& control) {
    const ProgressCall report(progress, control);
    Makers makers(handle.sweep.study);
    std::atomic<std::int64_t> done{0};
    // Neighbours share work: long pieces, but some for each thread, and enough of them to tell of.
    const std::int64_t pieces = std::int64_t{16} * mtf::threads_of(threads);
    const std::int64_t chunk = std::clamp<std::int64_t>(count / pieces, 1, 4096);
    mtf::parallel_for(count, chunk, threads, [&](std::int64_t begin, std::int64_t end) {
      control.check();
      study::RowMaker maker = makers.take();
      for (std::int64_t i = begin; i < end; ++i) {
        control.check();
        maker(first + i, {numbers + i * width, static_cast<std::size_t>(width)});
      }
      makers.give_back(std::move(maker));
      const std::int64_t now = done += end - begin;
      report(static_cast<double>(now) / static_cast<double>(count));
    });
  });
  return result;
}

/// Numbers of the feasible designs that no other one beats, of the given rows.
std::vector<std::int64_t> pareto(const StudyHandle& handle, const std::vector<std::int64_t>& designs,
                                 const Rows& table) {
  const std::size_t width = handle.sweep.columns.size();
  if (table.ndim() != 2 || static_cast<std::size_t>(table.shape(1)) != width ||
      static_cast<std::size_t>(table.shape(0)) != designs.size())
    throw mtf::UsageError("pareto: the rows are not those of this study");
  const double* numbers = table.data();
  const py::gil_scoped_release free;
  study::Tally tally(study::tally_job(handle.sweep.study, handle.sweep.columns));
  for (std::size_t begin = 0; begin < designs.size();) {  // runs of successive designs
    std::size_t end = begin + 1;
    while (end < designs.size() && designs[end] == designs[end - 1] + 1) ++end;
    tally.count({designs[begin], static_cast<std::int64_t>(end - begin)},
                {numbers + begin * width, (end - begin) * width})();
    begin = end;
  }
  return tally.front().designs;
}

std::vector<double> axis_values(const StudyHandle& handle, std::int64_t design) {
  if (design < 0 || design >= handle.study().designs)
    throw mtf::UsageError("design " + std::to_string(design) + " is not among the " +
                          std::to_string(handle.study().designs) + " of the study");
  std::vector<double> values(handle.study().axes.size());
  study::design_at(handle.study(), design, values);
  return values;
}

void require_axes(const StudyHandle& handle, const std::vector<double>& values) {
  if (values.size() != handle.study().axes.size())
    throw mtf::UsageError("axes: " + std::to_string(values.size()) + " values for " +
                          std::to_string(handle.study().axes.size()) + " axes");
}

SensorHandle sensor_at(const StudyHandle& handle, const std::vector<double>& values, const FileName& file) {
  require_axes(handle, values);
  study::Evaluator evaluator(handle.sweep.study);
  return read_sensor_text(mtf::io::write_config(evaluator.sensor_at(values), file), file);
}

py::dict gradient_at(const StudyHandle& handle, const std::vector<double>& values) {
  require_axes(handle, values);
  study::Gradient gradient;
  run_job([&](JobControl&) {
    study::Evaluator evaluator(handle.sweep.study);
    gradient = evaluator.gradient_at(values);
  });
  const auto shaped = [&](const std::vector<double>& numbers) {
    const auto count = static_cast<py::ssize_t>(gradient.parameters.size());
    const py::array flat = to_numpy(numbers);
    return flat.attr("reshape")(-1, count);
  };
  return py::dict("columns"_a = gradient.columns, "parameters"_a = gradient.parameters,
                  "value"_a = shaped(gradient.value), "objective"_a = shaped(gradient.objective),
                  "margin"_a = shaped(gradient.margin));
}

py::array evaluate_at(const StudyHandle& handle, const std::vector<double>& values) {
  require_axes(handle, values);
  std::vector<double> row(handle.sweep.columns.size());
  study::Evaluator evaluator(handle.sweep.study);
  evaluator.evaluate_at(values, row);
  return to_numpy(std::move(row));
}

/// The JSON of `mtf optimize`, and for each goal the values of the axes of the best design; None where there is none.
py::tuple optimum(const StudyHandle& handle, const std::vector<std::pair<std::string, std::vector<double>>>& goals,
                  bool search, int starts, int threads, const py::object& progress) {
  std::vector<OptimizedGoal> made;
  run_job([&](JobControl& control) {
    const ProgressCall report(progress, control);
    for (const auto& [name, weights] : goals) {
      OptimizedGoal& goal = made.emplace_back(OptimizedGoal{name, {}, {}, {}});
      goal.options.weights = weights;
      goal.options.method = search ? study::OptimizeOptions::Method::search : study::OptimizeOptions::Method::smooth;
      goal.options.starts = starts;
      goal.options.threads = threads;
      goal.options.progress = [&](double share) { report(share); };
      goal.outcome = study::optimize(handle.study(), goal.options);
    }
  });
  py::list best;
  for (const OptimizedGoal& goal : made)
    best.append(goal.outcome.best.feasible ? py::cast(goal.outcome.best.axis_values) : py::object(py::none()));
  return py::make_tuple(optimize_json(handle.study(), made), optimize_table(handle.study(), made), best);
}

/// Every file that the study is made of, by its name relative to the study.
py::list files(const StudyHandle& handle) {
  py::list list;
  for (const StudyCopy& copy : copies_of(handle.study()))
    list.append(py::make_tuple(FileName{copy.name.string()}, py::bytes(copy.bytes)));
  return list;
}

}  // namespace

void add_study(py::module_& module) {
  py::class_<StudyHandle>(module, "StudyFile", "A trade study.")
      .def(py::init(&load), "file"_a, "tolerance"_a)
      .def_property_readonly("file", [](const StudyHandle& s) { return FileName{s.study().file}; })
      .def_property_readonly("text", [](const StudyHandle& s) { return s.study().text; })
      .def_property_readonly("sha256", [](const StudyHandle& s) { return s.study().sha256; })
      .def_property_readonly("name", [](const StudyHandle& s) { return s.study().name; })
      .def_property_readonly("tolerance", [](const StudyHandle& s) { return s.study().tolerance; })
      .def_property_readonly("designs", [](const StudyHandle& s) { return s.study().designs; })
      .def_property_readonly("grid", [](const StudyHandle& s) { return s.study().method == study::Method::grid; })
      .def_property_readonly("objectives", [](const StudyHandle& s) { return goals_of(s.study()); })
      .def_property_readonly("constraints", [](const StudyHandle& s) { return limits_of(s.study()); })
      .def_property_readonly("warnings",
                             [](const StudyHandle& s) {
                               std::vector<std::string> texts;
                               for (const auto& warning : s.study().warnings)
                                 texts.push_back(apps::one_line(mtf::io::format_diagnostic(warning, s.study().file)));
                               return texts;
                             })
      .def_property_readonly("columns", &columns_of)
      .def_property_readonly("axes", &axes_of)
      .def("rows", &rows, "first"_a, "last"_a, "threads"_a, "progress"_a)
      .def("pareto", &pareto, "designs"_a, "rows"_a)
      .def("axis_values", &axis_values, "design"_a)
      .def("evaluate_at", &evaluate_at, "values"_a)
      .def("sensor_at", &sensor_at, "values"_a, "file"_a)
      .def("gradient_at", &gradient_at, "values"_a)
      .def("gaps",
           [](const StudyHandle& s) {
             study::Evaluator evaluator(s.sweep.study);
             std::vector<double> row(s.sweep.columns.size());
             evaluator.evaluate(0, row);
             return std::make_pair(evaluator.gaps(), evaluator.last_refusal() + evaluator.last_problem());
           })
      .def("optimum", &optimum, "goals"_a, "search"_a, "starts"_a, "threads"_a, "progress"_a)
      .def("files", &files);
}

}  // namespace apps::python
