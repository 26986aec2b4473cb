#include "core/evaluate/kept_results.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"

namespace raywalk {

using nlohmann::ordered_json;

KeptResults::KeptResults(std::filesystem::path file) : file_(std::move(file)) {
  const AtomicFile probe(file_);
  std::error_code error;
  if (!std::filesystem::exists(file_, error)) return;
  // The first line is the checksum of the others.
  const std::string text = read_file(file_);
  const std::size_t line = std::min(text.find('\n'), text.size());
  const std::string json = text.substr(std::min(line + 1, text.size()));
  ordered_json results = ordered_json::parse(json, nullptr, false);
  if (text.substr(0, line) != sha256_hex(json) || !results.is_object()) {
    spdlog::warn("{}: damaged; what it held is measured again", file_.string());
    return;
  }
  results_ = std::move(results);
  spdlog::info("{}: {} of an earlier run", file_.string(), counted(results_.size(), "result"));
}

ordered_json KeptResults::get(const std::string& key, const std::function<ordered_json()>& make) {
  if (!results_.contains(key)) {
    // As it is read again: what is not finite is null.
    results_[key] = ordered_json::parse(json_text(make()));
    const std::string json = json_text(results_);
    write_file_atomically(file_, sha256_hex(json) + "\n" + json);
  }
  return results_[key];
}

std::vector<ordered_json> KeptResults::get_all(
    std::span<const std::string> keys, const std::string& what, const std::string& unit,
    const std::function<ordered_json(std::size_t)>& make) {
  const auto missing =
      std::ranges::count_if(keys, [&](const auto& key) { return !results_.contains(key); });
  Progress progress(what, missing, unit);
  std::vector<ordered_json> results;
  results.reserve(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    throw_if_interrupted();
    results.push_back(get(keys[i], [&] {
      ordered_json made = make(i);
      progress.advance();
      return made;
    }));
  }
  return results;
}

void KeptResults::remove() {
  std::error_code error;
  std::filesystem::remove(file_, error);
  if (error) throw Error(fmt::format("cannot remove {}: {}", file_.string(), error.message()));
}

}  // namespace raywalk
