// Rendering: views, many views, and the settings that views are rendered with.
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/evaluate/measured_settings.h"
#include "core/files/words.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "core/view/view_mode.h"
#include "core/view/view_options.h"
#include "python/bindings.h"
#include "python/pictures.h"
#include "python/work.h"
#include "render/view/measured_choice.h"
#include "render/view/picture_format.h"
#include "render/view/presets.h"
#include "render/view/view_file.h"
#include "render/view/view_frame.h"
#include "render/view/view_path.h"
#include "render/view/view_settings.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// A keyword argument that is not None.
class Argument {
 public:
  Argument(std::string key, const py::handle& value) : key_(std::move(key)), value_(value) {}

  std::string text() const { return py::str(value_); }

  // As it is written in a settings file.
  std::string parameter_text() const {
    return py::isinstance<py::bool_>(value_) ? kOffOn.at(value_.cast<bool>() ? 1 : 0) : text();
  }

  // Throws UsageError, which says what is wanted, where the value is something else.
  template <typename T>
  T as(const char* wanted) const {
    try {
      return value_.cast<T>();
    } catch (const py::cast_error&) {
      throw UsageError(fmt::format("{} is {}; give {}", key_, excerpt(text()), wanted));
    }
  }

  double number() const { return as<double>("a number"); }

  template <typename Names>
  std::string one_of(const Names& names) const {
    if (std::ranges::find(names, text()) != names.end()) return text();
    throw UsageError(fmt::format("{} is {}{}", key_, excerpt(text()),
                                 suggestion(text(), {names.begin(), names.end()})));
  }

 private:
  std::string key_;
  py::handle value_;
};

// The keyword arguments of Room.view and Room.path.
struct ViewRequest {
  // Keys are those of the parameters (core/view/view_options.h) and of keywords(); values that are
  // None count as not given. Throws TypeError for an unknown key, UsageError for values that are
  // out of range or contradict each other, before any work.
  explicit ViewRequest(const py::dict& arguments);

  // Chosen for a room as the programs do.
  render::Preset settings(const Room& room) const {
    return render::settings_for(flags, demand, room);
  }
  ViewMode mode(const Room& room) const { return render::mode_of(settings(room)); }

  render::ViewFlags flags{};
  render::Demand demand{};
  render::ViewFrame frame{};

 private:
  using Set = std::function<void(const Argument&)>;

  // What sets the arguments that are no parameters.
  std::map<std::string, Set> keywords();
};

std::map<std::string, ViewRequest::Set> ViewRequest::keywords() {
  const auto number = [](auto* member) -> Set {
    return [member](const Argument& given) { *member = given.number(); };
  };
  return {
      {"settings",
       [this](const Argument& given) {
         flags.settings = given.as<std::filesystem::path>("a file");
       }},
      {"preset", [this](const Argument& given) { flags.preset = given.one_of(render::kPresets); }},
      {"connection",
       [this](const Argument& given) { flags.connection = given.one_of(render::kConnections); }},
      {"budget_ms", number(&demand.budget_ms)},
      {"min_psnr_db", number(&demand.min_psnr_db)},
      {"yaw_deg", number(&frame.yaw_deg)},
      {"pitch_deg", number(&frame.pitch_deg)},
      {"roll_deg", number(&frame.roll_deg)},
      {"fov_deg", number(&frame.fov_deg)},
      {"size_px",
       [this](const Argument& given) {
         const auto [width, height] = given.as<std::pair<int, int>>("(width, height) in pixels");
         frame.size = fmt::format("{}x{}", width, height);
       }},
      {"stereo",
       [this](const Argument& given) {
         given.one_of(std::array{"ods"});
         frame.stereo = render::Stereo::kOds;
       }},
      {"ipd_mm", number(&frame.ipd_mm)},
  };
}

ViewRequest::ViewRequest(const py::dict& arguments) {
  const std::map<std::string, Set> known = keywords();
  for (const auto& [name, value] : arguments) {
    const auto key = name.cast<std::string>();
    const auto keyword = known.find(key);
    const bool is_parameter = std::ranges::count(kViewParameters, key, &ViewParameter::key) > 0;
    if (!is_parameter && keyword == known.end()) {
      std::vector<std::string> keys;
      keys.reserve(kViewParameters.size() + known.size());
      for (const ViewParameter& parameter : kViewParameters) keys.emplace_back(parameter.key);
      for (const auto& [other, set] : known) keys.push_back(other);
      throw py::type_error("unexpected keyword argument " + excerpt(key) + suggestion(key, keys));
    }
    if (value.is_none()) continue;
    const Argument given(key, value);
    if (is_parameter) {
      flags.parameters[key] = given.parameter_text();
    } else {
      keyword->second(given);
    }
  }
  render::view_settings(flags);
  render::require_demand(demand);
  render::viewport_of(frame);
}

