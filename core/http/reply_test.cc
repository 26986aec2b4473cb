#include "core/http/reply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace raywalk {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(Reply, HasStatusTypeAndLength) {
  const std::string text = head_text({.status = 206, .type = "image/jpeg", .body = "abc"}, {});
  EXPECT_THAT(text, StartsWith("HTTP/1.1 206 Partial Content\r\n"));
  EXPECT_THAT(text, HasSubstr("\r\nContent-Type: image/jpeg\r\nContent-Length: 3\r\n"));
  EXPECT_THAT(text, HasSubstr("\r\nX-Content-Type-Options: nosniff\r\n"));
  EXPECT_THAT(text, HasSubstr("\r\nReferrer-Policy: no-referrer\r\n"));
  EXPECT_THAT(text, HasSubstr("\r\nContent-Security-Policy: default-src 'self';"));
  EXPECT_THAT(text, Not(HasSubstr("Connection")));
  EXPECT_THAT(text, EndsWith("\r\n\r\n"));
  EXPECT_THAT(head_text({}, {.last = true}), HasSubstr("\r\nConnection: close\r\n"));
}

TEST(Reply, NotModifiedStatesNoLength) {
  EXPECT_THAT(head_text({.status = 304}, {}), Not(HasSubstr("Content-Length")));
}

TEST(Reply, FieldsCannotEndTheirLine) {
  const std::string text =
      head_text({.fields = {{"X-Raywalk-View", "a\r\nSet-Cookie: b=\xc2\xb0"}}}, {});
  EXPECT_THAT(text, HasSubstr("\r\nX-Raywalk-View: a??Set-Cookie: b=??\r\n"));
}

TEST(Reply, RefusalIsASentenceInJson) {
  const Reply reply = refusal(HttpFault(400, "x is '\"\x1b\xff'"));
  EXPECT_EQ(reply.status, 400);
  EXPECT_EQ(reply.type, "application/json");
  EXPECT_EQ(reply.body, "{\"error\":\"x is '\\\"\\\\u001b\\\\xff'\"}\n");
}

}  // namespace
}  // namespace raywalk
