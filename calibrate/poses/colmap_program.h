// Runs COLMAP as a child process: found in PATH, run without a shell, its output kept in a log; and
// what differs between its releases.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk::calibrate {

struct ColmapRelease {
  std::string_view number;            // "3.8"
  std::string_view max_error_option;  // of matches_importer: inliers of a pair, pixels
};

class ColmapProgram {
 public:
  // Finds `colmap` in the directories of PATH and reads its version. Throws Error if there is none,
  // or it is a release whose options are not known, naming what was found, what is needed
  // and the option that needs no COLMAP.
  static ColmapProgram find();

  const std::filesystem::path& executable() const { return executable_; }
  const std::string& version() const { return version_; }  // "3.8.1"
  const ColmapRelease& release() const { return release_; }

  // Called with every line of output while the command runs.
  using LineReader = std::function<void(std::string_view)>;

  // Runs `colmap arguments...` until it ends and appends its output to `log`. It cannot outlive
  // this process. Throws Error if it cannot be started, fails or is killed, quoting the error line
  // of its output and the log's path, and what to do; Interrupted on Ctrl-C, after the command
  // ended.
  void run(const std::vector<std::string>& arguments, const std::filesystem::path& log,
           const LineReader& on_line = {}) const;

 private:
  ColmapProgram(std::filesystem::path executable, std::string version, ColmapRelease release)
      : executable_(std::move(executable)), version_(std::move(version)), release_(release) {}

  std::filesystem::path executable_;
  std::string version_;
  ColmapRelease release_;
};

// The line of a command's output to quote in an error message: the last failed check or error, else
// the last line that is not part of a stack trace; empty if there is none.
std::string error_line(std::string_view output);

}  // namespace raywalk::calibrate
