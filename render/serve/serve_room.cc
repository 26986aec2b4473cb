#include "render/serve/serve_room.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

#include "core/base/escaped.h"
#include "core/http/web_server.h"
#include "render/serve/private_directory.h"
#include "render/serve/room_site.h"

namespace raywalk::render {
namespace {

constexpr std::chrono::milliseconds kPoll{50};

std::string address_of(const ServeOptions& options, int port, const Access& access) {
  const bool is_v6 = options.host.find(':') != std::string::npos;
  const std::string host = is_v6 ? "[" + options.host + "]" : options.host;
  const std::string address = fmt::format("http://{}:{}/", host, port);
  return access.token() ? address + fmt::format("?{}={}", kTokenParameter, *access.token())
                        : address;
}

bool is_any_address(const std::string& host) { return host == "0.0.0.0" || host == "::"; }

}  // namespace

void serve_room(const Room& room, const ServeOptions& options, const RoomExporter& export_room,
                const std::function<bool()>& stopped) {
  std::optional<PrivateDirectory> temporary;
  std::optional<RoomSite> site;
  WebServer server(options.host, options.port,
                   [&site](const RequestHead& head) { return site->answer(head); });
  std::filesystem::path folder = options.exported;
  if (folder.empty()) {
    temporary.emplace();
    folder = temporary->path() / "room";
    export_room(folder);
  }
  site.emplace(room, folder, options.host);
  server.start();
  fmt::print("{}\n", escaped(address_of(options, server.port(), site->access())));
  if (is_any_address(options.host)) {
    fmt::print("from another machine, with this one's name or address instead of {}\n",
               options.host);
  }
  std::fflush(stdout);
  while (!stopped()) std::this_thread::sleep_for(kPoll);
  site->stop();
  server.stop();
}

}  // namespace raywalk::render
