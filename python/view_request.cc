#include "python/view_request.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/files/words.h"
#include "core/view/view_options.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// The value of a parameter as it is written in a settings file.
std::string parameter_text(const ViewParameter& parameter, const py::handle& value) {
  const bool on_or_off = !parameter.names.empty() && parameter.names.data() == kOffOn.data();
  if (on_or_off && py::isinstance<py::bool_>(value)) return kOffOn.at(value.cast<bool>() ? 1 : 0);
  return py::str(value);
}

double number(const std::string& key, const py::handle& value) {
  try {
    return py::float_(py::reinterpret_borrow<py::object>(value));
  } catch (const py::error_already_set&) {
    throw UsageError(
        fmt::format("{} is {}; give a number", key, excerpt(std::string(py::str(value)))));
  }
}

template <typename Names>
std::string one_of(const std::string& key, const py::handle& value, const Names& names) {
  std::string name = py::str(value);
  if (std::ranges::find(names, name) != names.end()) return name;
  throw UsageError(fmt::format("{} is {}{}", key, excerpt(name),
                               suggestion(name, {names.begin(), names.end()})));
}

// "1440x1600" of (1440, 1600).
std::string size_text(const py::handle& value) {
  if (py::isinstance<py::sequence>(value) && !py::isinstance<py::str>(value)) {
    const auto size = py::reinterpret_borrow<py::sequence>(value);
    if (size.size() == 2) {
      return fmt::format("{}x{}", std::string(py::str(size[0])), std::string(py::str(size[1])));
    }
  }
  throw UsageError(fmt::format("size_px is {}; give (width, height) in pixels",
                               excerpt(std::string(py::str(value)))));
}

// A keyword argument that is no parameter.
struct Keyword {
  const char* key;
  void (*set)(const std::string& key, const py::handle& value, ViewRequest* request);
};

template <double render::ViewFrame::*member>
void set_number(const std::string& key, const py::handle& value, ViewRequest* request) {
  request->frame.*member = number(key, value);
}

constexpr auto
    kKeywords =
        std::to_array<Keyword>(
            {
                {"settings",
                 [](const std::string& /*key*/, const py::handle& value, ViewRequest* request) {
                   const auto path = py::reinterpret_steal<py::object>(PyOS_FSPath(value.ptr()));
                   if (!path) throw py::error_already_set();
                   request->flags.settings = path.cast<std::filesystem::path>();
                 }},
                {"preset",
                 [](const std::string& key, const py::handle& value, ViewRequest* request) {
                   request->flags.preset = one_of(key, value, render::kPresets);
                 }},
                {"connection",
                 [](const std::string& key, const py::handle& value, ViewRequest* request) {
                   request->flags.connection = one_of(key, value, render::kConnections);
                 }},
                {"budget_ms",
                 [](const std::string& key, const py::handle& value, ViewRequest* request) {
                   request->demand.budget_ms = number(key, value);
                 }},
                {"min_psnr_db",
                 [](const std::string& key, const py::handle& value, ViewRequest* request) {
                   request->demand.min_psnr_db = number(key, value);
                 }},
                {"yaw_deg", &set_number<&render::ViewFrame::yaw_deg>},
                {"pitch_deg", &set_number<&render::ViewFrame::pitch_deg>},
                {"roll_deg", &set_number<&render::ViewFrame::roll_deg>},
                {"fov_deg", &set_number<&render::ViewFrame::fov_deg>},
                {"size_px", [](const std::string& /*key*/, const py::handle& value,
                               ViewRequest* request) { request->frame.size = size_text(value); }},
                {"stereo",
                 [](const std::string& key, const py::handle& value, ViewRequest* request) {
                   one_of(key, value, std::array{"ods"});
                   request->frame.stereo = render::Stereo::kOds;
                 }},
                {"ipd_mm", &set_number<&render::ViewFrame::ipd_mm>},
            });

[[noreturn]] void throw_unknown(const std::string& key) {
  std::vector<std::string> known;
  known.reserve(kViewParameters.size() + kKeywords.size());
  for (const ViewParameter& parameter : kViewParameters) known.emplace_back(parameter.key);
  for (const Keyword& keyword : kKeywords) known.emplace_back(keyword.key);
  throw py::type_error("unexpected keyword argument " + excerpt(key) + suggestion(key, known));
}

// Whether or not it is given, a key has to be known.
void set_argument(const std::string& key, const py::handle& value, ViewRequest* request) {
  const auto* parameter = std::ranges::find(kViewParameters, key, &ViewParameter::key);
  const auto* keyword = std::ranges::find(kKeywords, key, &Keyword::key);
  const bool is_parameter = parameter != kViewParameters.end();
  if (!is_parameter && keyword == kKeywords.end()) throw_unknown(key);
  if (value.is_none()) return;
  if (is_parameter) {
    request->flags.parameters[key] = parameter_text(*parameter, value);
  } else {
    keyword->set(key, value, request);
  }
}

}  // namespace

ViewRequest view_request(const py::dict& arguments) {
  ViewRequest request;
  for (const auto& [key, value] : arguments) {
    set_argument(key.cast<std::string>(), value, &request);
  }
  render::view_settings(request.flags);
  render::require_demand(request.demand);
  render::viewport_of(request.frame);
  return request;
}

ChosenMode chosen_mode(const Room& room, const ViewRequest& request) {
  const render::Preset chosen = render::settings_for(request.flags, request.demand, room);
  return {render::mode_of(chosen), chosen.reason};
}

}  // namespace raywalk::python
