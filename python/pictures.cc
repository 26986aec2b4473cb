#include "python/pictures.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/evaluate/fsim.h"
#include "core/evaluate/metrics.h"
#include "core/files/image_file.h"
#include "python/bindings.h"
#include "python/work.h"
#include "render/view/view_file.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

using Bytes = py::array_t<std::uint8_t, py::array::c_style>;

cv::Mat mat_of(const Bytes& array, int type) {
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type,
          const_cast<std::uint8_t*>(array.data())};
}

// A picture that Python gave, uint8 (height, width, 3), red, green, blue, with any strides, in
// OpenCV's order. Throws UsageError that calls it `name` for anything else.
cv::Mat bgr_of(const py::object& picture, const std::string& name) {
  const py::array given = py::array::ensure(picture);
  if (!given || !py::isinstance<py::array_t<std::uint8_t>>(given) || given.ndim() != 3 ||
      given.shape(2) != 3 ||
      std::max(given.shape(0), given.shape(1)) > std::numeric_limits<int>::max()) {
    throw UsageError(
        fmt::format("{} is {}; give uint8 (height, width, 3), red, green, blue", name,
                    given ? std::string(py::str("{} {}").format(given.dtype(), given.attr("shape")))
                          : "no array"));
  }
  const Bytes rgb(given);
  cv::Mat bgr;
  if (rgb.size() > 0) cv::cvtColor(mat_of(rgb, CV_8UC3), bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

// A mask that Python gave, bool or uint8 (height, width); empty for None.
cv::Mat mask_of(const py::object& mask) {
  if (mask.is_none()) return {};
  const py::array given = py::array::ensure(mask);
  if (!given || given.ndim() != 2 ||
      !(py::isinstance<py::array_t<bool>>(given) ||
        py::isinstance<py::array_t<std::uint8_t>>(given))) {
    throw UsageError("mask is no array (height, width) of bool or uint8");
  }
  return mat_of(Bytes(given), CV_8UC1).clone();
}

template <double (*metric)(const cv::Mat&, const cv::Mat&)>
double compare(const py::object& a, const py::object& b) {
  const cv::Mat bgr_a = bgr_of(a, "a"), bgr_b = bgr_of(b, "b");
  return without_lock([&] { return metric(bgr_a, bgr_b); });
}

template <double (*metric)(const cv::Mat&, const cv::Mat&, const cv::Mat&)>
double compare_masked(const py::object& a, const py::object& b, const py::object& mask) {
  const cv::Mat bgr_a = bgr_of(a, "a"), bgr_b = bgr_of(b, "b"), pixels = mask_of(mask);
  return without_lock([&] { return metric(bgr_a, bgr_b, pixels); });
}

py::array read_rgb(const std::filesystem::path& file) {
  return array_of(without_lock([&file] {
    cv::Mat picture = read_picture(file);
    cv::cvtColor(picture, picture, cv::COLOR_BGR2RGB);
    return picture;
  }));
}

void write_rgb(const std::filesystem::path& file, const py::object& picture) {
  const cv::Mat bgr = bgr_of(picture, "picture");
  without_lock([&] {
    render::require_writable_picture(file);
    write_image(file, bgr);
    return true;
  });
}

}  // namespace

py::array array_of(cv::Mat rgb) {
  if (!rgb.isContinuous()) rgb = rgb.clone();
  const std::vector<py::ssize_t> shape{rgb.rows, rgb.cols, rgb.channels()};
  const std::uint8_t* data = rgb.data;
  return py::array(py::dtype::of<std::uint8_t>(), shape, data, keeping(std::move(rgb)));
}

void bind_pictures(py::module_& module) {
  module.def("read_picture", &read_rgb);
  module.def("write_picture", &write_rgb);
  module.def("mean_squared_error", &compare_masked<&mean_squared_error>);
  module.def("psnr_db", &compare_masked<&psnr_db>);
  module.def("ws_psnr_db", &compare_masked<&ws_psnr_db>);
  module.def("ssim", &compare<&ssim>);
  module.def("fsim", &compare<&fsim>);
}

}  // namespace raywalk::python
