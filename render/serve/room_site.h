// Everything that is served of a room: the files of its export and views by the engine.
#pragma once

#include <filesystem>
#include <string>

#include "core/http/reply.h"
#include "core/http/request_head.h"
#include "core/room/room.h"
#include "render/serve/access.h"
#include "render/serve/served_files.h"
#include "render/serve/view_service.h"

namespace raywalk::render {

class RoomSite {
 public:
  // `host` is what the server listens on. The room must outlive the site. Throws Error as
  // ServedFiles does.
  RoomSite(const Room& room, const std::filesystem::path& exported, const std::string& host);

  // Answers a request; called on several threads. Throws HttpFault for one that is refused.
  Reply answer(const RequestHead& head);

  // Refuses the views that wait.
  void stop() { views_.stop(); }

  const Access& access() const { return access_; }

 private:
  Access access_;
  ServedFiles files_;
  ViewService views_;
};

}  // namespace raywalk::render
