#include "render/web/hotspots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class HotspotsTest : public ::testing::Test {
 protected:
  std::vector<Hotspot> read(const std::string& text) const {
    write_file_atomically(directory_ / "spots.json", text);
    return read_hotspots(directory_ / "spots.json");
  }
  std::string error(const std::string& text) const {
    return error_of([&] { read(text); });
  }
  static std::string with_link(const std::string& link) {
    return R"([{"x_m": 0, "y_m": 0, "z_m": 0, "text": "a", "link": ")" + link + R"("}])";
  }

  TestDirectory directory_;
};

TEST_F(HotspotsTest, ReadsPointsWithAndWithoutLinks) {
  const auto spots = read(R"([
    {"x_m": 0.5, "y_m": -1, "z_m": 2e-1, "text": "A chair", "link": "https://example.org/a?b#c"},
    {"x_m": 0, "y_m": 0, "z_m": 0, "text": "Nothing"}])");
  ASSERT_EQ(spots.size(), 2U);
  EXPECT_EQ(spots[0].position_m, Eigen::Vector3d(0.5, -1.0, 0.2));
  EXPECT_EQ(spots[0].text, "A chair");
  EXPECT_EQ(spots[0].link, "https://example.org/a?b#c");
  EXPECT_EQ(spots[1].link, "");
  EXPECT_TRUE(read("[]").empty());
}

TEST_F(HotspotsTest, TakesRelativeLinks) {
  for (const char* link :
       {"about.html", "../more/chair.html#top", "/rooms/2", "a?at=1:2", "HTTP://x"}) {
    EXPECT_EQ(error(with_link(link)), "no error") << link;
  }
}

TEST_F(HotspotsTest, RefusesLinksThatRunSomethingOrLeadElsewhere) {
  for (const char* link :
       {"javascript:alert(1)", "JavaScript:x", " javascript:x", "java\\tscript:x",
        "data:text/html,x", "//host/a", "\\\\\\\\host", "mailto:a@b", ""}) {
    EXPECT_THAT(error(with_link(link)),
                AllOf(HasSubstr("spots.json"), HasSubstr("[0]"), HasSubstr("relative path")))
        << link;
  }
}

TEST_F(HotspotsTest, ErrorsNameFileAndEntry) {
  const std::string good = R"({"x_m": 0, "y_m": 0, "z_m": 0, "text": "a"})";
  const auto second = [&](const std::string& entry) {
    return error("[" + good + "," + entry + "]");
  };
  EXPECT_THAT(second(R"({"x_m": 0, "y_m": 0, "z_m": 0, "text": "a", "colour": 1})"),
              AllOf(HasSubstr("spots.json"), HasSubstr("[1]"), HasSubstr("colour"),
                    HasSubstr("unknown key")));
  EXPECT_THAT(second(R"({"x_m": 0, "y_m": 0, "text": "a"})"),
              AllOf(HasSubstr("[1]"), HasSubstr("z_m")));
  EXPECT_THAT(second(R"({"x_m": "0", "y_m": 0, "z_m": 0, "text": "a"})"),
              AllOf(HasSubstr("[1]"), HasSubstr("x_m")));
  EXPECT_THAT(second(R"({"x_m": 1e400, "y_m": 0, "z_m": 0, "text": "a"})"),
              HasSubstr("spots.json"));
  EXPECT_THAT(second(R"({"x_m": 1e9, "y_m": 0, "z_m": 0, "text": "a"})"),
              AllOf(HasSubstr("[1]"), HasSubstr("x_m")));
  EXPECT_THAT(second(R"({"x_m": 0, "y_m": 0, "z_m": 0, "text": ""})"),
              AllOf(HasSubstr("[1]"), HasSubstr("empty")));
  EXPECT_THAT(second("3"), HasSubstr("[1]"));
  EXPECT_THAT(error("{}"), HasSubstr("spots.json"));
  EXPECT_THAT(error("[,]"), HasSubstr("spots.json"));
  EXPECT_THAT(error_of([&] { read_hotspots(directory_ / "none.json"); }), HasSubstr("none.json"));
}

}  // namespace
}  // namespace raywalk::render
