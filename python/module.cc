// The extension module raywalk._native.
#include "python/bindings.h"
#include "python/work.h"

PYBIND11_MODULE(_native, module) {
  using namespace raywalk::python;
  collect_warnings();
  module.attr("__version__") = RAYWALK_VERSION;
  bind_exceptions(module);
  bind_room(module);
  bind_views(module);
  bind_metrics(module);
  bind_pictures(module);
}
