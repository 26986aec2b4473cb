#include "render/serve/file_reply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "render/serve/test_client.h"

namespace raywalk::render {
namespace {

using testing::Contains;
using testing::Pair;

using Fields = std::map<std::string, std::string>;

class FileReplyTest : public testing::Test {
 protected:
  FileReplyTest() { write_file_atomically(file_, "0123456789"); }

  Reply reply(const Fields& fields = {}) const {
    return file_reply(file_, "image/jpeg", {.fields = fields});
  }
  std::string etag() const { return reply().fields.at(0).second; }

  TestDirectory directory_;
  std::filesystem::path file_ = directory_ / "a.jpg";
};

TEST_F(FileReplyTest, IsTheFile) {
  const Reply whole = reply();
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(whole.type, "image/jpeg");
  EXPECT_EQ(whole.body, "0123456789");
  EXPECT_THAT(whole.fields, Contains(Pair("Accept-Ranges", "bytes")));
  EXPECT_THAT(whole.fields, Contains(Pair("Cache-Control", "no-cache")));
}

TEST_F(FileReplyTest, IsAPart) {
  const Reply part = reply({{"range", "bytes=2-4"}});
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "234");
  EXPECT_THAT(part.fields, Contains(Pair("Content-Range", "bytes 2-4/10")));
  for (const auto& [range, body] : {std::pair("bytes=-3", "789"),
                                    {"bytes=7-", "789"},
                                    {"bytes=-99", "0123456789"},
                                    {"bytes=9-999999999999999999", "9"}}) {
    EXPECT_EQ(reply({{"range", range}}).body, body) << range;
  }
  EXPECT_EQ(text_reply("{}\n", "a/b", {.fields = {{"range", "bytes=1-"}}}).body, "}\n");
}

TEST_F(FileReplyTest, RefusesPartsBehindTheEnd) {
  for (const char* range : {"bytes=10-", "bytes=999999999999999999-", "bytes=-0"}) {
    const Reply refused = reply({{"range", range}});
    EXPECT_EQ(refused.status, 416) << range;
    EXPECT_THAT(refused.fields, Contains(Pair("Content-Range", "bytes */10")));
  }
  write_file_atomically(file_, "");
  EXPECT_EQ(reply().status, 200);
  EXPECT_EQ(reply({{"range", "bytes=0-"}}).status, 416);
}

TEST_F(FileReplyTest, IgnoresOtherRanges) {
  for (const char* range : {"items=0-1", "bytes=4-2", "bytes=x", "bytes=-", "bytes=0-1,3-4",
                            "bytes=99999999999999999999999-"}) {
    const Reply whole = reply({{"range", range}});
    EXPECT_EQ(whole.status, 200) << range;
    EXPECT_EQ(whole.body.size(), 10U) << range;
  }
}

TEST_F(FileReplyTest, SaysWhenTheClientHasIt) {
  for (const std::string& tags : {etag(), "W/" + etag(), "\"a\", " + etag()}) {
    const Reply known = reply({{"if-none-match", tags}});
    EXPECT_EQ(known.status, 304) << tags;
    EXPECT_EQ(known.body, "");
  }
  EXPECT_EQ(reply({{"if-none-match", "\"a\""}}).status, 200);
  const std::string before = etag();
  EXPECT_EQ(reply({{"range", "bytes=0-1"}, {"if-range", before}}).body, "01");
  EXPECT_EQ(reply({{"range", "bytes=0-1"}, {"if-range", "\"a\""}}).body, "0123456789");
  write_file_atomically(file_, "9876543210");
  EXPECT_EQ(reply({{"if-none-match", before}}).body, "9876543210");
}

TEST_F(FileReplyTest, IsGoneWhenTheFileIs) {
  std::filesystem::remove(file_);
  EXPECT_EQ(fault_of([&] { reply(); }), 404);
  write_file_atomically(directory_ / "secret", "secret");
  std::filesystem::create_symlink(directory_ / "secret", file_);
  EXPECT_EQ(fault_of([&] { reply(); }), 404);
}

}  // namespace
}  // namespace raywalk::render
