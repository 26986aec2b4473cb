#include "core/evaluate/kept_results.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// The file holds the checksum of the rest of it on its first line.
constexpr std::size_t kChecksumLine = 65;

// No object where the text is not what a run left.
ordered_json results_in(const std::string& text) {
  if (text.size() < kChecksumLine) return nullptr;
  const std::string json = text.substr(kChecksumLine);
  if (text.substr(0, kChecksumLine) != sha256_hex(json) + "\n") return nullptr;
  return ordered_json::parse(json, nullptr, false);
}

}  // namespace

KeptResults::KeptResults(std::filesystem::path file) : file_(std::move(file)) {
  const AtomicFile probe(file_);
  std::error_code error;
  if (!std::filesystem::exists(file_, error)) return;
  ordered_json results = results_in(read_file(file_));
  if (results.is_object()) {
    results_ = std::move(results);
    spdlog::info("{}: {} of an earlier run", file_.string(), counted(results_.size(), "result"));
  } else {
    spdlog::warn("{}: damaged; what it held is measured again", file_.string());
  }
}

const ordered_json* KeptResults::find(const std::string& key) const {
  const auto found = results_.find(key);
  return found == results_.end() ? nullptr : &*found;
}

void KeptResults::keep(const std::string& key, const ordered_json& result) {
  // As it is read again: what is not finite is null.
  results_[key] = ordered_json::parse(json_text(result));
  const std::string json = json_text(results_);
  write_file_atomically(file_, sha256_hex(json) + "\n" + json);
}

void KeptResults::remove() {
  std::error_code error;
  std::filesystem::remove(file_, error);
  if (error) throw Error(fmt::format("cannot remove {}: {}", file_.string(), error.message()));
}

}  // namespace raywalk
