#include "calibrate/chain/step_records.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kRecordsFormatVersion = 1;
// Larger outputs are compared by size and time, as hashing all pictures takes long.
constexpr std::uintmax_t kLargestHashed_bytes = std::uintmax_t{1} << 20;

fs::path records_file(const fs::path& out) { return out / "steps.json"; }

std::string state_of(const fs::path& file) {
  const FileStamp stamp = stamp_of(file);
  if (stamp.bytes <= kLargestHashed_bytes) return sha256_of_file(file);
  return fmt::format("{} bytes at {}", stamp.bytes, stamp.time);
}

bool is_unchanged(const fs::path& file, const std::string& state) {
  std::error_code none;
  return fs::is_regular_file(file, none) && state_of(file) == state;
}

std::map<std::string, StepRecord> read_records(const fs::path& file) {
  std::map<std::string, StepRecord> records;
  const CheckedJson document = CheckedJson::read(file);
  document.require_version(kRecordsFormatVersion);
  for (const auto& [step, record] : document.at("steps").members()) {
    StepRecord& read = records[step];
    read.fingerprint = record.at("fingerprint").text();
    read.seconds = record.at("seconds").number(0.0);
    for (const auto& [output, state] : record.at("outputs").members()) {
      read.outputs[output] = state.text();
    }
  }
  return records;
}

}  // namespace

StepRecords::StepRecords(fs::path out) : out_(std::move(out)) {
  const fs::path file = records_file(out_);
  if (!fs::exists(file)) return;
  try {
    records_ = read_records(file);
  } catch (const std::exception& e) {
    spdlog::warn("{}: cannot be read ({}); every step is run again", file.string(),
                 one_line(e.what()));
  }
}

std::optional<StepRecord> StepRecords::done(const std::string& step,
                                            const std::string& fingerprint) const {
  auto record = last(step);
  if (!record || record->fingerprint != fingerprint) return std::nullopt;
  for (const auto& [file, state] : record->outputs) {
    if (!is_unchanged(out_ / file, state)) return std::nullopt;
  }
  return record;
}

std::optional<StepRecord> StepRecords::last(const std::string& step) const {
  const auto record = records_.find(step);
  return record == records_.end() ? std::nullopt : std::optional(record->second);
}

void StepRecords::note(const std::string& step, const std::string& fingerprint, double seconds,
                       const std::vector<fs::path>& outputs) {
  StepRecord record{.fingerprint = fingerprint, .seconds = seconds};
  for (const fs::path& output : outputs) {
    record.outputs[output.generic_string()] = state_of(out_ / output);
  }
  records_[step] = std::move(record);
  write();
}

void StepRecords::forget(const std::string& step) {
  if (records_.erase(step) > 0) write();
}

void StepRecords::write() const {
  ordered_json steps = ordered_json::object();
  for (const auto& [step, record] : records_) {
    steps[step] = {{"fingerprint", record.fingerprint},
                   {"seconds", record.seconds},
                   {"outputs", record.outputs}};
  }
  const ordered_json document{{"format_version", kRecordsFormatVersion}, {"steps", steps}};
  write_file_atomically(records_file(out_), json_text(document));
}

}  // namespace raywalk::calibrate
