// Runs the pymodbus slave in a separate process, for tests that kill it.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace raywalk::capture {

class SlaveProcess {
 public:
  // Returns when it is ready. Throws std::runtime_error if it does not start.
  SlaveProcess(const std::string& map, const std::string& line) {
    std::array<int, 2> pipe_ends{};
    if (pipe(pipe_ends.data()) != 0) throw std::runtime_error("no pipe");
    pid_ = fork();
    if (pid_ == 0) {
      dup2(pipe_ends[1], STDOUT_FILENO);
      close(pipe_ends[0]);
      close(pipe_ends[1]);
      // Debian's interpreter, the only one for which the packages are installed.
      execl("/usr/bin/python3", "python3", RAYWALK_PYMODBUS_SLAVE, "--map", map.c_str(), "--line",
            line.c_str(), nullptr);
      _exit(127);
    }
    close(pipe_ends[1]);
    output_ = fdopen(pipe_ends[0], "r");
    std::array<char, 256> where{};
    if (fscanf(output_, "ready %255s", where.data()) != 1) {
      end();
      throw std::runtime_error(
          "the pymodbus slave does not start; scripts/install-packages test installs what it "
          "needs");
    }
    where_ = where.data();
    // Once both sides of a terminal are closed, the kernel reuses its number. A link that
    // reconnects after a hang-up would then reach the device of another test.
    if (where_.starts_with("/dev/"))
      terminal_ = open(where_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  ~SlaveProcess() {
    end();
    if (terminal_ >= 0) close(terminal_);
  }
  SlaveProcess(const SlaveProcess&) = delete;
  SlaveProcess& operator=(const SlaveProcess&) = delete;

  // The device path of its pseudo-terminal, or its TCP port.
  const std::string& where() const { return where_; }
  void send(int signal) const { kill(pid_, signal); }

 private:
  void end() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    fclose(output_);
  }

  pid_t pid_ = -1;
  FILE* output_ = nullptr;
  std::string where_;
  int terminal_ = -1;
};

}  // namespace raywalk::capture
