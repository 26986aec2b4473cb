// What compares pictures (core/evaluate/metrics.h, fsim.h).
#include "core/evaluate/metrics.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/evaluate/fsim.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

using MaskArray = py::array_t<std::uint8_t, py::array::c_style>;

// A mask that Python gave, bool or uint8 (height, width); an empty array for None.
MaskArray mask_array(const py::object& mask) {
  if (mask.is_none()) return MaskArray();
  const py::array given = py::array::ensure(mask);
  const bool fits = given && given.ndim() == 2 && given.itemsize() == 1 &&
                    (given.dtype().kind() == 'b' || given.dtype().kind() == 'u');
  PyErr_Clear();
  if (!fits) throw UsageError("mask is no array (height, width) of bool or uint8");
  return MaskArray(given.attr("astype")("uint8"));
}

cv::Mat mat_of(const MaskArray& mask) {
  if (mask.ndim() != 2) return {};
  return {static_cast<int>(mask.shape(0)), static_cast<int>(mask.shape(1)), CV_8UC1,
          const_cast<std::uint8_t*>(mask.data())};
}

template <double (*metric)(const cv::Mat&, const cv::Mat&)>
double compare(const py::object& a, const py::object& b) {
  const GivenPicture picture_a(a, "a"), picture_b(b, "b");
  return without_lock([&] { return metric(picture_a.bgr(), picture_b.bgr()); });
}

template <double (*metric)(const cv::Mat&, const cv::Mat&, const cv::Mat&)>
double compare_masked(const py::object& a, const py::object& b, const py::object& mask) {
  const GivenPicture picture_a(a, "a"), picture_b(b, "b");
  const MaskArray pixels = mask_array(mask);
  return without_lock([&] { return metric(picture_a.bgr(), picture_b.bgr(), mat_of(pixels)); });
}

}  // namespace

void bind_metrics(py::module_& module) {
  module.def("mean_squared_error", &compare_masked<&mean_squared_error>);
  module.def("psnr_db", &compare_masked<&psnr_db>);
  module.def("ws_psnr_db", &compare_masked<&ws_psnr_db>);
  module.def("ssim", &compare<&ssim>);
  module.def("fsim", &compare<&fsim>);
}

}  // namespace raywalk::python
