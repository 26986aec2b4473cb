#include "core/base/recently_made.h"

#include <gmock/gmock.h>

#include <atomic>
#include <string>
#include <vector>

namespace raywalk {
namespace {

using ::testing::ElementsAre;
using ::testing::Pointee;

TEST(RecentlyMadeTest, KeepsTheValuesUsedLast) {
  std::vector<int> made;
  RecentlyMade<int, std::string> values(2, [&](int key) {
    made.push_back(key);
    return std::to_string(key);
  });
  for (const int key : {1, 2, 1, 3, 1, 2}) EXPECT_EQ(*values.get(key), std::to_string(key));
  EXPECT_THAT(made, ElementsAre(1, 2, 3, 2));
}

TEST(RecentlyMadeTest, GivesManyAtOnceInTheirOrderEvenMoreThanAreKept) {
  std::atomic<int> made = 0;
  RecentlyMade<int, int> values(2, [&](int key) {
    ++made;
    return 10 * key;
  });
  const auto held = values.get(4);
  const std::vector<int> keys{4, 0, 1, 2};
  EXPECT_THAT(values.get_all(keys), ElementsAre(held, Pointee(0), Pointee(10), Pointee(20)));
  EXPECT_EQ(made, 4);
  EXPECT_EQ(*held, 40);
  EXPECT_TRUE(values.get_all({}).empty());
}

TEST(RecentlyMadeTest, CanBeUsedBySeveralThreads) {
  RecentlyMade<int, int> values(2, [](int key) { return 10 * key; });
  parallel_for(0, 40, 1,
               [&](int begin, int) { EXPECT_EQ(*values.get(begin % 5), 10 * (begin % 5)); });
}

}  // namespace
}  // namespace raywalk
