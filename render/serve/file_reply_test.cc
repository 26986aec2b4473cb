#include "render/serve/file_reply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/http/test_fault.h"

namespace raywalk::render {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Key;
using testing::Not;
using testing::Pair;
using testing::StartsWith;

class FileReplyTest : public testing::Test {
 protected:
  FileReplyTest() { write_file_atomically(file_.file, "0123456789"); }

  Reply reply(const std::string& fields = "", const std::string& method = "GET") const {
    return file_reply(file_,
                      parse_request_head(method + " / HTTP/1.1\r\nHost: a\r\n" + fields + "\r\n"));
  }
  std::string etag() const {
    for (const auto& [name, value] : reply().fields) {
      if (name == "ETag") return value;
    }
    return "";
  }

  TestDirectory directory_;
  ServedFile file_{directory_ / "a.jpg", "image/jpeg"};
};

TEST_F(FileReplyTest, IsTheFile) {
  const Reply whole = reply();
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(whole.type, "image/jpeg");
  EXPECT_EQ(whole.body, "0123456789");
  EXPECT_THAT(whole.fields, Contains(Pair("Accept-Ranges", "bytes")));
  EXPECT_THAT(whole.fields, Contains(Pair("Cache-Control", "no-cache")));
  EXPECT_THAT(whole.fields, Contains(Pair("ETag", StartsWith("\""))));
}

TEST_F(FileReplyTest, IsAPart) {
  const Reply part = reply("Range: bytes=2-4\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "234");
  EXPECT_EQ(part.type, "image/jpeg");
  EXPECT_THAT(part.fields, Contains(Pair("Content-Range", "bytes 2-4/10")));
  EXPECT_EQ(reply("Range: bytes=-3\r\n").body, "789");
  EXPECT_EQ(reply("Range: bytes=0-,5-6,1-99\r\n").body, "0123456789");
}

TEST_F(FileReplyTest, IsSeveralParts) {
  const Reply parts = reply("Range: bytes=7-8,0-1\r\n");
  EXPECT_EQ(parts.status, 206);
  ASSERT_THAT(parts.type, StartsWith("multipart/byteranges; boundary="));
  const std::string boundary = parts.type.substr(parts.type.find('=') + 1);
  const std::string type = "Content-Type: image/jpeg\r\n";
  EXPECT_EQ(parts.body, "--" + boundary + "\r\n" + type +
                            "Content-Range: bytes 7-8/10\r\n\r\n78\r\n--" + boundary + "\r\n" +
                            type + "Content-Range: bytes 0-1/10\r\n\r\n01\r\n--" + boundary +
                            "--\r\n");
  EXPECT_THAT(parts.fields, Not(Contains(Key("Content-Range"))));
}

TEST_F(FileReplyTest, RefusesPartsBehindTheEnd) {
  const Reply refused = reply("Range: bytes=10-\r\n");
  EXPECT_EQ(refused.status, 416);
  EXPECT_THAT(refused.fields, Contains(Pair("Content-Range", "bytes */10")));
  EXPECT_THAT(refused.body, HasSubstr("10 bytes"));
}

TEST_F(FileReplyTest, IgnoresRangesThatAreNone) {
  for (const char* range : {"items=0-1", "bytes=4-2", "bytes=x"}) {
    const Reply whole = reply(std::string("Range: ") + range + "\r\n");
    EXPECT_EQ(whole.status, 200) << range;
    EXPECT_EQ(whole.body.size(), 10U) << range;
  }
  EXPECT_EQ(reply("Range: bytes=0-1\r\nRange: bytes=0-2\r\n").status, 200);
  EXPECT_EQ(reply("Range: bytes=0-1\r\n", "HEAD").status, 200);
}

TEST_F(FileReplyTest, SaysWhenTheClientHasIt) {
  for (const std::string& tags : {etag(), "W/" + etag(), "\"a\", " + etag(), std::string("*")}) {
    const Reply reply_of = reply("If-None-Match: " + tags + "\r\n");
    EXPECT_EQ(reply_of.status, 304) << tags;
    EXPECT_EQ(reply_of.body, "");
    EXPECT_THAT(reply_of.fields, Contains(Key("ETag")));
  }
  EXPECT_EQ(reply("If-None-Match: \"a\"\r\n").status, 200);
  const std::string before = etag();
  write_file_atomically(file_.file, "9876543210");
  EXPECT_EQ(reply("If-None-Match: " + before + "\r\n").body, "9876543210");
}

TEST_F(FileReplyTest, GivesPartsOfTheSameFileOnly) {
  EXPECT_EQ(reply("Range: bytes=0-1\r\nIf-Range: " + etag() + "\r\n").body, "01");
  for (const std::string& tag :
       {std::string("\"a\""), "W/" + etag(), std::string("Wed, 01 Jan 2025 00:00:00 GMT")}) {
    EXPECT_EQ(reply("Range: bytes=0-1\r\nIf-Range: " + tag + "\r\n").body, "0123456789") << tag;
  }
}

TEST_F(FileReplyTest, AnEmptyFileHasNoParts) {
  write_file_atomically(file_.file, "");
  EXPECT_EQ(reply().status, 200);
  EXPECT_EQ(reply("Range: bytes=0-\r\n").status, 416);
}

TEST_F(FileReplyTest, IsGoneWhenTheFileIs) {
  std::filesystem::remove(file_.file);
  EXPECT_EQ(fault_of([&] { reply(); }), 404);
  write_file_atomically(directory_ / "secret", "secret");
  std::filesystem::create_symlink(directory_ / "secret", file_.file);
  EXPECT_EQ(fault_of([&] { reply(); }), 404);
  std::filesystem::remove(file_.file);
  std::filesystem::create_directory(file_.file);
  EXPECT_EQ(fault_of([&] { reply(); }), 404);
}

TEST_F(FileReplyTest, ATextIsServedAlike) {
  const auto text = [](const std::string& fields) {
    return text_reply("{}\n", "application/json",
                      parse_request_head("GET / HTTP/1.1\r\nHost: a\r\n" + fields + "\r\n"));
  };
  EXPECT_EQ(text("").body, "{}\n");
  EXPECT_EQ(text("Range: bytes=1-\r\n").body, "}\n");
}

}  // namespace
}  // namespace raywalk::render
