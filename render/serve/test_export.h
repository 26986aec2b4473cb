// For tests: a folder as export-web makes it, of small files.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::render {

inline nlohmann::ordered_json test_manifest() {
  return nlohmann::ordered_json::parse(R"({
    "format": "raywalk-web", "version": 1, "title": "room",
    "lines": [{"id": "x0", "stations": [{"name": "0000"}, {"name": "0001"}]}],
    "truth": [{"picture": "truth/000.jpg", "engine": "truth/000-engine.jpg"}]
  })");
}

// The files of that manifest but for itself, by their path.
inline std::map<std::string, std::string> test_files() {
  std::map<std::string, std::string> files{{"index.html", "<!DOCTYPE html>"},
                                           {"viewer.js", "'use strict';"},
                                           {"viewer.css", ""},
                                           {"truth/000.jpg", "true"},
                                           {"truth/000-engine.jpg", "rendered"}};
  for (const std::string name : {"stations/0000", "stations/0001"}) {
    files[name + ".jpg"] = name + std::string(1000, 'p');
    files[name + "-coarse.jpg"] = name + " coarse";
    std::string bytes;
    for (int i = 0; i < 256; ++i) bytes += static_cast<char>(i);
    files[name + ".inverse"] = bytes;
  }
  return files;
}

inline void write_test_export(const std::filesystem::path& folder,
                              const nlohmann::ordered_json& manifest = test_manifest()) {
  for (const auto& [name, content] : test_files()) {
    make_directories((folder / name).parent_path());
    write_file_atomically(folder / name, content);
  }
  write_file_atomically(folder / "manifest.json", json_text(manifest));
}

}  // namespace raywalk::render
