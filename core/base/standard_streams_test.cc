#include "core/base/standard_streams.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <iostream>
#include <string>
#include <thread>

namespace raywalk {
namespace {

struct Printed {
  std::string out;
  std::string err;
};

Printed printed_by(const std::function<void()>& work) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  {
    const EscapedStreams streams;
    work();
  }
  Printed printed;
  printed.err = testing::internal::GetCapturedStderr();
  printed.out = testing::internal::GetCapturedStdout();
  return printed;
}

TEST(EscapedStreams, EveryWayOfPrintingIsEscaped) {
  const Printed printed = printed_by([] {
    std::cout << "one \x1b[31m\n";
    std::printf("two %s\n", "\x1b[32m");
    std::cerr << "three \xFF\n";
    std::clog << "four \x07\n";
    std::fputs("five \x1b]0;title\x07\n", stderr);
  });
  EXPECT_EQ(printed.out, "one \\u001b[31m\ntwo \\u001b[32m\n");
  EXPECT_EQ(printed.err, "three \\xff\nfour \\u0007\nfive \\u001b]0;title\\u0007\n");
}

TEST(EscapedStreams, ProgramsOwnTextIsUnchanged) {
  const std::string text = "Größe\t90°\n部屋\n";
  EXPECT_EQ(printed_by([&] { std::cout << text; }).out, text);
}

// However the buffers of the C library cut them.
TEST(EscapedStreams, CharactersInPiecesStayWhole) {
  std::string text;
  for (int i = 0; i < 20000; ++i) text += i % 7 == 0 ? "部" : "x";
  EXPECT_EQ(printed_by([&] { std::cout << text << '\n'; }).out, text + "\n");
  EXPECT_EQ(printed_by([&] {
              for (const char byte : text.substr(0, 300)) std::cerr.put(byte);
            }).err,
            text.substr(0, 300));
}

TEST(EscapedStreams, EndWithTheirLifetime) {
  printed_by([] {});
  testing::internal::CaptureStdout();
  std::cout << "\x1b[0m" << std::flush;
  std::printf("\x07");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "\x1b[0m\x07");
}

TEST(CapturedErrors, KeepsTheThreadsOwnErrors) {
  std::string kept;
  const Printed printed = printed_by([&] {
    const CapturedErrors captured;
    std::fprintf(stderr, "libpng error: %s\n", "IDAT: CRC error");
    std::cerr << "and more\n";
    std::thread([] { std::cerr << "of another thread\n"; }).join();
    std::cout << "a result\n";
    kept = captured.text();
  });
  EXPECT_EQ(kept, "libpng error: IDAT: CRC error\nand more\n");
  EXPECT_EQ(printed.err, "of another thread\n");
  EXPECT_EQ(printed.out, "a result\n");
}

TEST(PrintToTerminal, ControlsStay) {
  EXPECT_EQ(printed_by([] { print_to_terminal("\r5 %\x1b[K"); }).err, "\r5 %\x1b[K");
}

}  // namespace
}  // namespace raywalk
