// End-to-end test of raywalk-render serve. RAYWALK_RENDER is the program.

// Eigen first: httplib includes resolv.h, whose macro _res is the name of a parameter there.
// clang-format off
#include <Eigen/Core>
#include <httplib.h>
// clang-format on
#include <gmock/gmock.h>

#include <chrono>
#include <regex>
#include <thread>

#include "core/files/test_support.h"
#include "render/serve/test_export.h"
#include "tests/end_to_end/run_command.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

class ServeCommand : public ::testing::Test {
 protected:
  ServeCommand() {
    write_synthetic_room({.overhang_m = 0.25, .width = 64}, room());
    render::write_test_export(directory_ / "web");
  }
  std::string room() const { return (directory_ / "room.lf").string(); }
  std::vector<std::string> serve() const {
    return {RAYWALK_RENDER, "serve", room(), "--export", (directory_ / "web").string(),
            "--port",       "0"};
  }
  // The address that a program has printed on a line of its own; empty where it ended before.
  std::string printed_address(BackgroundProcess* process) const {
    while (!process->has_ended()) {
      const std::string text = read_file(directory_ / "log");
      std::smatch found;
      if (std::regex_search(text, found, std::regex("^(http://127\\.0\\.0\\.1:[0-9]+)/\n"))) {
        return found[1];
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return "";
  }

  TestDirectory directory_;
};

TEST_F(ServeCommand, EndsWithCtrlC) {
  for (const int signal : {SIGINT, SIGTERM}) {
    BackgroundProcess process(serve(), directory_ / "log");
    const std::string address = printed_address(&process);
    ASSERT_NE(address, "") << read_file(directory_ / "log");
    httplib::Client client(address);
    client.set_keep_alive(true);  // an idle connection does not hold it up
    const auto page = client.Get("/");
    ASSERT_TRUE(page);
    EXPECT_EQ(page->body, render::test_files().at("index.html"));
    EXPECT_EQ(client.Get("/view?x=0&z=0")->status, 200);
    const auto begin = std::chrono::steady_clock::now();
    process.signal(signal);
    EXPECT_EQ(process.wait(), 0);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(4));
    EXPECT_FALSE(client.Get("/"));
  }
}

TEST_F(ServeCommand, SaysWhatIsWrongInOneLine) {
  const auto error_of = [this](const std::string& more) {
    std::string command;
    for (const std::string& argument : serve()) command += argument + " ";
    const CommandResult result = run_command(command + more);
    EXPECT_NE(result.exit_code, 0);
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
    return result.errors;
  };
  EXPECT_THAT(error_of("--title Hall"), HasSubstr("--title"));
  EXPECT_THAT(error_of("--host 203.0.113.1"), HasSubstr("cannot listen on 203.0.113.1"));
  std::filesystem::remove(directory_ / "web/viewer.js");
  EXPECT_THAT(error_of(""), HasSubstr("viewer.js is missing"));
}

}  // namespace
}  // namespace raywalk
