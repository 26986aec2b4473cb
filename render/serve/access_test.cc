#include "render/serve/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/http/test_fault.h"

namespace raywalk::render {
namespace {

RequestHead request(const std::string& host, const std::string& fields = "") {
  return parse_request_head("GET / HTTP/1.1\r\nHost: " + host + "\r\n" + fields + "\r\n");
}

int answer(const Access& access, const RequestHead& head, const std::string& target = "/") {
  std::optional<Reply> reply;
  const int fault = fault_of([&] { reply = access.check(head, parse_request_target(target)); });
  return reply ? reply->status : fault;
}

TEST(Access, KnowsLoopback) {
  for (const char* host : {"localhost", "LocalHost", "127.0.0.1", "127.1.2.3", "::1"}) {
    EXPECT_TRUE(is_loopback(host)) << host;
  }
  for (const char* host : {"", "0.0.0.0", "::", "128.0.0.1", "192.168.0.1", "localhost.evil.org",
                           "127.0.0.1.evil.org", "127.1"}) {
    EXPECT_FALSE(is_loopback(host)) << host;
  }
}

TEST(Access, OnLoopbackAnswersToItsOwnNames) {
  const Access access("127.0.0.1");
  EXPECT_FALSE(access.token());
  for (const char* host : {"localhost", "localhost:8360", "127.0.0.1:1", "[::1]", "[::1]:8360"}) {
    EXPECT_EQ(answer(access, request(host)), 0) << host;
  }
  for (const char* host : {"evil.org", "evil.org:8360", "localhost.evil.org", "[::2]", "[::1",
                           "[::1]evil.org", "", "[", "192.168.0.1"}) {
    EXPECT_EQ(answer(access, request(host)), 421) << host;
  }
  EXPECT_EQ(answer(access, parse_request_head("GET / HTTP/1.0\r\n\r\n")), 421);
}

TEST(Access, ElsewhereNeedsTheToken) {
  const Access access("0.0.0.0");
  ASSERT_TRUE(access.token());
  const std::string& token = *access.token();
  EXPECT_THAT(token, testing::MatchesRegex("[0-9a-f]{32}"));
  EXPECT_EQ(answer(access, request("museum")), 401);
  EXPECT_EQ(answer(access, request("localhost")), 401);
  EXPECT_EQ(answer(access, request("museum"), "/?token="), 401);
  EXPECT_EQ(answer(access, request("museum"), "/?token=" + token + "0"), 401);
  EXPECT_EQ(answer(access, request("museum"), "/?token=" + token + "&token=" + token), 400);
  EXPECT_EQ(answer(access, request("museum", "Cookie: raywalk_token=\r\n")), 401);
  EXPECT_EQ(answer(access, request("museum", "Cookie: raywalk_token=" + token.substr(1) + "\r\n")),
            401);
  EXPECT_EQ(answer(access, request("museum", "Cookie: raywalk_token=" + token + "\r\n")), 0);
}

TEST(Access, TurnsTheTokenIntoACookie) {
  const Access access("192.0.2.1");
  const auto reply = access.check(
      request("museum"), parse_request_target("/?x=1&token=" + *access.token() + "&z=%32"));
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 303);
  using testing::Contains;
  using testing::Pair;
  EXPECT_THAT(reply->fields, Contains(Pair("Location", "/?x=1&z=%32")));
  EXPECT_THAT(reply->fields,
              Contains(Pair("Set-Cookie", "raywalk_token=" + *access.token() +
                                              "; HttpOnly; SameSite=Strict; Path=/")));
}

TEST(Access, TokensDiffer) { EXPECT_NE(random_token(), random_token()); }

TEST(Access, ComparesWholeTexts) {
  EXPECT_TRUE(equal_in_constant_time("abc", "abc"));
  EXPECT_TRUE(equal_in_constant_time("", ""));
  for (const char* other : {"", "ab", "abcd", "Abc", "abC"}) {
    EXPECT_FALSE(equal_in_constant_time("abc", other)) << other;
  }
}

}  // namespace
}  // namespace raywalk::render
