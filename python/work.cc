#include "python/work.h"

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/escaped.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// How far up a warning belongs: beyond the Python files of the package.
constexpr int kCallerOfPackage = 2;

// Keeps what is logged until a thread that holds the interpreter's lock takes it.
class WarningSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    messages_.emplace_back(message.payload.data(), message.payload.size());
  }
  void flush_() override {}

 private:
  std::vector<std::string> messages_;
};

const std::shared_ptr<WarningSink>& warning_sink() {
  static const auto sink = std::make_shared<WarningSink>();
  return sink;
}

}  // namespace

void collect_warnings() {
  auto logger = std::make_shared<spdlog::logger>("raywalk", warning_sink());
  logger->set_level(spdlog::level::warn);
  spdlog::set_default_logger(std::move(logger));
}

void issue_warnings() {
  for (const std::string& message : warning_sink()->take()) {
    if (PyErr_WarnEx(PyExc_RuntimeWarning, escaped(message).c_str(), kCallerOfPackage) != 0) {
      throw py::error_already_set();
    }
  }
}

void drop_warnings() { warning_sink()->take(); }

}  // namespace raywalk::python
