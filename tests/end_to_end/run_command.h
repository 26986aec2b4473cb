// For end-to-end tests: runs programs, to their end, beside the test, or until they are stopped.
#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/files/test_support.h"

namespace raywalk {

inline int exit_code_of(int wait_status) {  // 128 + signal if terminated by a signal
  return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
}

struct CommandResult {
  int exit_code = -1;
  std::string output;  // stdout
  std::string errors;  // stderr
};

// Of a shell command.
inline CommandResult run_command(const std::string& command) {
  const TestDirectory directory;
  const auto out = directory / "out", err = directory / "err";
  const std::string redirected =
      "( " + command + " ) > " + out.string() + " 2> " + err.string() + " < /dev/null";
  const int exit_code = exit_code_of(std::system(redirected.c_str()));
  return {exit_code, read_file(out), read_file(err)};
}

// Expects that a command has succeeded; returns what it printed.
inline CommandResult expect_success(const CommandResult& result) {
  EXPECT_EQ(result.exit_code, 0) << result.output << result.errors;
  return result;
}

// Expects failure with this exit code and exactly one error, which holds `text`.
inline void expect_one_error(const CommandResult& result, int exit_code, const std::string& text) {
  EXPECT_EQ(result.exit_code, exit_code) << result.errors;
  EXPECT_THAT(result.errors, testing::HasSubstr(text));
  EXPECT_THAT(result.errors, testing::HasSubstr(": error: "));
  EXPECT_EQ(result.errors.find(": error: "), result.errors.rfind(": error: ")) << result.errors;
  EXPECT_THAT(result.errors, testing::Not(testing::HasSubstr("HDF5-DIAG")));
}

// A program that runs beside the test; killed on destruction if it is still running.
class BackgroundProcess {
 public:
  BackgroundProcess(std::vector<std::string> arguments, const std::filesystem::path& log) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("cannot start " + arguments[0]);
  }
  ~BackgroundProcess() {
    signal(SIGKILL);
    wait();
  }
  BackgroundProcess(const BackgroundProcess&) = delete;
  BackgroundProcess& operator=(const BackgroundProcess&) = delete;

  // Nothing once it has been waited for: its number may be another program's.
  void signal(int number) const {
    if (!ended_) kill(pid_, number);
  }
  // Waits for termination; returns the exit code, or 128 + signal.
  int wait() {
    if (!ended_) waitpid(pid_, &status_, 0);
    ended_ = true;
    return exit_code_of(status_);
  }
  bool has_ended() {
    ended_ = ended_ || waitpid(pid_, &status_, WNOHANG) == pid_;
    return ended_;
  }

 private:
  pid_t pid_ = -1;
  int status_ = 0;
  bool ended_ = false;
};

// The exit code of a program that is sent a signal once `begun` holds; of its own end if it ends
// before.
template <typename Begun>
int exit_code_when_stopped(const std::vector<std::string>& arguments, int signal,
                           const Begun& begun) {
  const TestDirectory directory;
  BackgroundProcess process(arguments, directory / "log");
  while (!begun() && !process.has_ended()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  process.signal(signal);
  return process.wait();
}

}  // namespace raywalk
