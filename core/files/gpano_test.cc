#include "core/files/gpano.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>

namespace raywalk {
namespace {

TEST(Gpano, TheStatedAttitudeIsReadFromBothFormsOfXmp) {
  const auto attitude = [](const std::string& xmp) {
    return stated_attitude(std::as_bytes(std::span(xmp)));
  };
  const auto attributes =
      attitude(R"(<rdf GPano:PosePitchDegrees="-23.5" GPano:PoseRollDegrees="2"/>)");
  ASSERT_TRUE(attributes);
  EXPECT_EQ(attributes->pitch_deg, -23.5);
  EXPECT_EQ(attributes->roll_deg, 2.0);
  const auto element = attitude("<GPano:PoseRollDegrees>11</GPano:PoseRollDegrees>");
  ASSERT_TRUE(element);
  EXPECT_EQ(element->roll_deg, 11.0);
  EXPECT_FALSE(attitude("GPano:PosePitchDegrees=\"level\""));
  EXPECT_FALSE(attitude("JFIF"));
}

TEST(Gpano, APartOfAPanoramaIsTold) {
  const auto is_cropped = [](const std::string& xmp) {
    return is_stated_as_cropped(std::as_bytes(std::span(xmp)));
  };
  const std::string whole =
      R"(GPano:FullPanoWidthPixels="4096" GPano:FullPanoHeightPixels="2048" )";
  EXPECT_FALSE(is_cropped(whole));
  EXPECT_FALSE(is_cropped(whole + R"(GPano:CroppedAreaImageWidthPixels="4096")"));
  EXPECT_TRUE(is_cropped(whole + R"(GPano:CroppedAreaImageWidthPixels="4095")"));
  EXPECT_TRUE(is_cropped(whole + "<GPano:CroppedAreaImageHeightPixels>900<"));
}

}  // namespace
}  // namespace raywalk
