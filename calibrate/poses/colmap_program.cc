#include "calibrate/poses/colmap_program.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <regex>
#include <sstream>
#include <system_error>
#include <thread>

#include "core/base/child_process.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::calibrate {
namespace {

constexpr std::chrono::milliseconds kPollEvery{20};

constexpr const char* kInstall =
    "install COLMAP 3.8 or newer (Debian: apt install colmap), or give poses solved elsewhere "
    "(raywalk-calibrate rectify --poses TABLE, raywalk-calibrate import MODEL)";
constexpr std::pair kOldestVersion{3, 8};

// What differs between versions. Other options that are used have had one name since 3.8, and the
// tables and files that are read the same columns and fields.
struct RenamedOption {
  std::string_view name;
  std::string_view before;
};
constexpr std::array kRenamedOptions{
    RenamedOption{"--TwoViewGeometry.max_error", "--SiftMatching.max_error"},  // before 3.9
    // Before 3.13.
    RenamedOption{"--FeatureExtraction.num_threads", "--SiftExtraction.num_threads"},
    RenamedOption{"--FeatureExtraction.use_gpu", "--SiftExtraction.use_gpu"},
    RenamedOption{"--FeatureMatching.num_threads", "--SiftMatching.num_threads"},
    RenamedOption{"--FeatureMatching.use_gpu", "--SiftMatching.use_gpu"}};

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Reads what is appended to a file, line by line.
class LogFollower {
 public:
  explicit LogFollower(const std::filesystem::path& log) : log_(log) {
    std::error_code ignored;
    const std::uintmax_t size = std::filesystem::file_size(log, ignored);
    if (!ignored) at_ = static_cast<std::streamoff>(size);
  }

  // Everything appended since the follower was constructed.
  const std::string& output() const { return output_; }

  void read_new_lines(const ColmapProgram::LineReader& on_line) {
    std::ifstream file(log_, std::ios::binary);
    file.seekg(at_);
    std::array<char, 65536> bytes{};
    while (file.read(bytes.data(), bytes.size()) || file.gcount() > 0) {
      output_.append(bytes.data(), static_cast<std::size_t>(file.gcount()));
      at_ += file.gcount();
    }
    for (std::size_t end = output_.find('\n', told_); end != std::string::npos;
         end = output_.find('\n', told_)) {
      if (on_line) on_line(std::string_view(output_).substr(told_, end - told_));
      told_ = end + 1;
    }
  }

 private:
  std::filesystem::path log_;
  std::streamoff at_ = 0;
  std::string output_{};
  std::size_t told_ = 0;
};

// What a failure of COLMAP means, as far as that can be told, and what to do.
std::string advice_for(int status, const std::string& line) {
  for (const char* full : {"No space left", "disk is full", "disk full"}) {
    if (line.find(full) != std::string::npos) return "the disk is full; free some space";
  }
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
    return "perhaps the memory was not enough; use fewer --threads";
  }
  return "it cannot work with these pictures; check that they are sharp, of this capture, and that "
         "neighbouring stations see the same things";
}

void note_command(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  std::ofstream file(log, std::ios::app);
  file << "\n$ colmap";
  for (const std::string& argument : arguments) file << ' ' << argument;
  file << '\n';
  if (!file.flush()) throw Error(fmt::format("{}: cannot be written", log.string()));
}

// A help has a line "  --SiftExtraction.use_gpu arg (=1)" for each option.
bool lists(const std::string& help, std::string_view option) {
  return help.find(fmt::format("  {} ", option)) != std::string::npos;
}

// The name under which a help lists an option; none if it does not.
std::optional<std::string> listed_name(const std::string& help, const std::string& option) {
  if (lists(help, option)) return option;
  for (const auto& [name, before] : kRenamedOptions) {
    if (name == option && lists(help, before)) return std::string(before);
  }
  return std::nullopt;
}

}  // namespace

