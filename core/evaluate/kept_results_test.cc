#include "core/evaluate/kept_results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

class KeptResultsTest : public ::testing::Test {
 protected:
  TestDirectory directory_;
  std::filesystem::path file_ = directory_ / "some.partial";
};

TEST_F(KeptResultsTest, AreFoundByTheNextRunUntilTheyAreRemoved) {
  {
    KeptResults kept(file_);
    EXPECT_EQ(kept.find("a"), nullptr);
    kept.keep("a", {{"x", 0.1}, {"y", std::nan("")}});
    kept.keep("b", 2);
    EXPECT_TRUE(kept.find("a")->at("y").is_null());
  }
  KeptResults kept(file_);
  ASSERT_NE(kept.find("a"), nullptr);
  EXPECT_EQ(*kept.find("a"), ordered_json({{"x", 0.1}, {"y", nullptr}}));
  EXPECT_EQ(*kept.find("b"), 2);
  EXPECT_EQ(kept.find("c"), nullptr);
  kept.remove();
  EXPECT_EQ(directory_.entries(), 0U);
}

TEST_F(KeptResultsTest, DamageCountsAsMissing) {
  KeptResults(file_).keep("a", {{"x", 12}});
  const std::string whole = read_file(file_);
  std::string changed = whole;
  changed[changed.find("12")] = '7';
  for (const std::string& text :
       {std::string(), std::string("{}"), whole.substr(0, 70), changed, std::string(100, '[')}) {
    write_file_atomically(file_, text);
    KeptResults kept(file_);
    EXPECT_EQ(kept.find("a"), nullptr) << text;
    kept.keep("b", 1);
    EXPECT_NE(KeptResults(file_).find("b"), nullptr);
  }
}

TEST_F(KeptResultsTest, AFileThatCannotBeWrittenIsRefusedAtOnce) {
  std::filesystem::create_directory(file_);
  EXPECT_THROW(KeptResults{file_}, Error);
}

}  // namespace
}  // namespace raywalk
