#include "core/base/processor_use.h"

#include <gtest/gtest.h>

namespace raywalk {
namespace {

TEST(ProcessorUse, IsReadFromTheKernelsTicks) {
  const ProcessorUse use = processor_use_from(
      "cpu  1000 200 300 9000 500 10 20 70 400 0\ncpu0 1 2 3 4 5 6 7 8 9 10\n", 12.5);
  EXPECT_DOUBLE_EQ(use.all_s, 111.0);
  EXPECT_DOUBLE_EQ(use.busy_s, 16.0);
  EXPECT_EQ(use.own_s, 12.5);
}

TEST(ProcessorUse, UnreadableTextIsNoUse) {
  for (const char* text : {"", "cpu 1 2 3", "intr 1 2 3 4 5 6 7 8", "cpu a b c d e f g h"}) {
    EXPECT_EQ(processor_use_from(text, 1.0).all_s, 0.0) << text;
    EXPECT_EQ(processor_use_from(text, 1.0).own_s, 0.0) << text;
  }
}

TEST(ProcessorUse, OthersHaveWhatIsBusyAndNotOwn) {
  const ProcessorUse before{.all_s = 1000.0, .busy_s = 500.0, .own_s = 20.0};
  EXPECT_NEAR(share_of_others(before, {1200.0, 650.0, 70.0}), 0.5, 0.02);
  EXPECT_EQ(share_of_others(before, {1200.0, 550.0, 70.0}), 0.0);
  // A tick of rounding is not a load, and neither is a clock that stands still.
  EXPECT_EQ(share_of_others(before, {1000.02, 500.02, 20.005}), 0.0);
  EXPECT_EQ(share_of_others(before, before), 0.0);
}

TEST(ProcessorUse, ThisMachineTellsIt) {
  const ProcessorUse use = processor_use();
  EXPECT_GT(use.all_s, 0.0);
  EXPECT_LE(use.busy_s, use.all_s);
  EXPECT_GE(use.own_s, 0.0);
}

}  // namespace
}  // namespace raywalk
