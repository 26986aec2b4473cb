#include "render/serve/served_files.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "render/web/web_manifest.h"

namespace raywalk::render {
namespace {

constexpr const char* kManifest = "manifest.json";
constexpr const char* kAdvice = "export the room again with raywalk-render export-web";

constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kTypes{
    {{".html", "text/html; charset=utf-8"},
     {".js", "text/javascript; charset=utf-8"},
     {".css", "text/css; charset=utf-8"},
     {".jpg", "image/jpeg"},
     {".png", "image/png"},
     {".json", "application/json"},
     {".omega", "application/octet-stream"}}};

std::string type_of(const std::filesystem::path& file) {
  const auto* const found = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& type) {
    return type.first == file.extension().string();
  });
  return std::string(found == kTypes.end() ? "application/octet-stream" : found->second);
}

// Whether it is the path of a file in a folder, written in the one way that addresses name it.
bool is_plain_path(const std::string& relative) {
  const auto is_bad = [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7f || c == '\\';
  };
  if (relative.empty() || std::any_of(relative.begin(), relative.end(), is_bad)) return false;
  const std::filesystem::path path(relative);
  const std::filesystem::path first = *path.begin();
  return path.is_relative() && path.has_filename() &&
         path.lexically_normal().string() == relative && first != "." && first != "..";
}

bool is_within(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const auto [unlike, ignored] =
      std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return unlike == folder.end();
}

CheckedJson read_web_manifest(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kManifest;
  if (!std::filesystem::exists(file)) {
    throw Error(folder.string() + " holds no exported room (no manifest.json); " + kAdvice);
  }
  CheckedJson manifest = CheckedJson::read(file, kAdvice);
  if (manifest.at("format").text() != kWebFormat) {
    manifest.at("format").fail("is not that of an exported room");
  }
  manifest.at("version").integer(kWebVersion, kWebVersion);
  return manifest;
}

}  // namespace

ServedFiles::ServedFiles(const std::filesystem::path& folder) {
  const CheckedJson manifest = read_web_manifest(folder);
  folder_ = std::filesystem::canonical(folder);
  for (const char* page : {"index.html", "viewer.js", "viewer.css"}) add(page);
  for (const CheckedJson& line : manifest.at("lines").items()) {
    for (const CheckedJson& station : line.at("stations").items()) {
      const std::string name = "stations/" + station.at("name").text();
      for (const char* ending : {".jpg", "-coarse.jpg", ".omega"}) add(name + ending);
    }
  }
  for (const CheckedJson& truth : manifest.at("truth").items()) {
    add(truth.at("picture").text());
    add(truth.at("engine").text());
  }
  files_["/"] = files_.at("/index.html");
  auto document = nlohmann::ordered_json::parse(read_file(folder_ / kManifest));
  document["engine"] = {{"view", "view"}};
  manifest_ = document.dump() + "\n";
}

void ServedFiles::add(const std::string& relative) {
  const std::filesystem::path file = folder_ / relative;
  const std::string in_manifest = (folder_ / kManifest).string() + ": ";
  if (!is_plain_path(relative)) {
    throw Error(in_manifest + excerpt(relative) + " is not a file of the folder; " + kAdvice);
  }
  std::error_code failed;
  const std::filesystem::path real = std::filesystem::canonical(file, failed);
  if (failed || !std::filesystem::is_regular_file(real, failed)) {
    throw Error(file.string() + " is missing or no regular file; " + kAdvice);
  }
  if (!is_within(real, folder_)) {
    throw Error(file.string() + " is a link that leaves the folder; " + kAdvice);
  }
  files_["/" + relative] = {real, type_of(file)};
}

const ServedFile* ServedFiles::at(const std::string& path) const {
  const auto found = files_.find(path);
  return found == files_.end() ? nullptr : &found->second;
}

}  // namespace raywalk::render
