#include "core/command_line/program.h"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/command_line/command_options.h"
#include "core/command_line/wrong_usage.h"

namespace raywalk {
namespace {

// A log line's message, escaped: like an error, it is one line.
class EscapedMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string text =
        escaped(std::string_view(message.payload.data(), message.payload.size()));
    line.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<EscapedMessage>();
  }
};

// Log lines have the form of the error line, "<program>: <level>: <message>". OpenCV's own are off:
// what it reports matters only where an operation fails, and then it throws.
void set_up_logging(const std::string& program) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  auto logger =
      std::make_shared<spdlog::logger>(program, std::make_shared<spdlog::sinks::stderr_sink_mt>());
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<EscapedMessage>('*').set_pattern("%n: %l: %*");
  logger->set_formatter(std::move(formatter));
  spdlog::set_default_logger(std::move(logger));
}

void set_up_signals() {
  install_interrupt_handlers();
  // Turns a closed pipe (`| head`) and an exceeded file-size limit into failed writes with regular
  // cleanup, instead of signals that kill the process in the middle of a file.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

int fail(const std::string& program, const std::string& message, ExitCode code) {
  std::cerr << program << ": error: " << escaped(message) << std::endl;
  return static_cast<int>(code);
}

int out_of_memory(const std::string& program) {
  return fail(program, "out of memory; use fewer --threads or a smaller picture",
              ExitCode::kFailed);
}

// An exception of a library that should have been caught where the file is known.
int unforeseen(const std::string& program, const std::exception& e) {
  return fail(program,
              "a step failed in a way it should not; please report this line with the command (" +
                  one_line(e.what()) + ")",
              ExitCode::kFailed);
}

// What becomes of the work, where the library that stopped does not say it.
std::string interruption(const CLI::App& app, const std::string& text) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  if (given.empty() || text != "interrupted") return text;
  const bool resumes = given.front()->get_footer().find(kResumption) != std::string::npos;
  return resumes ? text + "; what is finished is kept, the same command resumes"
                 : text + "; no result was written";
}

// On a pipe POLLERR means that the reading end is closed (poll(2)).
bool reader_of_stdout_is_gone() {
  pollfd descriptor = {STDOUT_FILENO, POLLOUT, 0};
  return poll(&descriptor, 1, 0) == 1 && (descriptor.revents & POLLERR) != 0;
}

// Write errors on stdout show only when the buffers are flushed. A closed pipe is not a failure.
void flush_stdout() {
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  if (!flushed && !reader_of_stdout_is_gone()) {
    throw Error("cannot write to standard output; check the disk it is redirected to");
  }
}

// --quiet: silences progress and information, which is below warnings, as long as it lives.
class Quiet {
 public:
  // With `results`, standard output is silenced too.
  explicit Quiet(bool results) {
    spdlog::set_level(spdlog::level::warn);
    if (!results) return;
    flush_stdout();
    saved_stdout_ = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(null, STDOUT_FILENO);
    close(null);
  }
  ~Quiet() {
    std::cout.flush();
    std::fflush(stdout);
    if (saved_stdout_ >= 0) {
      dup2(saved_stdout_, STDOUT_FILENO);
      close(saved_stdout_);
    }
    spdlog::set_level(spdlog::level::info);
  }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  int saved_stdout_ = -1;
};

int parse_and_run(CLI::App& app, std::vector<std::string> words) {
  std::optional<Quiet> quiet;
  add_quiet_flag(&app, [&quiet](bool results) { quiet.emplace(results); });
  try {
    require_double_dashes(app, words);
    std::reverse(words.begin(), words.end());  // as CLI11 parses them
    app.parse(words);
  } catch (const CLI::Success& request) {  // --help, --version
    quiet.reset();
    app.exit(request);
  }
  flush_stdout();
  return static_cast<int>(ExitCode::kDone);
}

}  // namespace

int run_program(CLI::App& app, int argc, char** argv, const RewrittenWords& rewritten) {
  const std::string program = app.get_name();
  try {
    set_up_logging(program);
    set_up_signals();
    const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    return parse_and_run(app, rewritten ? rewritten(words) : words);
  } catch (const CLI::ParseError& e) {
    return fail(program, wrong_usage(app, e), ExitCode::kWrongUsage);
  } catch (const UsageError& e) {
    return fail(program, e.what(), ExitCode::kWrongUsage);
  } catch (const Paused& e) {
    return fail(program, e.what(), ExitCode::kPaused);
  } catch (const Interrupted& e) {
    return fail(program, interruption(app, e.what()), ExitCode::kInterrupted);
  } catch (const std::filesystem::filesystem_error& e) {
    return fail(program, e.path1().string() + ": " + e.code().message(), ExitCode::kFailed);
  } catch (const Error& e) {
    return fail(program, e.what(), ExitCode::kFailed);
  } catch (const std::bad_alloc&) {
    return out_of_memory(program);
  } catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) return out_of_memory(program);
    return unforeseen(program, e);
  } catch (const std::exception& e) {
    return unforeseen(program, e);
  } catch (...) {
    return fail(program, "an exception of unknown type; please report it", ExitCode::kFailed);
  }
}

}  // namespace raywalk