// What a Renderer shows, in Python's order of colours.
cv::Mat rgb_view(Renderer* renderer, const Viewpoint& viewpoint, const render::ViewFrame& frame) {
  cv::Mat picture = render::render_framed(renderer, viewpoint, frame).image;
  cv::cvtColor(picture, picture, cv::COLOR_BGR2RGB);
  return picture;
}

// The renderer of the last single view, with what it read of the room and holds on a card: the next
// view has the same settings as a rule. It keeps its room open.
struct KeptRenderer {
  std::shared_ptr<Room> room;
  ViewOptions options;
  std::unique_ptr<Renderer> renderer;
};

// Never destroyed: the end of a program may come after that of a card's driver.
struct Kept {
  std::mutex mutex;
  std::optional<KeptRenderer> last;
};
Kept& kept() {
  static auto* const kept = new Kept;
  return *kept;
}

// The kept one, if it fits, for one thread at a time; else a new one.
KeptRenderer take_renderer(const std::shared_ptr<Room>& room, const ViewOptions& options) {
  std::optional<KeptRenderer> taken;
  {
    const std::lock_guard lock(kept().mutex);
    taken = std::exchange(kept().last, std::nullopt);
  }
  if (taken && taken->room == room && taken->options == options) return *std::move(taken);
  taken.reset();  // before the card holds another room
  return {room, options, std::make_unique<Renderer>(*room, options)};
}

py::array view(const std::shared_ptr<Room>& room, double x_m, double z_m, std::optional<double> y_m,
               const py::dict& arguments) {
  const ViewRequest request(arguments);
  return array_of(without_lock([&] {
    KeptRenderer taken = take_renderer(room, request.mode(*room).options);
    cv::Mat picture = rgb_view(taken.renderer.get(), {{x_m, z_m}, y_m}, request.frame);
    const std::lock_guard lock(kept().mutex);
    kept().last.emplace(std::move(taken));  // another one goes before its room
    return picture;
  }));
}

// As `raywalk-render view` writes it, with metadata. Returns a summary.
std::string write_view(const Room& room, const std::filesystem::path& file, double x_m, double z_m,
                       std::optional<double> y_m, const py::dict& arguments) {
  const ViewRequest request(arguments);
  const render::PictureFormat format = render::picture_format(file);
  return without_lock([&] {
    return render::write_view(room, request.mode(room), {{x_m, z_m}, y_m}, request.frame, file,
                              format);
  });
}

// Many views of one room, rendered one by one as they are asked for.
class PathViews {
 public:
  PathViews(std::shared_ptr<Room> room, const ViewRequest& request,
            const std::filesystem::path& source, std::vector<render::PathView> views)
      : room_(std::move(room)), frame_(request.frame), views_(std::move(views)) {
    const ViewMode mode = request.mode(*room_);
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
  std::shared_ptr<Room> room_;
  render::ViewFrame frame_;
  std::vector<render::PathView> views_;
  std::unique_ptr<Renderer> renderer_;
  std::mutex mutex_;
  std::size_t done_ = 0;
};

using SharedPath = std::shared_ptr<PathViews>;

SharedPath path_of_file(const std::shared_ptr<Room>& room, const std::filesystem::path& file,
                        const py::dict& arguments) {
  const ViewRequest request(arguments);
  return without_lock(
      [&] { return std::make_shared<PathViews>(room, request, file, render::read_path(file)); });
}

// `rows` are x, y, z, yaw, pitch, roll; metres and degrees. A y that is not a number is that of the
// lines around.
SharedPath path_of_rows(const std::shared_ptr<Room>& room,
                        const std::vector<std::array<double, 6>>& rows, const py::dict& arguments) {
  const ViewRequest request(arguments);
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

// x, y, z; y is not a number where it is that of the lines around.
std::vector<std::array<double, 3>> viewpoints_of(const PathViews& path) {
  constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::array<double, 3>> viewpoints;
  for (const render::PathView& view : path.views()) {
    const Viewpoint& at = view.viewpoint;
    viewpoints.push_back({at.plan.x_m, at.height_m.value_or(kNoHeight), at.plan.z_m});
  }
  return viewpoints;
}

std::string write_path(const Room& room, const std::filesystem::path& table,
                       const std::filesystem::path& out, bool replace, const py::dict& arguments) {
  const ViewRequest request(arguments);
  return without_lock([&] {
    return render::write_path(room, request.mode(room), request.frame, {.table = table}, {}, out,
                              replace);
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
  const ViewRequest request(arguments);
  const render::Preset chosen = without_lock([&] { return request.settings(room); });
  const ViewMode mode = render::mode_of(chosen);
  py::dict settings;
  for (const ViewParameter& parameter : kViewParameters) {
    settings[parameter.key] = parameter_value(parameter, mode.options);
  }
  settings["connection"] = mode.connection;
  settings["k_source"] = mode.k_source;
  settings["reason"] = chosen.reason;
  return settings;
}

}  // namespace

void forget_renderer() {
  const std::lock_guard lock(kept().mutex);
  kept().last.reset();
}

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
