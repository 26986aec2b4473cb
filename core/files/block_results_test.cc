#include "core/files/block_results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/test_error.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// The result of a block is its name.
bool make(const BlockResults& results, Block block) {
  return results.make(block, [&] { return block.text(); });
}

TEST(BlockResultsTest, AreMergedInOrderHoweverTheyWereMade) {
  const TestDirectory directory;
  const BlockResults results(directory / "blocks", "validate", "0123456789abcdef01");
  for (const int index : {3, 1, 2}) EXPECT_TRUE(make(results, {index, 3}));
  EXPECT_THAT(results.merged(), ElementsAre("1/3", "2/3", "3/3"));
}

TEST(BlockResultsTest, WhatIsDoneIsNotDoneAgain) {
  const TestDirectory directory;
  const BlockResults results(directory / "blocks", "validate", "ab");
  EXPECT_TRUE(make(results, {1, 2}));
  EXPECT_TRUE(results.done({1, 2}));
  EXPECT_FALSE(results.make({1, 2}, []() -> std::string { throw Error("made again"); }));
  EXPECT_FALSE(results.done({1, 3})) << "another division";
}

TEST(BlockResultsTest, FailedBlockLeavesNothing) {
  const TestDirectory directory;
  const BlockResults results(directory / "blocks", "validate", "ab");
  EXPECT_THROW(results.make({1, 1}, []() -> std::string { throw Error("fails"); }), Error);
  EXPECT_FALSE(results.done({1, 1}));
  EXPECT_TRUE(make(results, {1, 1}));
}

TEST(BlockResultsTest, MissingBlocksAreNamed) {
  const TestDirectory directory;
  const BlockResults results(directory / "blocks", "validate", "ab");
  EXPECT_THAT(error_of([&] { results.merged(); }), HasSubstr("validate: no block has been made"));
  for (const int index : {1, 3, 8}) make(results, {index, 8});
  EXPECT_THAT(error_of([&] { results.merged(); }),
              HasSubstr("validate: 5 of 8 blocks are missing: 2 and 4 to 7"));
}

TEST(BlockResultsTest, AnyCompleteDivisionIsMerged) {
  const TestDirectory directory;
  const BlockResults results(directory / "blocks", "validate", "ab");
  make(results, {1, 2});
  make(results, {1, 3});
  EXPECT_THAT(error_of([&] { results.merged(); }), HasSubstr("1 of 2 blocks is missing: 2"));
  make(results, {2, 3});
  make(results, {3, 3});
  EXPECT_THAT(results.merged(), ElementsAre("1/3", "2/3", "3/3"));
}

TEST(BlockResultsTest, TheDivisionThatIsFurthestIsCompleted) {
  const TestDirectory directory;
  const BlockResults results(directory / "blocks", "validate", "ab");
  EXPECT_EQ(results.count_to_complete(), 1);
  make(results, {1, 4});
  make(results, {1, 8});
  for (const int index : {2, 3, 4}) make(results, {index, 8});
  EXPECT_EQ(results.count_to_complete(), 8);
}

TEST(BlockResultsTest, ABlockIsDoneWithAllThatItLeaves) {
  const TestDirectory directory;
  bool there = false;
  const BlockResults results(directory / "blocks", "sweep", "ab", [&](Block) { return there; });
  make(results, {1, 1});
  EXPECT_FALSE(results.done({1, 1}));
  EXPECT_THAT(results.missing(), HasSubstr("1 of 1 blocks is missing: 1"));
  there = true;
  EXPECT_TRUE(results.done({1, 1}));
  EXPECT_EQ(results.missing(), "");
}

TEST(BlockResultsTest, BlocksOfOtherInputsAreNotMerged) {
  const TestDirectory directory;
  make(BlockResults(directory / "blocks", "validate", "ab"), {1, 1});
  const BlockResults other(directory / "blocks", "validate", "cd");
  EXPECT_FALSE(other.done({1, 1}));
  EXPECT_THROW(other.merged(), Error);
}

TEST(BlockResultsTest, RemovesTheResultsOfItsStepOnly) {
  const TestDirectory directory;
  const BlockResults results(directory / "blocks", "validate", "ab");
  const BlockResults other(directory / "blocks", "require", "ab");
  make(results, {1, 1});
  make(other, {1, 1});
  results.remove();
  EXPECT_FALSE(results.done({1, 1}));
  EXPECT_TRUE(other.done({1, 1}));
  other.remove();
  EXPECT_EQ(directory.entries(), 0U);
}

}  // namespace
}  // namespace raywalk
