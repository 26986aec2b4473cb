// Runs COLMAP, 3.8 or newer, as a child process: found in PATH, run without a shell, its output
// kept in a log; and what differs between its versions.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace raywalk::calibrate {

struct ColmapCommand {
  std::string name{};                                          // "feature_extractor"
  std::vector<std::pair<std::string, std::string>> options{};  // "--database_path" and its value
};

class ColmapProgram {
 public:
  // Finds `colmap` in the directories of PATH and reads its version and what its commands' help
  // lists. Throws Error if there is none or it is older than 3.8, naming what was found, what is
  // needed and the option that needs no COLMAP.
  static ColmapProgram find();

  const std::filesystem::path& executable() const { return executable_; }
  const std::string& version() const { return version_; }  // "3.8.1"

  // The command with options as the found COLMAP names them, of one that names them as COLMAP 4.1.
  // Throws Error naming an option that it does not have. Commands other than feature_extractor,
  // matches_importer and point_triangulator stay as they are.
  ColmapCommand translated(ColmapCommand command) const;

  // Called with every line of output while the command runs.
  using LineReader = std::function<void(std::string_view)>;

  // Runs a command, translated(), until it ends and appends its output to `log`. It cannot outlive
  // this process. Throws Error if it cannot be started, fails or is killed, quoting the error line
  // of its output and the log's path, and what to do; Interrupted on Ctrl-C, after the command
  // ended.
  void run(const ColmapCommand& command, const std::filesystem::path& log,
           const LineReader& on_line = {}) const;

 private:
  explicit ColmapProgram(std::filesystem::path executable) : executable_(std::move(executable)) {}

  void read_version();
  void read_help();
  std::string answer(const std::vector<std::string>& arguments) const;
  void run_arguments(const std::vector<std::string>& arguments, const std::filesystem::path& log,
                     const LineReader& on_line) const;

  std::filesystem::path executable_;
  std::string version_{};
  std::map<std::string, std::string> help_{};  // of each command that is used
};

// The line of a command's output to quote in an error message: the last failed check or error, else
// the last line that is not part of a stack trace; empty if there is none.
std::string error_line(std::string_view output);

}  // namespace raywalk::calibrate