std::string error_line(std::string_view output) {
  const std::vector<std::string> lines = lines_of(output);
  // glog starts the lines of errors and of failed checks with E or F and the date.
  static const std::regex kLogged(R"([EF]\d{4,8} )");
  const auto tells = [](const std::string& line) {
    return std::regex_search(line, kLogged, std::regex_constants::match_continuous) ||
           line.find("Check failed") != std::string::npos ||
           line.find("ERROR") != std::string::npos || line.find("rror:") != std::string::npos;
  };
  const auto worst = std::find_if(lines.rbegin(), lines.rend(), tells);
  if (worst != lines.rend()) return one_line(*worst);
  // glog's stack traces: "*** Aborted at …", "    @     0x7f… raise".
  const auto last = std::find_if(lines.rbegin(), lines.rend(), [](const std::string& line) {
    const std::string text = one_line(line);
    return !text.empty() && !text.starts_with("***") && !text.starts_with('@');
  });
  return last == lines.rend() ? std::string() : one_line(*last);
}

ColmapProgram ColmapProgram::find() {
  const auto executable = find_program("colmap");
  if (!executable) throw Error(fmt::format("no COLMAP found in PATH; {}", kInstall));
  ColmapProgram colmap(*executable);
  colmap.read_version();
  colmap.read_help();
  return colmap;
}

std::string ColmapProgram::answer(const std::vector<std::string>& arguments) const {
  std::string name = (std::filesystem::temp_directory_path() / "raywalk-colmap-XXXXXX").string();
  const int file = mkstemp(name.data());
  if (file < 0) throw Error(fmt::format("{}: cannot be written", name));
  close(file);
  std::string text;
  try {
    run_arguments(arguments, name, [&](std::string_view line) { text.append(line).append("\n"); });
  } catch (const std::exception&) {
    std::filesystem::remove(name);
    throw;
  }
  std::filesystem::remove(name);
  return text;
}

// `help` is the only command that every version has; its output starts with "COLMAP 3.8 -- …".
void ColmapProgram::read_version() {
  const std::string text = answer({"help"});
  std::smatch match;
  static const std::regex kVersion(R"((^|\n)COLMAP ((\d{1,4})\.(\d{1,4})(\.\d+)*))");
  if (!std::regex_search(text, match, kVersion)) {
    throw Error(fmt::format("{} does not print its COLMAP version ({}); {}", executable_.string(),
                            excerpt(error_line(text)), kInstall));
  }
  version_ = match[2];
  if (std::pair(std::stoi(match[3]), std::stoi(match[4])) < kOldestVersion) {
    throw Error(fmt::format("{} is COLMAP {}, which is too old; {}", executable_.string(), version_,
                            kInstall));
  }
}

void ColmapProgram::read_help() {
  for (const char* command : {"feature_extractor", "matches_importer", "point_triangulator"}) {
    help_[command] = answer({command, "-h"});
  }
}

ColmapCommand ColmapProgram::translated(ColmapCommand command) const {
  const auto help = help_.find(command.name);
  if (help == help_.end()) return command;
  for (auto& [option, value] : command.options) {
    const auto name = listed_name(help->second, option);
    if (!name) {
      throw Error(fmt::format("{} is COLMAP {}, whose {} has no option {}; {}",
                              executable_.string(), version_, command.name, option, kInstall));
    }
    option = *name;
  }
  return command;
}

void ColmapProgram::run(const ColmapCommand& command, const std::filesystem::path& log,
                        const LineReader& on_line) const {
  std::vector<std::string> arguments{command.name};
  for (const auto& [option, value] : translated(command).options) {
    arguments.insert(arguments.end(), {option, value});
  }
  run_arguments(arguments, log, on_line);
}

void ColmapProgram::run_arguments(const std::vector<std::string>& arguments,
                                  const std::filesystem::path& log,
                                  const LineReader& on_line) const {
  throw_if_interrupted();
  note_command(arguments, log);
  LogFollower follower(log);
  // COLMAP links Qt, which would need a display.
  std::vector<std::string> words{"QT_QPA_PLATFORM=offscreen", executable_.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  ChildProcess child("/usr/bin/env", words, log);
  while (!child.try_wait()) {
    follower.read_new_lines(on_line);
    if (interrupt_requested()) {
      child.stop();
      throw Interrupted("interrupted");
    }
    std::this_thread::sleep_for(kPollEvery);
  }
  follower.read_new_lines(on_line);
  const int status = child.try_wait().value_or(0);
  if (succeeded(status)) return;
  const std::string line = error_line(follower.output());
  throw Error(fmt::format("colmap {} {}{}: {}; see {}", arguments.front(), describe_failure(status),
                          line.empty() ? "" : " (" + line + ")", advice_for(status, line),
                          log.string()));
}

}  // namespace raywalk::calibrate
