#include "core/base/quiet.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <iostream>

namespace raywalk {
namespace {

std::atomic<bool> quiet{false};

void flush_stdout() {
  std::cout.flush();
  std::fflush(stdout);
}

}  // namespace

Quiet::Quiet(bool results) {
  quiet = true;
  spdlog::set_level(spdlog::level::warn);
  if (!results) return;
  flush_stdout();
  saved_stdout_ = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (null < 0) return;
  dup2(null, STDOUT_FILENO);
  close(null);
}

Quiet::~Quiet() {
  if (saved_stdout_ >= 0) {
    flush_stdout();
    dup2(saved_stdout_, STDOUT_FILENO);
    close(saved_stdout_);
  }
  spdlog::set_level(spdlog::level::info);
  quiet = false;
}

bool is_quiet() { return quiet; }

}  // namespace raywalk
