#include "render/serve/served_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "render/serve/test_export.h"

namespace raywalk::render {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class ServedFilesTest : public testing::Test {
 protected:
  ServedFiles served() const { return ServedFiles(directory_ / "web"); }
  void expect_refusal(const std::string& message) const {
    EXPECT_THAT([this] { served(); }, ThrowsMessage<Error>(HasSubstr(message)));
  }

  TestDirectory directory_;
};

TEST_F(ServedFilesTest, AreThoseOfTheManifest) {
  write_test_export(directory_ / "web");
  write_file_atomically(directory_ / "web/notes.txt", "not named");
  const ServedFiles files = served();
  for (const auto& [name, content] : test_files()) {
    const ServedFile* file = files.at("/" + name);
    ASSERT_NE(file, nullptr) << name;
    EXPECT_EQ(read_file(file->file), content) << name;
  }
  EXPECT_EQ(files.size(), test_files().size() + 1);
  EXPECT_EQ(files.at("/")->file, files.at("/index.html")->file);
  for (const char* path : {"", "index.html", "/notes.txt", "/stations", "/stations/", "/INDEX.HTML",
                           "/stations/0002.jpg", "/manifest.json"}) {
    EXPECT_EQ(files.at(path), nullptr) << path;
  }
  EXPECT_EQ(files.at("/index.html")->type, "text/html; charset=utf-8");
  EXPECT_EQ(files.at("/viewer.js")->type, "text/javascript; charset=utf-8");
  EXPECT_EQ(files.at("/stations/0000.jpg")->type, "image/jpeg");
  EXPECT_EQ(files.at("/stations/0000.omega")->type, "application/octet-stream");
}

TEST_F(ServedFilesTest, ManifestHasTheEngine) {
  write_test_export(directory_ / "web");
  auto manifest = nlohmann::ordered_json::parse(served().manifest());
  EXPECT_EQ(manifest.at("engine"), nlohmann::ordered_json({{"view", "view"}}));
  manifest.erase("engine");
  EXPECT_EQ(manifest, test_manifest());
}

TEST_F(ServedFilesTest, MustBeAnExport) {
  expect_refusal("holds no exported room");
  write_test_export(directory_ / "web");
  for (const auto& [key, value] : {std::pair("format", nlohmann::json("other")),
                                   {"version", 2},
                                   {"version", "1"},
                                   {"lines", 3}}) {
    auto manifest = test_manifest();
    manifest[key] = value;
    write_file_atomically(directory_ / "web/manifest.json", json_text(manifest));
    expect_refusal(key);
  }
  write_file_atomically(directory_ / "web/manifest.json", "{");
  expect_refusal("manifest.json");
}

TEST_F(ServedFilesTest, MustAllBeThere) {
  write_test_export(directory_ / "web");
  std::filesystem::remove(directory_ / "web/stations/0001.omega");
  expect_refusal("0001.omega is missing");
  std::filesystem::create_directory(directory_ / "web/stations/0001.omega");
  expect_refusal("no regular file");
}

TEST_F(ServedFilesTest, DoNotLeaveTheFolder) {
  write_test_export(directory_ / "web");
  write_file_atomically(directory_ / "secret.jpg", "secret");
  for (const std::string& picture : std::initializer_list<std::string>{
           "../secret.jpg", "truth/../../secret.jpg", (directory_ / "secret.jpg").string(),
           "/etc/passwd", "truth\\000.jpg", "./truth/000.jpg", "truth//000.jpg", "", "truth/",
           "truth/000.jpg\n"}) {
    auto manifest = test_manifest();
    manifest["truth"][0]["picture"] = picture;
    write_file_atomically(directory_ / "web/manifest.json", json_text(manifest));
    expect_refusal("manifest.json: ");
  }
  auto manifest = test_manifest();
  manifest["lines"][0]["stations"][0]["name"] = "../../secret";
  write_file_atomically(directory_ / "web/manifest.json", json_text(manifest));
  expect_refusal("is not a file of the folder");
}

TEST_F(ServedFilesTest, DoNotFollowLinksOutOfTheFolder) {
  write_test_export(directory_ / "web");
  write_file_atomically(directory_ / "secret.jpg", "secret");
  const auto link = directory_ / "web/truth/000.jpg";
  std::filesystem::remove(link);
  std::filesystem::create_symlink("../../secret.jpg", link);
  expect_refusal("leaves the folder");
  // "web-other" begins like "web".
  std::filesystem::remove(link);
  std::filesystem::create_directory(directory_ / "web-other");
  write_file_atomically(directory_ / "web-other/a.jpg", "secret");
  std::filesystem::create_symlink(directory_ / "web-other/a.jpg", link);
  expect_refusal("leaves the folder");
  std::filesystem::remove(link);
  std::filesystem::create_symlink("000-engine.jpg", link);
  EXPECT_EQ(read_file(served().at("/truth/000.jpg")->file), "rendered");
}

}  // namespace
}  // namespace raywalk::render
