// The files of an exported room that are served, by their path on the server: those that its
// manifest names, and nothing else.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace raywalk::render {

struct ServedFile {
  std::filesystem::path file{};
  std::string type{};  // media type
};

class ServedFiles {
 public:
  // Reads the manifest of a folder made by export-web. Throws Error naming the folder or file where
  // the manifest is missing, damaged or of another version, names a path that leaves the folder, or
  // a file that is missing or not a regular one.
  explicit ServedFiles(const std::filesystem::path& folder);

  // Null where nothing is served there. "/" is the page. manifest.json is not among them.
  const ServedFile* at(const std::string& path) const;

  // The text of manifest.json with one more key, which tells the page that views are rendered here.
  const std::string& manifest() const { return manifest_; }

  std::size_t size() const { return files_.size(); }

 private:
  void add(const std::string& relative);

  std::filesystem::path folder_;  // canonical
  std::map<std::string, ServedFile> files_;
  std::string manifest_;
};

}  // namespace raywalk::render
