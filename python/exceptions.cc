// Exceptions of the libraries as Python's, with the words that the programs print.
#include <filesystem>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "python/bindings.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// Kept for as long as the process lives, as exceptions may be translated until its end.
PyObject* error_type = nullptr;
PyObject* usage_error_type = nullptr;

// Escaped, as the programs print it: a file's name need not be UTF-8.
void raise(PyObject* type, const std::string& message) {
  PyErr_SetString(type, escaped(message).c_str());
}

// By value, as pybind11 calls it.
void translate(std::exception_ptr thrown) {  // NOLINT(performance-unnecessary-value-param)
  if (!thrown) return;
  try {
    std::rethrow_exception(thrown);
  } catch (const UsageError& e) {
    raise(usage_error_type, e.what());
  } catch (const std::filesystem::filesystem_error& e) {
    raise(error_type, e.path1().string() + ": " + e.code().message());
  } catch (const Error& e) {
    raise(error_type, e.what());
  } catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) {
      PyErr_NoMemory();
    } else {
      raise(error_type,
            "a step failed in a way it should not; please report it (" + one_line(e.what()) + ")");
    }
  }
}

}  // namespace

void bind_exceptions(py::module_& module) {
  error_type = PyErr_NewExceptionWithDoc("raywalk.Error",
                                         "Bad input, or a file that cannot be read or written.",
                                         PyExc_RuntimeError, nullptr);
  if (error_type == nullptr) throw py::error_already_set();
  const py::tuple bases = py::make_tuple(py::handle(error_type), py::handle(PyExc_ValueError));
  usage_error_type = PyErr_NewExceptionWithDoc(
      "raywalk.UsageError", "An argument out of range, or arguments that contradict each other.",
      bases.ptr(), nullptr);
  if (usage_error_type == nullptr) throw py::error_already_set();
  module.attr("Error") = py::handle(error_type);
  module.attr("UsageError") = py::handle(usage_error_type);
  py::register_local_exception_translator(translate);
}

}  // namespace raywalk::python
