#include "python/arrays.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/error.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// A capsule that keeps an object alive.
template <typename Owner>
py::capsule keeping(Owner owner) {
  return {new Owner(std::move(owner)), [](void* kept) { delete static_cast<Owner*>(kept); }};
}

// NumPy refuses to make an array writable again whose base is no writable buffer, as a capsule.
py::array read_only(py::array array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    text += fmt::format("{}{}", i > 0 ? ", " : "", array.shape(i));
  }
  return text + (array.ndim() == 1 ? ",)" : ")");
}

}  // namespace

template <typename T>
py::array picture_of_columns(const T* columns, int width, int height, int channels,
                             std::shared_ptr<const void> owner) {
  const auto pixel = static_cast<py::ssize_t>(sizeof(T)) * channels;
  std::vector<py::ssize_t> shape{height, width};
  std::vector<py::ssize_t> strides{pixel, pixel * height};
  if (channels > 1) {
    shape.push_back(channels);
    strides.push_back(sizeof(T));
  }
  return read_only(py::array(py::dtype::of<T>(), std::move(shape), std::move(strides), columns,
                             keeping(std::move(owner))));
}

template py::array picture_of_columns(const std::uint8_t*, int, int, int,
                                      std::shared_ptr<const void>);
template py::array picture_of_columns(const float*, int, int, int, std::shared_ptr<const void>);

template <typename T>
py::array read_only_copy(std::span<const T> values, std::vector<py::ssize_t> shape) {
  return read_only(py::array(py::dtype::of<T>(), std::move(shape), values.data()));
}

template py::array read_only_copy(std::span<const double>, std::vector<py::ssize_t>);
template py::array read_only_copy(std::span<const int>, std::vector<py::ssize_t>);

py::array array_of(cv::Mat rgb) {
  if (!rgb.isContinuous()) rgb = rgb.clone();
  const std::vector<py::ssize_t> shape{rgb.rows, rgb.cols, rgb.channels()};
  const std::uint8_t* data = rgb.data;
  return py::array(py::dtype::of<std::uint8_t>(), shape, data, keeping(std::move(rgb)));
}

GivenPicture::GivenPicture(const py::object& picture, const std::string& name) {
  const py::array given = py::array::ensure(picture);
  if (!given) {
    PyErr_Clear();
    throw UsageError(name + " is no array; give uint8 (height, width, 3), red, green, blue");
  }
  constexpr py::ssize_t kMost = std::numeric_limits<int>::max();
  if (!given.dtype().equal(py::dtype::of<std::uint8_t>()) || given.ndim() != 3 ||
      given.shape(2) != 3 || given.shape(0) > kMost || given.shape(1) > kMost) {
    throw UsageError(fmt::format("{} is {} {}; give uint8 (height, width, 3), red, green, blue",
                                 name, std::string(py::str(given.dtype())), shape_text(given)));
  }
  array_ = py::array_t<std::uint8_t, py::array::c_style>(given);
  rgb_ = cv::Mat(static_cast<int>(given.shape(0)), static_cast<int>(given.shape(1)), CV_8UC3,
                 const_cast<std::uint8_t*>(array_.data()));
}

cv::Mat GivenPicture::bgr() const {
  cv::Mat converted;
  if (!rgb_.empty()) cv::cvtColor(rgb_, converted, cv::COLOR_RGB2BGR);
  return converted;
}

}  // namespace raywalk::python
