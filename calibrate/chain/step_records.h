// What the steps of a calibration were made from: OUT/steps.json, so that a step whose inputs have
// not changed is not done again.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace raywalk::calibrate {

struct StepRecord {
  std::string fingerprint{};  // of everything that the step depends on
  double seconds = 0.0;       // that it took
  // Files made, relative to OUT, with what tells whether they are still the same.
  std::map<std::string, std::string> outputs{};
};

class StepRecords {
 public:
  // Reads OUT/steps.json where it is there; one that cannot be read counts as empty, with a
  // warning, since all that is lost is time.
  explicit StepRecords(std::filesystem::path out);

  // The record of a step that is done: its fingerprint is this one and its outputs are as they
  // were.
  std::optional<StepRecord> done(const std::string& step, const std::string& fingerprint) const;
  // The last record of a step, whatever it was made from.
  std::optional<StepRecord> last(const std::string& step) const;

  // Notes a step as done, with its outputs as they are now, and writes steps.json. Throws Error
  // where it cannot be written, or an output is not there.
  void note(const std::string& step, const std::string& fingerprint, double seconds,
            const std::vector<std::filesystem::path>& outputs);
  // The step counts as never done; written at once.
  void forget(const std::string& step);

 private:
  void write() const;

  std::filesystem::path out_;
  std::map<std::string, StepRecord> records_{};
};

}  // namespace raywalk::calibrate
