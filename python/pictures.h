// Pictures as NumPy arrays.
#pragma once

#include <pybind11/numpy.h>

#include <opencv2/core/mat.hpp>
#include <utility>

namespace raywalk::python {

// A capsule that keeps an object alive: the base of an array on memory that the object holds.
template <typename Owner>
pybind11::capsule keeping(Owner owner) {
  return {new Owner(std::move(owner)), [](void* kept) { delete static_cast<Owner*>(kept); }};
}

// A new array (height, width, 3), red, green, blue, which takes over the memory of a picture,
// CV_8UC3 in that order.
pybind11::array array_of(cv::Mat rgb);

}  // namespace raywalk::python
