#include "render/serve/room_site.h"

#include <optional>

#include "render/serve/file_reply.h"
#include "render/serve/view_request.h"

namespace raywalk::render {
namespace {

constexpr const char* kViewPath = "/view";
constexpr const char* kManifestPath = "/manifest.json";

}  // namespace

RoomSite::RoomSite(const Room& room, const std::filesystem::path& exported, const std::string& host)
    : access_(host), files_(exported), views_(room) {}

Reply RoomSite::answer(const RequestHead& head) {
  const RequestTarget target = parse_request_target(head.target);
  if (const std::optional<Reply> reply = access_.check(head, target)) return *reply;
  if (head.method != "GET" && head.method != "HEAD") {
    Reply reply = refusal(HttpFault(405, "only GET and HEAD are served"));
    reply.fields.emplace_back("Allow", "GET, HEAD");
    return reply;
  }
  if (target.path == kViewPath) return views_.answer(parse_view_request(target));
  if (target.path == kManifestPath) {
    return text_reply(files_.manifest(), "application/json", head);
  }
  if (const ServedFile* file = files_.at(target.path)) return file_reply(*file, head);
  throw HttpFault(404, "there is no such file here");
}

}  // namespace raywalk::render
