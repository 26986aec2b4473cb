#include "render/serve/view_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/serve/test_client.h"

namespace raywalk::render {
namespace {

TEST(ViewRequest, IsAPanoramaWithoutAFieldOfView) {
  const ViewRequest request = view_of("x=0.25&z=-1e-1");
  EXPECT_EQ(request.viewpoint.x_m, 0.25);
  EXPECT_EQ(request.viewpoint.z_m, -0.1);
  EXPECT_EQ(request.frame.fov_deg, 0.0);
  EXPECT_EQ(request.panorama_width_px, 0);
  EXPECT_FALSE(request.method);
  EXPECT_FALSE(request.k_deg);
  EXPECT_FALSE(request.png);
  EXPECT_EQ(view_of("x=0&z=0&width=2048&y=0").panorama_width_px, 2048);
}

TEST(ViewRequest, IsFlatWithOne) {
  const ViewRequest request = view_of(
      "x=0&z=0&y=-0.25&yaw=400&pitch=-10&roll=2.5&fov=90&width=640&height=480&method=hlf-vd&k="
      "76&"
      "format=png");
  EXPECT_EQ(request.up_m, -0.25);
  EXPECT_EQ(request.frame.yaw_deg, 400.0);
  EXPECT_EQ(request.frame.pitch_deg, -10.0);
  EXPECT_EQ(request.frame.roll_deg, 2.5);
  EXPECT_EQ(request.frame.fov_deg, 90.0);
  EXPECT_EQ(request.frame.size, "640x480");
  EXPECT_EQ(request.method, ViewMethod::kHlfVd);
  EXPECT_EQ(request.k_deg, 76.0);
  EXPECT_TRUE(request.png);
  EXPECT_EQ(view_of("x=0&z=0&fov=90").frame.size, "1280x720");
}

// Each is refused, and the sentence begins with the parameter or names it.
TEST(ViewRequest, RefusesEachWrongParameterByName) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"x", "z=0"},
      {"z", "x=0"},
      {"x", "x=&z=0"},
      {"x", "x=0&x=0&z=0"},
      {"'q'", "x=0&z=0&q=1"},
      {"'X'", "X=0&z=0"},
      {"'token'", "x=0&z=0&token=1"},
      {"y", "x=0&z=0&y=up"},
      {"fov", "x=0&z=0&fov=0"},
      {"fov", "x=0&z=0&fov=-90"},
      {"fov", "x=0&z=0&fov=170.1"},
      {"width", "x=0&z=0&width=0"},
      {"width", "x=0&z=0&width=-4"},
      {"width", "x=0&z=0&width=4100"},
      {"width", "x=0&z=0&width=66"},
      {"width", "x=0&z=0&width=4e2"},
      {"width", "x=0&z=0&width=99999999999999999999"},
      {"width", "x=0&z=0&fov=90&width=4097"},
      {"height", "x=0&z=0&height=100"},
      {"height", "x=0&z=0&fov=90&height=4097"},
      {"height", "x=0&z=0&fov=90&height=0"},
      {"width x height", "x=0&z=0&fov=90&width=4096&height=4096"},
      {"method", "x=0&z=0&method=three"},
      {"method", "x=0&z=0&method="},
      {"k", "x=0&z=0&k=44.9"},
      {"k", "x=0&z=0&k=90.1"},
      {"k", "x=0&z=0&k=auto"},
      {"format", "x=0&z=0&format=gif"},
      {"format", "x=0&z=0&format=PNG"}};
  for (const auto& [name, query] : wrong) {
    std::string message;
    EXPECT_EQ(fault_of([&, &q = query] { view_of(q); }, &message), 400) << query;
    EXPECT_THAT(message, testing::ContainsRegex("^" + name + " ")) << query;
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

TEST(ViewRequest, AllowsTheLargestPictures) {
  EXPECT_EQ(view_of("x=0&z=0&width=4096").panorama_width_px, 4096);
  EXPECT_EQ(view_of("x=0&z=0&fov=90&width=4096&height=2048").frame.size, "4096x2048");
}

}  // namespace
}  // namespace raywalk::render
