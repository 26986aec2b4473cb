// Memory of the libraries as NumPy arrays, and pictures from them.
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

namespace raywalk::python {

// A read-only array (height, width) or (height, width, channels) on columns [width][height]
// [channels] of memory that `owner` keeps alive as long as the array lives.
template <typename T>
pybind11::array picture_of_columns(const T* columns, int width, int height, int channels,
                                   std::shared_ptr<const void> owner);

// A read-only copy.
template <typename T>
pybind11::array read_only_copy(std::span<const T> values, std::vector<pybind11::ssize_t> shape);

// A new array (height, width, 3), red, green, blue, which takes over the memory of a picture,
// CV_8UC3 in that order.
pybind11::array array_of(cv::Mat rgb);

// A picture that Python gave, uint8 (height, width, 3), red, green, blue, with any strides. Throws
// UsageError that calls it `name` for anything else.
class GivenPicture {
 public:
  GivenPicture(const pybind11::object& picture, const std::string& name);

  // In OpenCV's order; needs no lock.
  cv::Mat bgr() const;

 private:
  pybind11::array_t<std::uint8_t, pybind11::array::c_style> array_;
  cv::Mat rgb_;  // on the array's memory
};

}  // namespace raywalk::python
