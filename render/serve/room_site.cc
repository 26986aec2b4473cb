#include "render/serve/room_site.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "render/serve/file_reply.h"
#include "render/serve/view_request.h"
#include "render/web/web_manifest.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAdvice = "export the room again with raywalk-render export-web";
constexpr const char* kManifest = "/manifest.json";

constexpr std::pair<std::string_view, const char*> kTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".jpg", "image/jpeg"},
    {".png", "image/png"},
    {".inverse", "application/octet-stream"}};

// Null for other files than an export has.
const char* type_of(const fs::path& file) {
  const auto* const found =
      std::find_if(std::begin(kTypes), std::end(kTypes),
                   [&](const auto& type) { return type.first == file.extension().string(); });
  return found == std::end(kTypes) ? nullptr : found->second;
}

// Requests look paths up here, so that none can lead out of the folder.
std::map<std::string, fs::path> files_in(const fs::path& folder) {
  std::map<std::string, fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const bool is_file = entry.symlink_status().type() == fs::file_type::regular;
    if (!is_file || type_of(entry.path()) == nullptr) continue;
    files["/" + entry.path().lexically_relative(folder).string()] = entry.path();
  }
  for (const char* page : {"/index.html", "/viewer.js", "/viewer.css"}) {
    if (files.contains(page)) continue;
    throw Error(folder.string() + page + " is missing or no regular file; " + kAdvice);
  }
  files["/"] = files.at("/index.html");
  return files;
}

// The manifest with one more key, which tells the page that views are rendered here.
std::string manifest_of(const fs::path& folder) {
  const fs::path file = folder.string() + kManifest;
  if (!fs::exists(file)) {
    throw Error(folder.string() + " holds no exported room (no manifest.json); " + kAdvice);
  }
  const CheckedJson manifest = CheckedJson::read(file, kAdvice);
  if (manifest.at("format").text() != kWebFormat) {
    manifest.at("format").fail("is not that of an exported room");
  }
  manifest.at("version").integer(kWebVersion, kWebVersion);
  auto document = nlohmann::ordered_json::parse(read_file(file));
  document["engine"] = {{"view", "view"}};
  return document.dump() + "\n";
}

}  // namespace

RoomSite::RoomSite(const Room& room, const fs::path& exported, const std::string& host)
    : access_(host), manifest_(manifest_of(exported)), views_(room) {
  files_ = files_in(exported);
}

Reply RoomSite::answer(const Request& request) {
  if (std::optional<Reply> reply = access_.check(request)) return *std::move(reply);
  if (request.path == "/view") return views_.answer(parse_view_request(request.query));
  if (request.path == kManifest) return text_reply(manifest_, "application/json", request);
  const auto found = files_.find(request.path);
  if (found == files_.end()) throw HttpFault(404, "there is no such file here");
  return file_reply(found->second, type_of(found->second), request);
}

}  // namespace raywalk::render
