// Records of the inputs and outputs of the steps of a calibration, OUT/steps.json, so that a step
// whose inputs have not changed is not run again.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace raywalk::calibrate {

struct StepRecord {
  std::string fingerprint{};  // hash of everything that the step depends on
  double seconds = 0.0;       // duration
  // Output files, relative to OUT, with their SHA-256, or size and time of files above 1 MiB.
  std::map<std::string, std::string> outputs{};
};

class StepRecords {
 public:
  // Reads OUT/steps.json if it exists. One that cannot be read counts as empty, with a warning:
  // the steps are then run again.
  explicit StepRecords(std::filesystem::path out);

  // The record of a step if it has this fingerprint and its outputs are unchanged.
  std::optional<StepRecord> done(const std::string& step, const std::string& fingerprint) const;
  // The last record of a step, whatever its inputs.
  std::optional<StepRecord> last(const std::string& step) const;

  // Records a step as done, with the current state of its outputs, and writes steps.json. Throws
  // Error if it cannot be written or an output is missing.
  void note(const std::string& step, const std::string& fingerprint, double seconds,
            const std::vector<std::filesystem::path>& outputs);
  // Removes the record of a step and writes steps.json.
  void forget(const std::string& step);

 private:
  void write() const;

  std::filesystem::path out_;
  std::map<std::string, StepRecord> records_{};
};

}  // namespace raywalk::calibrate
