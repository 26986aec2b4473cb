#include "capture/simulated/output_directory.h"

#include <fmt/format.h>

#include <system_error>

#include "core/base/error.h"
#include "core/files/output_path.h"
#include "core/files/temporary_names.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_cannot_create(const fs::path& target, const std::error_code& error) {
  throw Error(fmt::format("cannot create {}: {}", target.string(), error.message()));
}

void require_new(const fs::path& target) {
  if (target.empty()) throw UsageError("the output directory has no name; choose one with --out");
  require_absent(target, "--out");
}

fs::path create_beside(const fs::path& target) {
  fs::path partial = temporary_beside(target);
  std::error_code error;
  fs::create_directory(partial, error);
  if (error) throw_cannot_create(target, error);
  return partial;
}

}  // namespace

OutputDirectory::OutputDirectory(const fs::path& target)
    : target_(without_trailing_slash(target)),
      partial_((require_new(target_), create_beside(target_))) {}

OutputDirectory::~OutputDirectory() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(partial_, ignored);
}

fs::path OutputDirectory::make(const std::string& name) const {
  std::error_code error;
  fs::create_directory(partial_ / name, error);
  if (error) throw_cannot_create(target_ / name, error);
  return partial_ / name;
}

void OutputDirectory::commit() {
  require_absent(target_, "--out");
  std::error_code error;
  fs::rename(partial_, target_, error);
  if (error) throw_cannot_create(target_, error);
  committed_ = true;
}

}  // namespace raywalk::capture
