// The extension module raywalk._native: exceptions of the libraries as Python's, with the words
// that the programs print, and how many threads and how much memory are used.
#include <fmt/format.h>

#include <cstdint>
#include <exception>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/room/tiled_rays.h"
#include "core/view/gpu/gpu_device.h"
#include "python/bindings.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// raywalk.Error and raywalk.UsageError. Kept for as long as the process lives, as exceptions may be
// translated until its end.
PyObject* error_type = nullptr;
PyObject* usage_error_type = nullptr;

// Escaped, as the programs print it: a file's name need not be UTF-8.
void raise(PyObject* type, const std::string& message) {
  PyErr_SetString(type, escaped(message).c_str());
}

// Raises KeyboardInterrupt, or what the program's own SIGINT handler raised. The signal has also
// reached Python, whose handler is run here, so that it does not raise a second time in the
// caller's except block. On other threads than the main one it is not.
void raise_interrupt(const std::string& message) {
  const bool raised = PyErr_CheckSignals() != 0;
  if (raised && PyErr_ExceptionMatches(PyExc_KeyboardInterrupt) == 0) return;
  PyErr_Clear();
  raise(PyExc_KeyboardInterrupt, message);
}

// By value, as pybind11 calls it.
void translate(std::exception_ptr thrown) {  // NOLINT(performance-unnecessary-value-param)
  if (!thrown) return;
  try {
    std::rethrow_exception(thrown);
  } catch (const Interrupted& e) {
    raise_interrupt(e.what());
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

PyObject* new_exception(const char* name, const char* documentation, const py::handle& bases) {
  PyObject* type = PyErr_NewExceptionWithDoc(name, documentation, bases.ptr(), nullptr);
  if (type == nullptr) throw py::error_already_set();
  return type;
}

void bind_exceptions(py::module_& module) {
  error_type = new_exception(
      "raywalk.Error", "Bad input, or a file that cannot be read or written.", PyExc_RuntimeError);
  usage_error_type = new_exception(
      "raywalk.UsageError", "An argument out of range, or arguments that contradict each other.",
      py::make_tuple(py::handle(error_type), py::handle(PyExc_ValueError)));
  module.attr("Error") = py::handle(error_type);
  module.attr("UsageError") = py::handle(usage_error_type);
  py::register_local_exception_translator(translate);
}

void set_cache_mb(double megabytes) {
  if (!(megabytes > 0.0 && megabytes <= 1e9)) {
    throw UsageError(fmt::format("a cache of {} MB; give more than 0, at most 1e9", megabytes));
  }
  TileCache::of_process().set_limit_bytes(static_cast<std::uint64_t>(1e6 * megabytes));
}

// The name of the card that views are mixed on; none: the processor.
std::string set_device(const std::string& device, double gpu_mb) {
  if (!(gpu_mb >= 1.0 && gpu_mb <= 1e7)) {
    throw UsageError(fmt::format("{} MB of a graphics card; give 1 to 1e7", gpu_mb));
  }
  choose_device(device_from_name(device), gpu_mb);
  forget_renderer();
  return device_name();
}

}  // namespace
}  // namespace raywalk::python

PYBIND11_MODULE(_native, module) {
  using namespace raywalk::python;
  collect_warnings();
  module.attr("__version__") = RAYWALK_VERSION;
  bind_exceptions(module);
  bind_room(module);
  bind_views(module);
  bind_pictures(module);
  module.def("set_thread_count", &raywalk::set_thread_count);
  module.def("thread_count", &raywalk::thread_count);
  module.def("set_cache_mb", &set_cache_mb);
  module.def("set_device", &set_device, pybind11::arg("device"), pybind11::kw_only(),
             pybind11::arg("gpu_mb") = raywalk::kUsualGpu_mb);
}
