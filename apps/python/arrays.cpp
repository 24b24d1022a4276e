// SPDX-License-Identifier: Apache-2.0
#include "apps/python/arrays.h"

#include <algorithm>
#include <cstdint>

#include "mtf/error.h"

namespace apps::python {
namespace {

namespace py = pybind11;
using namespace py::literals;

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i == 0 ? "" : ", ") + std::to_string(array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

std::string dtype_text(const py::array& array) { return py::str(array.dtype()).cast<std::string>(); }

/// float32 in this machine's byte order, at addresses that are multiples of its size.
bool is_float32(const py::array& array) {
  return py::isinstance<py::array_t<float>>(array) &&
         reinterpret_cast<std::uintptr_t>(array.data()) % alignof(float) == 0;
}

/// Rows of neighbouring floats, one after the other without overlap.
bool has_rows(const py::array& array) {
  constexpr py::ssize_t kSize = sizeof(float);
  const bool column_step = array.strides(1) == kSize || array.shape(1) == 1;
  const bool row_step =
      (array.strides(0) % kSize == 0 && array.strides(0) >= kSize * array.shape(1)) || array.shape(0) == 1;
  return column_step && row_step;
}

std::int64_t stride_of(const py::array& array) {
  return array.shape(0) == 1 ? array.shape(1) : array.strides(0) / static_cast<py::ssize_t>(sizeof(float));
}

void require_plane(const py::array& array, const std::string& name) {
  if (array.ndim() != 2)
    throw mtf::UsageError(name + ": has the shape " + shape_text(array) +
                          "; a plane has two dimensions, (rows, columns)");
  if (array.size() == 0) throw mtf::UsageError(name + ": has no values, its shape is " + shape_text(array));
}

bool is_masked(const py::object& array) {
  return py::hasattr(array, "mask") && py::hasattr(array, "filled") && py::hasattr(array, "fill_value");
}

/// An array whose memory was mapped from a file that was closed: its addresses are no longer there.
void require_open(const py::array& array, const std::string& name) {
  py::object owner = array;
  while (owner && py::isinstance<py::array>(owner)) owner = py::reinterpret_borrow<py::array>(owner).base();
  if (!owner || owner.is_none() || std::string(Py_TYPE(owner.ptr())->tp_name) != "mmap.mmap") return;
  if (owner.attr("closed").cast<bool>()) throw mtf::UsageError(name + ": is mapped from a file that was closed");
}

}  // namespace

PlaneView plane_of(const py::object& object, const std::string& name) {
  if (is_masked(object))
    throw mtf::UsageError(name +
                          ": is a masked array; say what stands for the masked values, such as a.filled(numpy.nan) "
                          "with nan=\"fill\"");
  if (object.is_none()) throw mtf::UsageError(name + ": is None; give a 2-D array of numbers");
  py::array array = py::array::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw mtf::UsageError(name + ": is no array of numbers; give a 2-D numpy array");
  }
  require_open(array, name);
  const char kind = array.dtype().kind();
  if (std::string("biuf").find(kind) == std::string::npos)
    throw mtf::UsageError(
        name + ": holds values of type " + dtype_text(array) +
        (kind == 'c' ? "; take its real part or its modulus" : "; give integers or floating-point numbers"));
  require_plane(array, name);
  if (!is_float32(array) || !has_rows(array)) {
    const py::module_ numpy = py::module_::import("numpy");
    // A number beyond float32 becomes infinite. Whoever takes the values refuses infinite ones and names the place.
    const py::object quiet = numpy.attr("errstate")("over"_a = "ignore");
    quiet.attr("__enter__")();
    array = numpy.attr("array")(array, "dtype"_a = "float32", "order"_a = "C", "copy"_a = true);
    quiet.attr("__exit__")(py::none(), py::none(), py::none());
  }
  const auto* data = static_cast<const float*>(array.data());
  return {array, {data, array.shape(1), array.shape(0), stride_of(array)}};
}

mtf::ImageView<float> target_of(const py::object& object, std::int64_t width, std::int64_t height,
                                const std::string& name) {
  if (!py::isinstance<py::array>(object) || is_masked(object))
    throw mtf::UsageError(name + ": is no numpy array to write into; give numpy.empty((" + std::to_string(height) +
                          ", " + std::to_string(width) + "), \"float32\")");
  auto array = py::reinterpret_borrow<py::array>(object);
  require_open(array, name);
  if (!is_float32(array))
    throw mtf::UsageError(name + ": holds " + dtype_text(array) + "; the result is written as float32");
  require_plane(array, name);
  if (array.shape(1) != width || array.shape(0) != height)
    throw mtf::UsageError(name + ": has the shape " + shape_text(array) + ", the result has (" +
                          std::to_string(height) + ", " + std::to_string(width) + ")");
  if (!array.writeable()) throw mtf::UsageError(name + ": is read-only; give an array that can be written");
  if (!has_rows(array)) throw mtf::UsageError(name + ": has its values in another order than row after row");
  return {static_cast<float*>(array.mutable_data()), width, height, stride_of(array)};
}

mtf::Image image_of(const mtf::ImageView<const float>& view) {
  mtf::Image image(view.width, view.height);
  for (std::int64_t y = 0; y < view.height; ++y) std::copy(view.row(y), view.row(y) + view.width, image.view().row(y));
  return image;
}

py::array to_numpy(mtf::Image&& image) {
  auto* owner = new mtf::Image(std::move(image));
  const py::capsule free(owner, [](void* p) { delete static_cast<mtf::Image*>(p); });
  constexpr auto kSize = static_cast<std::int64_t>(sizeof(float));
  return py::array_t<float>({owner->height(), owner->width()}, {owner->width() * kSize, kSize}, owner->data(), free);
}

py::array to_numpy(std::vector<double>&& numbers) {
  auto* owner = new std::vector<double>(std::move(numbers));
  const py::capsule free(owner, [](void* p) { delete static_cast<std::vector<double>*>(p); });
  return py::array_t<double>({static_cast<py::ssize_t>(owner->size())}, {sizeof(double)}, owner->data(), free);
}

py::array to_numpy(const std::vector<double>& numbers) { return to_numpy(std::vector<double>(numbers)); }

std::function<void(mtf::io::Scene&)> light_filter(const py::object& function) {
  if (function.is_none()) return {};
  return [filter = py::handle(function)](mtf::io::Scene& scene) {
    const py::gil_scoped_acquire held;
    for (mtf::Image& plane : scene.planes)
      plane = image_of(plane_of(filter(to_numpy(std::move(plane))), "the filtered scene").view);
    scene.grid.width = scene.planes.front().width();
    scene.grid.height = scene.planes.front().height();
  };
}

}  // namespace apps::python
