// Picture files, and how many threads and how much memory are used.
#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/image_file.h"
#include "core/room/tiled_rays.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/work.h"
#include "render/view/view_file.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

py::array read_rgb(const std::filesystem::path& file) {
  return array_of(without_lock([&file] {
    cv::Mat picture = read_picture(file);
    cv::cvtColor(picture, picture, cv::COLOR_BGR2RGB);
    return picture;
  }));
}

void write_rgb(const std::filesystem::path& file, const py::object& picture) {
  const GivenPicture given(picture, "picture");
  without_lock([&] {
    render::require_writable_picture(file);
    write_image(file, given.bgr());
  });
}

void set_cache_mb(double megabytes) {
  if (!(megabytes > 0.0 && megabytes <= 1e9)) {
    throw UsageError(fmt::format("a cache of {} MB; give more than 0, at most 1e9", megabytes));
  }
  TileCache::of_process().set_limit_bytes(static_cast<std::uint64_t>(1e6 * megabytes));
}

}  // namespace

void bind_pictures(py::module_& module) {
  module.def("read_picture", &read_rgb);
  module.def("write_picture", &write_rgb);
  module.def("set_thread_count", &set_thread_count);
  module.def("thread_count", &thread_count);
  module.def("set_cache_mb", &set_cache_mb);
}

}  // namespace raywalk::python
