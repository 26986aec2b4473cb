#include "core/http/request_head.h"

#include <gtest/gtest.h>

#include "core/http/test_fault.h"

namespace raywalk {
namespace {

int fault_of_head(const std::string& text) {
  return fault_of([&] { parse_request_head(text); });
}

RequestHead head_with(const std::string& fields) {
  return parse_request_head("GET / HTTP/1.1\r\nHost: a\r\n" + fields + "\r\n");
}

TEST(RequestHead, HasLineAndFields) {
  const RequestHead head = parse_request_head(
      "GET /view?x=1 HTTP/1.1\r\nHost: localhost:8360\r\nRANGE:\t bytes=0-1 \r\nEmpty:\r\n\r\n");
  EXPECT_EQ(head.method, "GET");
  EXPECT_EQ(head.target, "/view?x=1");
  EXPECT_EQ(head.minor_version, 1);
  ASSERT_EQ(head.fields.size(), 3U);
  EXPECT_EQ(*field_of(head, "host"), "localhost:8360");
  EXPECT_EQ(*field_of(head, "range"), "bytes=0-1");
  EXPECT_EQ(*field_of(head, "empty"), "");
  EXPECT_EQ(field_of(head, "cookie"), nullptr);
}

TEST(RequestHead, OfTwoFieldsOfANameNoneIsTaken) {
  EXPECT_EQ(field_of(head_with("Range: bytes=0-1\r\nRange: bytes=2-3\r\n"), "range"), nullptr);
}

TEST(RequestHead, RefusesWhatIsNone) {
  for (const char* text :
       {"", "\r\n", "GET\r\n\r\n", "GET /\r\n\r\n", "GET  / HTTP/1.1\r\nHost: a\r\n\r\n",
        "GET / x HTTP/1.1\r\nHost: a\r\n\r\n", "G(T / HTTP/1.1\r\nHost: a\r\n\r\n",
        "GET /\x01 HTTP/1.1\r\nHost: a\r\n\r\n", "GET /\xc3\xa4 HTTP/1.1\r\nHost: a\r\n\r\n",
        "GET / HTTP/1.1\nHost: a\n\n", "GET / HTTP/1.1\r\nHost a\r\n\r\n",
        "GET / HTTP/1.1\r\nHost : a\r\n\r\n", "GET / HTTP/1.1\r\nHost: a\r\n folded\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: a\x01\r\n\r\n", "GET / HTTP/1.1\r\nHost: a\rb\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: a\r\n: b\r\n\r\n", "GET / FTP/1.1\r\nHost: a\r\n\r\n",
        "GET / HTTP/1.10\r\nHost: a\r\n\r\n", "GET / HTTP/x.1\r\nHost: a\r\n\r\n"}) {
    EXPECT_EQ(fault_of_head(text), 400) << text;
  }
  EXPECT_EQ(fault_of_head(std::string("GET / HTTP/1.1\r\nHost: a\0b\r\n\r\n", 29)), 400);
  for (const char* version : {"HTTP/0.9", "HTTP/2.0", "HTTP/1.2"}) {
    EXPECT_EQ(fault_of_head(std::string("GET / ") + version + "\r\nHost: a\r\n\r\n"), 505);
  }
}

TEST(RequestHead, NeedsOneHost) {
  EXPECT_EQ(fault_of_head("GET / HTTP/1.1\r\n\r\n"), 400);
  EXPECT_EQ(fault_of_head("GET / HTTP/1.1\r\nHost: a\r\nHost: a\r\n\r\n"), 400);
  EXPECT_EQ(fault_of_head("GET / HTTP/1.0\r\n\r\n"), 0);
}

TEST(RequestHead, TakesNoBody) {
  const auto fault_with = [](const char* fields) { return fault_of([&] { head_with(fields); }); };
  EXPECT_EQ(fault_with("Content-Length: 0\r\n"), 0);
  for (const char* fields :
       {"Content-Length: 1\r\n", "Content-Length: 0\r\nContent-Length: 0\r\n",
        "Content-Length: x\r\n", "Content-Length:\r\n", "Transfer-Encoding: chunked\r\n",
        "Content-Length: 0\r\nTransfer-Encoding: chunked\r\n"}) {
    EXPECT_EQ(fault_with(fields), 413) << fields;
  }
  EXPECT_EQ(fault_with("Expect: 100-continue\r\n"), 417);
}

TEST(RequestHead, HasLimits) {
  const auto line_of = [](std::size_t size) {
    const std::string rest = "GET / HTTP/1.1";
    return "GET /" + std::string(size - rest.size(), 'a') + " HTTP/1.1\r\nHost: a\r\n\r\n";
  };
  EXPECT_EQ(fault_of_head(line_of(kMostRequestLine)), 0);
  EXPECT_EQ(fault_of_head(line_of(kMostRequestLine + 1)), 414);
  const auto fault_with_fields = [](std::size_t count) {
    std::string fields;
    for (std::size_t i = 1; i < count; ++i) fields += "A: b\r\n";  // besides Host
    return fault_of([&] { head_with(fields); });
  };
  EXPECT_EQ(fault_with_fields(kMostRequestFields), 0);
  EXPECT_EQ(fault_with_fields(kMostRequestFields + 1), 431);
  EXPECT_EQ(fault_of([] { head_with("A: " + std::string(kMostRequestHead, 'b') + "\r\n"); }), 431);
}

TEST(RequestHead, TellsWhetherTheConnectionStays) {
  EXPECT_TRUE(keeps_alive(head_with("")));
  EXPECT_TRUE(keeps_alive(head_with("Connection: keep-alive\r\n")));
  EXPECT_FALSE(keeps_alive(head_with("Connection: close\r\n")));
  EXPECT_FALSE(keeps_alive(head_with("Connection: Upgrade, Close\r\n")));
  EXPECT_FALSE(keeps_alive(parse_request_head("GET / HTTP/1.0\r\n\r\n")));
}

TEST(RequestHead, HasCookies) {
  const RequestHead head = head_with("Cookie: a=1; token=x=y;b=2\r\nCookie: c=3\r\n");
  EXPECT_EQ(cookie_of(head, "a"), "1");
  EXPECT_EQ(cookie_of(head, "token"), "x=y");
  EXPECT_EQ(cookie_of(head, "b"), "2");
  EXPECT_EQ(cookie_of(head, "c"), "3");
  EXPECT_EQ(cookie_of(head, "toke"), "");
  EXPECT_EQ(cookie_of(head_with("Cookie: a=1; a=2\r\n"), "a"), "");
  EXPECT_EQ(cookie_of(head_with("Cookie: ;;=;\r\n"), "a"), "");
}

}  // namespace
}  // namespace raywalk
