// The parts of the extension module raywalk._native, each bound in a file of its own. What users
// see of them, with its documentation, is in the Python files of raywalk/.
#pragma once

#include <pybind11/pybind11.h>

namespace raywalk::python {

// Room with its lines, cells, frames and distances.
void bind_room(pybind11::module_& module);
// What renders views of a room.
void bind_views(pybind11::module_& module);
// Of the last single view; the next one is rendered as set since.
void forget_renderer();
// Picture files, and what compares pictures.
void bind_pictures(pybind11::module_& module);

}  // namespace raywalk::python
