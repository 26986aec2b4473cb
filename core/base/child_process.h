// Another program, run without a shell.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raywalk {

// The first executable file of this name in the folders of PATH, as an absolute path; none if there
// is none.
std::optional<std::filesystem::path> find_program(const std::string& name);

// What a child process reads from its stdin: nothing, or what write_input() is given.
enum class ChildInput { kEmpty, kWritten };

// A child process in its own process group, so that its descendants are stopped with it. It cannot
// outlive this process. Its stdout and stderr are appended to a file. The destructor stops it.
class ChildProcess {
 public:
  // Throws Error if the output file cannot be written or the fork fails. A program that cannot be
  // executed ends with exit code 127.
  ChildProcess(const std::filesystem::path& executable, const std::vector<std::string>& arguments,
               const std::filesystem::path& output, ChildInput input = ChildInput::kEmpty);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // For ChildInput::kWritten: hands bytes to the stdin, waiting until the program takes them. False
  // if it reads no more, as when it has ended. Throws Interrupted on Ctrl-C.
  bool write_input(std::span<const std::byte> bytes);
  // The program then reads the end of its stdin.
  void end_input();

  // The status as waitpid(2) returns it; none while the process runs. Does not block.
  std::optional<int> try_wait();
  // Sends SIGTERM, then SIGKILL if the process has not ended within a few seconds.
  void stop();
  // Waits for the process to end and returns its status. On Ctrl-C stops it and throws Interrupted.
  int wait();

 private:
  pid_t pid_ = -1;
  int input_ = -1;  // the own end of the stdin
  std::optional<int> status_{};
};

// Whether `status` (from waitpid) is a normal exit with code 0.
bool succeeded(int status);
// A failed status in words: "failed with exit code 1", "was killed by signal 9".
std::string describe_failure(int status);

}  // namespace raywalk
