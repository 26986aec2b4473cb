#include "core/evaluate/kept_results.h"

#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

class KeptResultsTest : public ::testing::Test {
 protected:
  // What a run finds under a key, or makes.
  ordered_json got(const std::string& key, const ordered_json& made) const {
    return KeptResults(file_).get(key, [&] { return made; });
  }

  TestDirectory directory_;
  std::filesystem::path file_ = directory_ / "some.partial";
};

TEST_F(KeptResultsTest, DamageCountsAsMissing) {
  got("a", {{"x", 12}});
  const std::string whole = read_file(file_);
  std::string changed = whole;
  changed[changed.find("12")] = '7';
  for (const std::string& text :
       {std::string(), std::string("{}"), whole.substr(0, 70), changed, std::string(100, '[')}) {
    write_file_atomically(file_, text);
    EXPECT_EQ(got("a", 1), 1) << text;
    EXPECT_EQ(got("a", 2), 1) << text;
  }
}

TEST_F(KeptResultsTest, AFileThatCannotBeWrittenIsRefusedAtOnce) {
  std::filesystem::create_directory(file_);
  EXPECT_THROW(KeptResults{file_}, Error);
}

}  // namespace
}  // namespace raywalk
