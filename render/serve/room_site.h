// Everything that is served of a room: the files of its export and views by the engine.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/room/room.h"
#include "render/serve/access.h"
#include "render/serve/view_service.h"

namespace raywalk::render {

class RoomSite {
 public:
  // `exported` is a folder made by export-web: its files of the kinds that it writes are served,
  // those that are there now and are no links. `host` is what the server listens on. The room must
  // outlive the site. Throws Error where the folder has no page or its manifest is missing, damaged
  // or of another version.
  RoomSite(const Room& room, const std::filesystem::path& exported, const std::string& host);

  // Answers a request; called on several threads. Throws HttpFault for one that is refused.
  Reply answer(const Request& request);

  // Refuses the views that wait.
  void stop() { views_.stop(); }

  const std::string& token() const { return access_.token(); }

 private:
  Access access_;
  std::map<std::string, std::filesystem::path> files_;  // by their path on the server
  std::string manifest_;
  ViewService views_;
};

}  // namespace raywalk::render
