// Rendering: views, many views, and the settings that views are rendered with.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/interrupt.h"
#include "core/evaluate/measured_settings.h"
#include "core/view/renderer.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/room.h"
#include "python/view_request.h"
#include "python/work.h"
#include "render/view/picture_format.h"
#include "render/view/view_file.h"
#include "render/view/view_path.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();

// What a Renderer shows, in Python's order of colours.
cv::Mat rgb_view(Renderer* renderer, const Viewpoint& viewpoint, const render::ViewFrame& frame) {
  cv::Mat picture = render::render_framed(renderer, viewpoint, frame).image;
  cv::cvtColor(picture, picture, cv::COLOR_BGR2RGB);
  return picture;
}

py::array view(const Room& room, double x_m, double z_m, std::optional<double> y_m,
               const py::dict& arguments) {
  const ViewRequest request = view_request(arguments);
  return array_of(without_lock([&] {
    Renderer renderer(room, chosen_mode(room, request).mode.options);
    return rgb_view(&renderer, {{x_m, z_m}, y_m}, request.frame);
  }));
}

// As `raywalk-render view` writes it, with metadata. Returns a summary.
std::string write_view(const Room& room, const std::filesystem::path& file, double x_m, double z_m,
                       std::optional<double> y_m, const py::dict& arguments) {
  const ViewRequest request = view_request(arguments);
  const render::PictureFormat format = render::picture_format(file);
  return without_lock([&] {
    return render::write_view(room, chosen_mode(room, request).mode, {{x_m, z_m}, y_m},
                              request.frame, file, format);
  });
}

// Many views of one room, rendered one by one as they are asked for.
class PathViews {
 public:
  PathViews(SharedRoom room, const ViewRequest& request, const std::filesystem::path& source,
            std::vector<render::PathView> views)
      : room_(std::move(room)), frame_(request.frame), views_(std::move(views)) {
    const ViewMode mode = chosen_mode(*room_, request).mode;
    render::require_renderable(*room_, mode, frame_, source, views_);
    renderer_ = std::make_unique<Renderer>(*room_, mode.options);
  }

  const std::vector<render::PathView>& views() const { return views_; }

  // The next view; empty after the last. One thread at a time renders. A view that was interrupted
  // is the next one again.
  cv::Mat next() {
    const std::lock_guard lock(mutex_);
    if (done_ == views_.size()) return {};
    const render::PathView& view = views_[done_];
    cv::Mat picture = rgb_view(renderer_.get(), view.viewpoint, render::turned_as(view, frame_));
    throw_if_interrupted();
    ++done_;
    return picture;
  }

 private:
  SharedRoom room_;
  render::ViewFrame frame_;
  std::vector<render::PathView> views_;
  std::unique_ptr<Renderer> renderer_;
  std::mutex mutex_;
  std::size_t done_ = 0;
};

using SharedPath = std::shared_ptr<PathViews>;

SharedPath path_of_file(const SharedRoom& room, const std::filesystem::path& file,
                        const py::dict& arguments) {
  const ViewRequest request = view_request(arguments);
  return without_lock(
      [&] { return std::make_shared<PathViews>(room, request, file, render::read_path(file)); });
}

// `rows` are x, y, z, yaw, pitch, roll; metres and degrees. A y that is not a number is that of the
// lines around.
SharedPath path_of_rows(const SharedRoom& room, const std::vector<std::array<double, 6>>& rows,
                        const py::dict& arguments) {
  const ViewRequest request = view_request(arguments);
  std::vector<render::PathView> views;
  views.reserve(rows.size());
  for (const auto& [x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg] : rows) {
    Viewpoint viewpoint(x_m, z_m);
    if (!std::isnan(y_m)) viewpoint.height_m = y_m;
    views.push_back({.name = std::to_string(views.size()),
                     .viewpoint = viewpoint,
                     .yaw_deg = yaw_deg,
                     .pitch_deg = pitch_deg,
                     .roll_deg = roll_deg});
  }
  return without_lock(
      [&] { return std::make_shared<PathViews>(room, request, "viewpoints", std::move(views)); });
}

py::array next_view(PathViews& path) {
  cv::Mat picture = without_lock([&path] { return path.next(); });
  if (picture.empty()) throw py::stop_iteration();
  return array_of(std::move(picture));
}

std::vector<std::string> names_of(const PathViews& path) {
  std::vector<std::string> names;
  for (const render::PathView& view : path.views()) names.push_back(view.name);
  return names;
}

py::array viewpoints_of(const PathViews& path) {
  std::vector<double> values;
  for (const render::PathView& view : path.views()) {
    const Viewpoint& at = view.viewpoint;
    values.insert(values.end(), {at.plan.x_m, at.height_m.value_or(kNoHeight), at.plan.z_m});
  }
  return read_only_copy(std::span<const double>(values),
                        {static_cast<py::ssize_t>(path.views().size()), 3});
}

std::string write_path(const Room& room, const std::filesystem::path& table,
                       const std::filesystem::path& out, bool replace, const py::dict& arguments) {
  const ViewRequest request = view_request(arguments);
  return without_lock([&] {
    return render::write_path(room, chosen_mode(room, request).mode, request.frame,
                              {.table = table}, {}, out, replace);
  });
}

// As settings files and views.json have it.
py::object parameter_value(const ViewParameter& parameter, const ViewOptions& options) {
  const nlohmann::ordered_json value = json_of(parameter, options);
  if (value.is_string()) return py::str(value.get<std::string>());
  if (value.is_number_integer()) return py::int_(value.get<int>());
  return py::float_(value.get<double>());
}

py::dict view_settings(const Room& room, const py::dict& arguments) {
  const ViewRequest request = view_request(arguments);
  const ChosenMode chosen = without_lock([&] { return chosen_mode(room, request); });
  py::dict settings;
  for (const ViewParameter& parameter : kViewParameters) {
    settings[parameter.key] = parameter_value(parameter, chosen.mode.options);
  }
  settings["connection"] = chosen.mode.connection;
  settings["k_source"] = chosen.mode.k_source;
  settings["reason"] = chosen.reason;
  return settings;
}

}  // namespace

void bind_views(py::module_& module) {
  py::class_<PathViews, SharedPath>(module, "PathViews")
      .def("names", &names_of)
      .def("viewpoints_m", &viewpoints_of)
      .def("next_view", &next_view);
  module.def("view", &view);
  module.def("write_view", &write_view);
  module.def("path_of_file", &path_of_file);
  module.def("path_of_rows", &path_of_rows);
  module.def("write_path", &write_path);
  module.def("view_settings", &view_settings);
}

}  // namespace raywalk::python
