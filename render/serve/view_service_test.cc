#include "render/serve/view_service.h"

#include <gmock/gmock.h>

#include <future>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/view/test_room.h"
#include "render/serve/test_client.h"
#include "render/serve/view_request.h"
#include "render/view/view_settings.h"

namespace raywalk::render {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Pair;

cv::Mat picture_of(const Reply& reply) {
  EXPECT_EQ(reply.status, 200);
  const std::vector<unsigned char> bytes(reply.body.begin(), reply.body.end());
  return cv::imdecode(bytes, cv::IMREAD_COLOR);
}

// The picture that `raywalk-render view` makes.
cv::Mat expected_picture(const Room& room, const std::string& method, const Viewpoint& viewpoint,
                         const ViewFrame& frame, int width = 0) {
  ViewFlags flags;
  flags.parameters["method"] = method;
  if (width > 0) flags.parameters["width_px"] = std::to_string(width);
  Renderer renderer(room, view_mode(view_settings(flags)).options);
  return render_framed(&renderer, viewpoint, frame).image;
}

class ViewServiceTest : public testing::Test {
 protected:
  // Written once.
  static const Room& room() {
    static const TestRoom room(box_room(128));
    return room.room();
  }
  ViewService service_{room()};
};

TEST_F(ViewServiceTest, RendersWhatTheProgramRenders) {
  const cv::Mat flat = expected_picture(
      room(), "two-sided", {0.1, -0.2},
      {.yaw_deg = 40.0, .pitch_deg = -10.0, .roll_deg = 5.0, .fov_deg = 80.0, .size = "120x90"});
  const Reply reply = service_.answer(
      view_of("x=0.1&z=-0.2&yaw=40&pitch=-10&roll=5&fov=80&width=120&height=90&format=png"));
  EXPECT_EQ(reply.type, "image/png");
  EXPECT_THAT(reply.fields,
              Contains(Pair("X-Raywalk-View", HasSubstr("two-sided, hybrid at k = "))));
  EXPECT_EQ(largest_difference(picture_of(reply), flat), 0.0);
  for (const char* method : {"initial", "hlf-vd", "two-sided"}) {
    const cv::Mat panorama = expected_picture(room(), method, {0.1, 0.2}, {.yaw_deg = 30.0}, 64);
    EXPECT_EQ(largest_difference(
                  picture_of(service_.answer(view_of(
                      std::string("x=0.1&z=0.2&yaw=30&width=64&format=png&method=") + method))),
                  panorama),
              0.0)
        << method;
  }
}

TEST_F(ViewServiceTest, GoesUpFromTheHeightOfTheLines) {
  const TestRoom raised({.overhang_m = 0.25, .height_m = 0.2, .width = 64});
  ViewService service(raised.room());
  const cv::Mat above = expected_picture(raised.room(), "two-sided", {{0.1, 0.2}, 0.3}, {});
  const Reply reply = service.answer(view_of("x=0.1&y=0.1&z=0.2&format=png"));
  EXPECT_LE(largest_difference(picture_of(reply), above), 1.0);
  const ViewRequest initial = view_of("x=0.1&y=0.1&z=0.2&method=initial");
  EXPECT_EQ(fault_of([&] { service.answer(initial); }), 400);
}

TEST_F(ViewServiceTest, IsAJpegOfTheCapturedSizeUnlessAskedOtherwise) {
  const Reply reply = service_.answer(view_of("x=0&z=0"));
  EXPECT_EQ(reply.type, "image/jpeg");
  EXPECT_THAT(reply.fields, Contains(Pair("Cache-Control", "no-store")));
  const cv::Mat panorama = expected_picture(room(), "two-sided", {0, 0}, {});
  ASSERT_EQ(picture_of(reply).size(), panorama.size());
  EXPECT_GT(psnr_db(picture_of(reply), panorama), 30.0);
}

TEST_F(ViewServiceTest, KeepsFewRenderersAndAllAnswersRight) {
  for (int round = 0; round < 2; ++round) {
    for (const int width : {32, 64, 96, 128, 160, 192}) {
      const Reply reply =
          service_.answer(view_of("x=0&z=0&format=png&width=" + std::to_string(width)));
      EXPECT_EQ(picture_of(reply).cols, width);
    }
  }
}

TEST_F(ViewServiceTest, OutsideIsUnprocessable) {
  std::string message;
  EXPECT_EQ(fault_of([&] { service_.answer(view_of("x=9&z=0")); }, &message), 422);
  EXPECT_THAT(message, HasSubstr("outside"));
  EXPECT_EQ(service_.answer(view_of("x=0&z=0")).status, 200);
}

TEST_F(ViewServiceTest, NeedsDistancesForCorrectedViews) {
  const TestRoom plain({.width = 64, .distances = false});
  ViewService service(plain.room());
  std::string message;
  EXPECT_EQ(fault_of([&] { service.answer(view_of("x=0&z=0&method=hlf-vd")); }, &message), 400);
  EXPECT_THAT(message, HasSubstr("method"));
  EXPECT_THAT(service.answer(view_of("x=0&z=0")).fields,
              Contains(Pair("X-Raywalk-View", testing::StartsWith("initial"))));
}

TEST_F(ViewServiceTest, RefusesViewsWhenTooManyWaitAndOnceItIsStopped) {
  std::vector<std::future<int>> statuses;
  for (int i = 0; i < 16; ++i) {
    statuses.push_back(std::async(std::launch::async, [this] {
      return service_.answer(view_of("x=0&z=0&width=1024")).status;
    }));
  }
  int rendered = 0;
  for (std::future<int>& status : statuses) {
    const int value = status.get();
    EXPECT_THAT(value, testing::AnyOf(200, 503));
    rendered += value == 200 ? 1 : 0;
  }
  EXPECT_GE(rendered, 1 + kMostWaitingViews);
  EXPECT_LT(rendered, 16);
  EXPECT_EQ(service_.answer(view_of("x=0&z=0")).status, 200);
  service_.stop();
  const Reply reply = service_.answer(view_of("x=0&z=0"));
  EXPECT_EQ(reply.status, 503);
  EXPECT_THAT(reply.fields, Contains(Pair("Retry-After", "1")));
}

// The other parameters are those of the views that are compared above.
TEST(ViewRequest, IsAPanoramaUnlessItHasAFieldOfView) {
  EXPECT_EQ(view_of("x=0&z=0").frame.fov_deg, 0.0);
  EXPECT_FALSE(view_of("x=0&z=0").k_deg);
  EXPECT_EQ(view_of("x=0&z=0&k=76").k_deg, 76.0);
  EXPECT_EQ(view_of("x=0&z=0&width=4096&y=0").panorama_width_px, 4096);
  EXPECT_EQ(view_of("x=0&z=0&fov=90").frame.size, "1280x720");
  EXPECT_EQ(view_of("x=0&z=0&fov=90&width=4096&height=2048").frame.size, "4096x2048");
}

// Each is refused, and the sentence begins with the parameter or names it.
TEST(ViewRequest, RefusesEachWrongParameterByName) {
  const auto refuses = [](const std::string& name, const std::string& query) {
    std::string message;
    EXPECT_EQ(fault_of([&] { view_of(query); }, &message), 400) << query;
    EXPECT_THAT(message, testing::ContainsRegex("^" + name + " ")) << query;
  };
  for (const char* query : {"z=0", "x=&z=0", "x=0&x=0&z=0"}) refuses("x", query);
  refuses("z", "x=0");
  refuses("'X'", "X=0&z=0");
  const std::map<std::string, std::vector<std::string>> wrong{
      {"'q'", {"q=1"}},
      {"'token'", {"token=1"}},
      {"y", {"y=up"}},
      {"fov", {"fov=0", "fov=-90", "fov=170.1"}},
      {"width",
       {"width=0", "width=-4", "width=4100", "width=66", "width=4e2", "width=99999999999999999999",
        "fov=90&width=4097"}},
      {"height", {"height=100", "fov=90&height=4097", "fov=90&height=0"}},
      {"width x height", {"fov=90&width=4096&height=4096"}},
      {"method", {"method=three", "method="}},
      {"k", {"k=44.9", "k=90.1", "k=auto"}},
      {"format", {"format=gif", "format=PNG"}}};
  for (const auto& [name, queries] : wrong) {
    for (const std::string& query : queries) refuses(name, "x=0&z=0&" + query);
  }
}

TEST(ViewRequest, RefusesWhatIsNoNumber) {
  for (const char* name : {"x", "z", "y", "yaw", "pitch", "roll", "fov", "k"}) {
    for (const char* value : {"nan", "NaN", "inf", "-inf", "Infinity", "1e999", "-1e999", "0x10",
                              "1,5", "1 ", " 1", "1e", "1e7"}) {
      const std::string others = name == std::string("x")   ? "&z=0"
                                 : name == std::string("z") ? "&x=0"
                                                            : "&x=0&z=0";
      std::string message;
      EXPECT_EQ(fault_of([&] { view_of(std::string(name) + "=" + value + others); }, &message), 400)
          << name << "=" << value;
      EXPECT_THAT(message, testing::StartsWith(std::string(name) + " is ")) << value;
    }
  }
}

}  // namespace
}  // namespace raywalk::render
