#include "simulator/rig/simulated_card.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::capture {
namespace {

// DCF (JEITA CP-3461): eight characters and an extension. Ricoh writes R001 and four digits, then R
// and seven digits once those are exhausted.
constexpr int kFirstNumber = 10001;

// The number in "R0010001.JPG"; 0 for another file.
int number_in(const std::string& name) {
  if (name.size() != 12 || name.front() != 'R' || name.substr(8) != ".JPG") return 0;
  const std::string digits = name.substr(1, 7);
  if (!std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; })) {
    return 0;
  }
  return std::stoi(digits);
}

}  // namespace

SimulatedCard::SimulatedCard(std::filesystem::path directory, std::int64_t capacity_bytes)
    : directory_(std::move(directory)),
      capacity_bytes_(capacity_bytes),
      last_number_(kFirstNumber - 1) {
  make_directories(directory_);
  for (const auto& entry : std::filesystem::directory_iterator(directory_)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || number_in(name) == 0) continue;
    const auto bytes = static_cast<std::int64_t>(entry.file_size());
    files_[name] = bytes;
    used_bytes_ += bytes;
    last_number_ = std::max(last_number_, number_in(name));
  }
}

std::string SimulatedCard::next_name() {
  const std::lock_guard lock(mutex_);
  return fmt::format("R{:07}.JPG", ++last_number_);
}

void SimulatedCard::write(const std::string& name, const std::string& bytes) {
  const std::filesystem::path file = directory_ / name;
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw Error(file.string() + ": cannot be written; is the disk full?");
  const std::lock_guard lock(mutex_);
  files_[name] = static_cast<std::int64_t>(bytes.size());
  used_bytes_ += static_cast<std::int64_t>(bytes.size());
}

std::vector<SimulatedCardFile> SimulatedCard::files() const {
  const std::lock_guard lock(mutex_);
  std::vector<SimulatedCardFile> all;
  all.reserve(files_.size());
  for (const auto& [name, bytes] : files_) all.push_back({name, bytes});
  return all;
}

bool SimulatedCard::has(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return files_.contains(name);
}

std::string SimulatedCard::read(const std::string& name) const {
  if (!has(name)) throw Error("no file " + excerpt(name) + " on the card");
  return read_file(directory_ / name);
}

void SimulatedCard::erase(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto file = files_.find(name);
  if (file == files_.end()) throw Error("no file " + excerpt(name) + " on the card");
  std::filesystem::remove(directory_ / name);
  used_bytes_ -= file->second;
  files_.erase(file);
}

std::int64_t SimulatedCard::free_bytes() const {
  const std::lock_guard lock(mutex_);
  return std::max<std::int64_t>(capacity_bytes_ - used_bytes_, 0);
}

}  // namespace raywalk::capture
