#include "core/base/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <sstream>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk {
namespace {

constexpr std::chrono::milliseconds kPollEvery{20};
constexpr std::chrono::milliseconds kWriteCheckEvery{100};  // for Ctrl-C
constexpr std::chrono::seconds kGrace{3};                   // between SIGTERM and SIGKILL

bool is_executable(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

// A file descriptor that is closed when it goes out of scope. Below 0: none.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }

  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

// Both ends of a stdin that is written: a socket rather than a pipe, as send(2) can be told not to
// raise SIGPIPE where the other end is closed.
struct Ends {
  Descriptor own;
  Descriptor of_child;
};

Ends connected_ends() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw Error(fmt::format("no socket can be made for another program ({})",
                            std::generic_category().message(errno)));
  }
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

// Runs in the child process after fork. `input` below 0: empty.
[[noreturn]] void start(const std::vector<char*>& argv, int input, int output) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (input < 0) input = open("/dev/null", O_RDONLY);
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execv(argv.front(), argv.data());
  constexpr std::string_view kFailed = "the program cannot be executed\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, kFailed.data(), kFailed.size());
  _exit(127);
}

}  // namespace

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    if (!folder.empty() && is_executable(file)) return std::filesystem::absolute(file);
  }
  return std::nullopt;
}

ChildProcess::ChildProcess(const std::filesystem::path& executable,
                           const std::vector<std::string>& arguments,
                           const std::filesystem::path& output, ChildInput input) {
  // Everything that allocates comes before fork: between fork and exec only async-signal-safe
  // functions may be called in a multithreaded program.
  std::vector<std::string> words{executable.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  Descriptor file(open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  if (file.get() < 0) {
    throw Error(fmt::format("{}: cannot be written ({})", output.string(),
                            std::generic_category().message(errno)));
  }
  Ends ends;
  if (input == ChildInput::kWritten) ends = connected_ends();
  pid_ = fork();
  if (pid_ == 0) start(argv, ends.of_child.get(), file.get());
  if (pid_ < 0) {
    throw Error(fmt::format("{} cannot be started ({})", executable.string(),
                            std::generic_category().message(errno)));
  }
  input_ = ends.own.release();
  // Both sides set the group, so that it exists whichever comes first.
  setpgid(pid_, pid_);
}

ChildProcess::~ChildProcess() {
  end_input();
  stop();
}

bool ChildProcess::write_input(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    throw_if_interrupted();
    pollfd ready{input_, POLLOUT, 0};
    poll(&ready, 1, static_cast<int>(kWriteCheckEvery.count()));
    const ssize_t sent = send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
    } else if (errno != EAGAIN && errno != EINTR) {
      return false;
    }
  }
  return true;
}

void ChildProcess::end_input() {
  if (input_ >= 0) close(input_);
  input_ = -1;
}

std::optional<int> ChildProcess::try_wait() {
  if (!status_) {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
  }
  return status_;
}

void ChildProcess::stop() {
  const auto deadline = std::chrono::steady_clock::now() + kGrace;
  if (!try_wait()) kill(-pid_, SIGTERM);
  while (!try_wait() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kPollEvery);
  }
  if (try_wait()) return;
  kill(-pid_, SIGKILL);
  int status = 0;
  waitpid(pid_, &status, 0);
  status_ = status;
}

int ChildProcess::wait() {
  while (!try_wait()) {
    if (interrupt_requested()) {
      stop();
      throw Interrupted("interrupted");
    }
    std::this_thread::sleep_for(kPollEvery);
  }
  return *status_;
}

bool succeeded(int status) { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }

std::string describe_failure(int status) {
  if (WIFSIGNALED(status)) return fmt::format("was killed by signal {}", WTERMSIG(status));
  return fmt::format("failed with exit code {}", WEXITSTATUS(status));
}

}  // namespace raywalk
