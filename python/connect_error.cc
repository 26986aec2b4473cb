// The measured connection error, (11) of the paper.
#include "core/evaluate/connect_error.h"

#include <pybind11/stl.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/room.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

py::array column(const nlohmann::ordered_json& rows, const char* key) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const nlohmann::ordered_json& row : rows) values.push_back(row[key].get<double>());
  return read_only_copy(std::span<const double>(values), {std::ssize(values)});
}

// The fields of raywalk.ConnectError. No list of k means that of the command.
py::dict connect_error(const Room& room, const std::string& method, int viewpoints,
                       double overlap_deg, const std::optional<std::vector<double>>& k_list_deg) {
  ConnectErrorOptions options{.viewpoints = viewpoints, .overlap_deg = overlap_deg};
  if (k_list_deg) options.k_list_deg = *k_list_deg;
  const ViewMethod wanted = method_from_name(method);
  const nlohmann::ordered_json measured =
      without_lock([&] { return measure_connect_error(room, wanted, options); });
  py::dict fields;
  for (const char* key : {"k_deg", "e_connect", "e_connect_common", "coverage"}) {
    fields[key] = column(measured["rows"], key);
  }
  fields["common_share"] = measured["connection"]["common_share"].get<double>();
  return fields;
}

}  // namespace

void bind_connect_error(py::module_& module) { module.def("connect_error", &connect_error); }

}  // namespace raywalk::python
