// The measured connection error, (11) of the paper.
#include "core/evaluate/validation/connect_error.h"

#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "core/evaluate/validation/connect_error_file.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/room.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

template <typename Member>
py::array column(const std::vector<ConnectErrorRow>& rows, Member member) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const ConnectErrorRow& row : rows) values.push_back(row.*member);
  return read_only_copy(std::span<const double>(values), {std::ssize(values)});
}

// The fields of raywalk.ConnectError. No list of k means that of the command. `store` keeps the
// measurement in the room, as the command does.
py::dict connect_error(const Room& room, const std::string& generation, int viewpoints,
                       double overlap_deg, const std::optional<std::vector<double>>& k_list_deg,
                       bool store) {
  ConnectErrorOptions options{.viewpoints = viewpoints, .overlap_deg = overlap_deg};
  if (k_list_deg) options.k_list_deg = *k_list_deg;
  const Generation wanted = generation_from_name(generation);
  const ConnectError measured = without_lock([&] {
    return store ? measure_and_store_connect_error(room, wanted, options)
                 : measure_connect_error(room, wanted, options);
  });
  py::dict fields;
  fields["k_deg"] = column(measured.rows, &ConnectErrorRow::k_deg);
  fields["e_connect"] = column(measured.rows, &ConnectErrorRow::e_connect);
  fields["e_connect_common"] = column(measured.rows, &ConnectErrorRow::e_connect_common);
  fields["coverage"] = column(measured.rows, &ConnectErrorRow::coverage);
  fields["common_share"] = measured.common_share;
  return fields;
}

}  // namespace

void bind_connect_error(py::module_& module) { module.def("connect_error", &connect_error); }

}  // namespace raywalk::python
