// The measured connection error, (11) of the paper.
#include "core/evaluate/connect_error.h"

#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/room.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

template <typename Member>
py::array column(const std::vector<ConnectErrorAtK>& rows, Member member) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const ConnectErrorAtK& row : rows) values.push_back(row.*member);
  return read_only_copy(std::span<const double>(values), {std::ssize(values)});
}

// The fields of raywalk.ConnectError. No list of k means that of the command.
py::dict connect_error(const Room& room, const std::string& generation, int viewpoints,
                       double overlap_deg, const std::optional<std::vector<double>>& k_list_deg) {
  ConnectErrorOptions options{.viewpoints = viewpoints, .overlap_deg = overlap_deg};
  if (k_list_deg) options.k_list_deg = *k_list_deg;
  const Generation wanted = generation_from_name(generation);
  const ConnectError measured =
      without_lock([&] { return measure_connect_error(room, wanted, options); });
  py::dict fields;
  fields["k_deg"] = column(measured.rows, &ConnectErrorAtK::k_deg);
  fields["e_connect"] = column(measured.rows, &ConnectErrorAtK::e_connect);
  fields["e_connect_common"] = column(measured.rows, &ConnectErrorAtK::e_connect_common);
  fields["coverage"] = column(measured.rows, &ConnectErrorAtK::coverage);
  fields["common_share"] = measured.common_share;
  return fields;
}

}  // namespace

void bind_connect_error(py::module_& module) { module.def("connect_error", &connect_error); }

}  // namespace raywalk::python
