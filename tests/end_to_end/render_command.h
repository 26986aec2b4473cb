// For end-to-end tests of raywalk-render: runs it on a small room. RAYWALK_RENDER is the program.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/end_to_end/run_command.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

class RenderTest : public ::testing::Test {
 protected:
  static CommandResult render(const std::string& arguments) {
    return run_command(std::string(RAYWALK_RENDER) + " " + arguments);
  }
  std::string room() const { return (directory_ / "room.lf").string(); }
  std::string file(const std::string& name) const { return (directory_ / name).string(); }
  void make_room(const SyntheticRoomSpec& spec = {.overhang_m = 0.25, .width = 64}) const {
    write_synthetic_room(spec, room());
  }
  std::string view(const std::string& rest) const { return "view " + room() + " " + rest; }
  std::string view_to_png(const std::string& rest) const {
    return view(rest + " --out " + file("view.png"));
  }

  // Expects failure with this exit code, exactly one error line, and only `left` entries in the
  // directory.
  void expect_error(const CommandResult& result, int exit_code, const std::string& text,
                    size_t left = 1) const {
    EXPECT_EQ(result.exit_code, exit_code);
    EXPECT_THAT(result.errors, ::testing::HasSubstr(text));
    EXPECT_THAT(result.errors, ::testing::StartsWith("raywalk-render: error: "));
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
    EXPECT_EQ(directory_.entries(), left);
  }

  static std::string joined(const std::vector<std::string>& arguments) {
    std::string text;
    for (const std::string& argument : arguments) text += argument + " ";
    return text;
  }
  // Runs a program, sends a signal as soon as something is there, and returns the wait status.
  static void stop_once(std::vector<std::string> arguments, const std::function<bool()>& there,
                        int signal, int* status) {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_t child = 0;
    ASSERT_EQ(posix_spawn(&child, argv[0], nullptr, nullptr, argv.data(), environ), 0);
    while (!there()) {
      ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "ended before it could be interrupted";
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    kill(child, signal);
    ASSERT_EQ(waitpid(child, status, 0), child);
  }
  // Runs a program and sends SIGINT as soon as a file exists.
  static void interrupt_once_there(const std::vector<std::string>& arguments,
                                   const std::filesystem::path& awaited) {
    int status = 0;
    stop_once(
        arguments, [&] { return std::filesystem::exists(awaited); }, SIGINT, &status);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
  }

  TestDirectory directory_;
};

}  // namespace raywalk
