#include "render/serve/serve_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <future>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "core/view/test_room.h"
#include "render/serve/test_export.h"
#include "render/serve/web_server.h"

namespace raywalk::render {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// A port that was free a moment ago.
int free_port() {
  return WebServer("127.0.0.1", 0, [](const Request&) { return Reply{}; }).port();
}

class ServeRoomTest : public testing::Test {
 protected:
  // Until stopped_ is set; the page is there within a few seconds.
  std::future<void> serve(const ServeOptions& options, const RoomExporter& exporter) {
    return std::async(std::launch::async, [this, options, exporter] {
      serve_room(room_.room(), options, exporter, [this] { return stopped_.load(); });
    });
  }
  static bool answers(int port) {
    for (int i = 0; i < 300; ++i) {
      const auto reply = httplib::Client("127.0.0.1", port).Get("/");
      if (reply && reply->status == 200) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  TestRoom room_{box_room(64)};
  TestDirectory directory_;
  std::atomic<bool> stopped_ = false;
};

TEST_F(ServeRoomTest, ExportsForTheTimeOfServing) {
  std::filesystem::path exported;
  const int port = free_port();
  auto serving = serve({.port = port}, [&](const std::filesystem::path& folder) {
    EXPECT_FALSE(std::filesystem::exists(folder));
    write_test_export(folder);
    exported = folder;
  });
  EXPECT_TRUE(answers(port));
  EXPECT_TRUE(std::filesystem::exists(exported / "index.html"));
  // Nobody else reads it.
  EXPECT_EQ(std::filesystem::status(exported.parent_path()).permissions(),
            std::filesystem::perms::owner_all);
  stopped_ = true;
  serving.get();
  EXPECT_FALSE(std::filesystem::exists(exported.parent_path()));
}

TEST_F(ServeRoomTest, ServesAnExportThatIsThere) {
  write_test_export(directory_ / "web");
  const int port = free_port();
  auto serving = serve({.exported = directory_ / "web", .port = port},
                       [](const auto&) { ADD_FAILURE() << "exported again"; });
  EXPECT_TRUE(answers(port));
  stopped_ = true;
  serving.get();
  EXPECT_TRUE(std::filesystem::exists(directory_ / "web/index.html"));
}

TEST_F(ServeRoomTest, LeavesNothingBehindAfterAnError) {
  std::filesystem::path exported;
  EXPECT_THAT(
      [&] {
        serve_room(
            room_.room(), {.port = 0},
            [&](const std::filesystem::path& folder) {
              exported = folder;
              write_test_export(folder);
              throw Error("disk full");
            },
            [] { return true; });
      },
      ThrowsMessage<Error>(HasSubstr("disk full")));
  EXPECT_FALSE(std::filesystem::exists(exported.parent_path()));
}

TEST_F(ServeRoomTest, ExportsNothingForAPortInUse) {
  const WebServer other("127.0.0.1", 0, [](const Request&) { return Reply{}; });
  EXPECT_THAT(
      [&] {
        serve_room(
            room_.room(), {.port = other.port()}, [](const auto&) { ADD_FAILURE() << "exported"; },
            [] { return true; });
      },
      ThrowsMessage<Error>(HasSubstr("in use")));
}

TEST_F(ServeRoomTest, PrintsItsAddress) {
  write_test_export(directory_ / "web");
  const auto printed = [&](const std::string& host) {
    testing::internal::CaptureStdout();
    serve_room(
        room_.room(), {.exported = directory_ / "web", .host = host, .port = 0}, [](const auto&) {},
        [] { return true; });
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_THAT(printed("127.0.0.1"), testing::MatchesRegex("http://127.0.0.1:[0-9]+/\n"));
  EXPECT_THAT(printed("0.0.0.0"),
              testing::MatchesRegex("http://0.0.0.0:[0-9]+/\\?token=[0-9a-f]+\nfrom another .*\n"));
}

}  // namespace
}  // namespace raywalk::render
