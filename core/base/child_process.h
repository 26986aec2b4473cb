// Another program, run without a shell.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace raywalk {

// A running program in a process group of its own, so that whatever it starts ends with it, and
// that cannot outlive this process. What it says, on stdout and stderr, is appended to a file; its
// stdin is empty. The destructor stops it.
class ChildProcess {
 public:
  // `environment` holds "NAME=value" that the program gets besides, or instead of, this process's
  // own. Throws Error where the file cannot be written or no process be made; a program that cannot
  // be executed ends with exit code 127.
  ChildProcess(const std::filesystem::path& executable, const std::vector<std::string>& arguments,
               const std::filesystem::path& output,
               const std::vector<std::string>& environment = {});
  ~ChildProcess() { stop(); }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // The status as waitpid tells it; none while it runs.
  std::optional<int> ended();
  // Asks it to end, and ends it where it does not within a few seconds.
  void stop();
  // Waits for its end; the status. On Ctrl-C stops it and throws Interrupted.
  int wait();

 private:
  pid_t pid_ = -1;
  std::optional<int> status_{};
};

// Whether a status says that all went well.
bool succeeded(int status);
// How a program that did not succeed ended: "failed with exit code 1", "was killed by signal 9".
std::string ending_of(int status);

}  // namespace raywalk
