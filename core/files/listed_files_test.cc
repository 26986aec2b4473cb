#include "core/files/listed_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

TEST(ListedFiles, NamesOfOtherSystemsAreFound) {
  const TestDirectory directory;
  const std::string composed = "K\u00fcche.jpg", decomposed = "Ku\u0308che.jpg";
  fs::create_directories(directory / "Hall/Front");
  for (const std::string name : {"Hall/Front/a.JPG", "b.jpg", "B.jpg", "\xFFg.jpg"}) {
    write_file_atomically(directory / name, name);
  }
  write_file_atomically(directory / decomposed, "");
  ListedFiles files(directory.path());
  const auto found = [&](const std::string& name) {
    return files.find(name).lexically_relative(directory.path()).string();
  };
  EXPECT_EQ(found("Hall/Front/a.JPG"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("Hall\\Front\\a.JPG"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("hall\\FRONT\\A.jpg"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("Hall/../hall/./Front/a.jpg"), "Hall/../Hall/./Front/a.JPG");
  EXPECT_EQ(found(composed), decomposed);
  EXPECT_EQ(found(decomposed), decomposed);
  EXPECT_EQ(found("\xFFg.JPG"), "\xFFg.JPG") << "not UTF-8";
  EXPECT_EQ(found("b.jpg"), "b.jpg");
  EXPECT_EQ(found("b.JPG"), "b.JPG") << "two files have this name but for case";
  EXPECT_EQ(found("none\\c.jpg"), "none\\c.jpg");
  EXPECT_EQ(files.find((directory / "HALL/front/a.jpg").string()), directory / "Hall/Front/a.JPG");
}

TEST(ListedFiles, AFileWithABackslashInItsNameIsTakenAsWritten) {
  const TestDirectory directory;
  write_file_atomically(directory / "a\\b.jpg", "");
  EXPECT_EQ(ListedFiles(directory.path()).find("a\\b.jpg"), directory / "a\\b.jpg");
}

}  // namespace
}  // namespace raywalk
