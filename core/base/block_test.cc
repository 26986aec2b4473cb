#include "core/base/block.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace raywalk {
namespace {

TEST(BlockTest, SharesAreAllOfTheWorkOnceAndEqual) {
  for (const std::size_t items : {0U, 1U, 7U, 16U, 36'700U, 4'000'000'000U}) {
    for (const int count : {1, 2, 3, 16, 1000}) {
      std::size_t next = 0;
      for (int index = 1; index <= count; ++index) {
        const IndexRange share = Block{index, count}.share_of(items);
        ASSERT_EQ(share.begin, next) << items << " in " << count;
        ASSERT_GE(share.size(), items / static_cast<std::size_t>(count));
        ASSERT_LE(share.size(), items / static_cast<std::size_t>(count) + 1);
        next = share.end;
      }
      ASSERT_EQ(next, items);
    }
  }
}

TEST(BlockTest, PiecesOfDifferentSizesAreAllDoneOnceAndBalanced) {
  std::vector<std::uint64_t> sizes(57, 10);
  sizes.insert(sizes.begin() + 20, 7, 50);
  for (const int count : {1, 3, 16, 200}) {
    std::vector<int> done(sizes.size(), 0);
    std::uint64_t largest = 0;
    for (int index = 1; index <= count; ++index) {
      std::uint64_t load = 0;
      for (const std::size_t piece : Block{index, count}.share_of(sizes)) {
        ++done[piece];
        load += sizes[piece];
      }
      largest = std::max(largest, load);
    }
    EXPECT_EQ(done, std::vector<int>(sizes.size(), 1)) << count;
    EXPECT_LE(largest, std::max<std::uint64_t>(50, 920 / static_cast<std::uint64_t>(count) + 10));
  }
  EXPECT_TRUE((Block{65, 100}.share_of(sizes)).empty()) << "more blocks than pieces";
}

TEST(BlockTest, TheDefaultIsAllOfTheWork) {
  EXPECT_EQ(Block().share_of(5), (IndexRange{0, 5}));
  EXPECT_EQ((Block{3, 16}.text()), "3/16");
}

TEST(BlockTest, ListsNumbersAsPeopleDo) {
  EXPECT_EQ(listed({}), "");
  EXPECT_EQ(listed({4}), "4");
  EXPECT_EQ(listed({4, 5}), "4 and 5");
  EXPECT_EQ(listed({3, 5, 6, 7, 9}), "3, 5 to 7 and 9");
  EXPECT_EQ(listed({1, 2, 3}), "1 to 3");
}

}  // namespace
}  // namespace raywalk
