#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>

#include "capture/base/test_fault.h"
#include "capture/trigger/gpio_lines.h"
#include "capture/trigger/gpiod_v2_stub/stub_chip.h"

namespace raywalk::capture {
namespace {

class GpiodLinesV2 : public testing::Test {
 protected:
  void SetUp() override { stub_chip() = StubChip{}; }
  void TearDown() override { EXPECT_EQ(stub_chip().living_objects, 0) << "something leaks"; }
};

TEST_F(GpiodLinesV2, DescribesTheChip) {
  EXPECT_EQ(open_gpio_chip("gpiochip7")->description(), "/dev/gpiochip7 (stub, 4 lines)");
  EXPECT_EQ(open_gpio_chip("/dev/gpiochip7")->description(), "/dev/gpiochip7 (stub, 4 lines)");
}

TEST_F(GpiodLinesV2, OutputStartsInactiveIsSetAndEndsInactive) {
  const auto chip = open_gpio_chip("gpiochip7");
  StubLine& line = stub_chip().lines[2];
  {
    const auto output = chip->request_output({.offset = 2, .active_low = true});
    EXPECT_EQ(line.direction, GPIOD_LINE_DIRECTION_OUTPUT);
    EXPECT_EQ(line.consumer, "raywalk-capture");
    EXPECT_TRUE(line.active_low);
    EXPECT_FALSE(line.active);
    output->set(true);
    EXPECT_TRUE(line.active);
  }
  EXPECT_FALSE(line.active);
  EXPECT_FALSE(line.is_requested);
}

TEST_F(GpiodLinesV2, InputReportsLevelAndEdgesInOrder) {
  const auto chip = open_gpio_chip("gpiochip7");
  const auto input = chip->request_input({.offset = 1});
  StubLine& line = stub_chip().lines[1];
  EXPECT_EQ(line.direction, GPIOD_LINE_DIRECTION_INPUT);
  EXPECT_EQ(line.edges, GPIOD_LINE_EDGE_BOTH);
  EXPECT_EQ(line.clock, GPIOD_LINE_CLOCK_MONOTONIC);
  EXPECT_FALSE(input->wait_edge(Duration::zero()));

  line.events = {{GPIOD_EDGE_EVENT_RISING_EDGE, 5}, {GPIOD_EDGE_EVENT_FALLING_EDGE, 9}};
  line.active = true;
  EXPECT_TRUE(input->is_active());
  const auto first = input->wait_edge(std::chrono::seconds(1));
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->active);
  EXPECT_EQ(first->time, SteadyTime{std::chrono::nanoseconds(5)});
  const auto second = input->wait_edge(std::chrono::seconds(1));
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->active);
}

TEST_F(GpiodLinesV2, SignalEndsAWaitWithoutAnEdge) {
  const auto chip = open_gpio_chip("gpiochip7");
  const auto input = chip->request_input({.offset = 1});
  stub_chip().wait_error = EINTR;
  EXPECT_FALSE(input->wait_edge(std::chrono::seconds(1)));
}

TEST_F(GpiodLinesV2, SaysWhyAChipCannotBeOpened) {
  expect_fault(FaultKind::kNoContact, "no GPIO chip /dev/gpiochip9; set trigger.chip",
               [] { open_gpio_chip("gpiochip9"); });
  stub_chip().open_error = EACCES;
  expect_fault(FaultKind::kNoContact, "no permission for /dev/gpiochip7; add this user",
               [] { open_gpio_chip("gpiochip7"); });
}

TEST_F(GpiodLinesV2, NamesWhoHoldsALine) {
  const auto chip = open_gpio_chip("gpiochip7");
  stub_chip().lines[3].is_requested = true;
  stub_chip().lines[3].consumer = "w1";
  expect_fault(FaultKind::kNoContact, "line 3 of /dev/gpiochip7 is in use by 'w1'",
               [&] { chip->request_output({.offset = 3}); });
}

TEST_F(GpiodLinesV2, RefusesALineThatTheChipDoesNotHave) {
  const auto chip = open_gpio_chip("gpiochip7");
  expect_fault(FaultKind::kWrongDevice, "no line 4 of /dev/gpiochip7, which has 4 lines",
               [&] { chip->request_input({.offset = 4}); });
  expect_fault(FaultKind::kWrongDevice, "no line -1 of",
               [&] { chip->request_output({.offset = -1}); });
}

TEST_F(GpiodLinesV2, SaysWhenAChipHasGone) {
  const auto chip = open_gpio_chip("gpiochip7");
  const auto output = chip->request_output({.offset = 0});
  const auto input = chip->request_input({.offset = 1});
  stub_chip().line_error = ENODEV;
  stub_chip().wait_error = ENODEV;
  const std::string words = "of /dev/gpiochip7 no longer answers";
  expect_fault(FaultKind::kNoContact, words, [&] { output->set(true); });
  expect_fault(FaultKind::kNoContact, words, [&] { input->is_active(); });
  expect_fault(FaultKind::kNoContact, words, [&] { input->wait_edge(Duration::zero()); });
}

}  // namespace
}  // namespace raywalk::capture
