#include "render/serve/serve_room.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <optional>
#include <system_error>
#include <thread>

#include "core/base/error.h"
#include "render/serve/room_site.h"

namespace raywalk::render {
namespace {

// A folder in the system's one for temporary files that this user alone can read; removed with
// everything in it.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "raywalk-serve-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw Error("cannot make the directory " + name +
                  "; set TMPDIR to a writable one or give --export");
    }
    path_ = name;
  }
  ~PrivateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void print_address(const std::string& host, int port, const std::string& token) {
  const bool is_v6 = host.find(':') != std::string::npos;
  fmt::print("http://{}:{}/{}\n", is_v6 ? "[" + host + "]" : host, port,
             token.empty() ? "" : fmt::format("?{}={}", kTokenParameter, token));
  if (host == "0.0.0.0" || host == "::") {
    fmt::print("from another machine, with this one's name or address instead of {}\n", host);
  }
  std::fflush(stdout);
}

}  // namespace

void serve_room(const Room& room, const ServeOptions& options, const RoomExporter& export_room,
                const std::function<bool()>& stopped) {
  std::optional<PrivateFolder> temporary;
  std::optional<RoomSite> site;
  std::atomic<bool> ready = false;
  const WebServer server(options.host, options.port, [&](const Request& request) {
    if (!ready) throw HttpFault(503, "the room is being exported; try again soon");
    return site->answer(request);
  });
  std::filesystem::path folder = options.exported;
  if (folder.empty()) {
    folder = temporary.emplace().path() / "room";
    export_room(folder);
  }
  site.emplace(room, folder, options.host);
  ready = true;
  print_address(options.host, server.port(), site->token());
  while (!stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  site->stop();
}

}  // namespace raywalk::render
