#include "core/view/view_parameter.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/files/test_support.h"
#include "core/view/test_room.h"
#include "core/view/view_options.h"
#include "core/view/viewport.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// The first and the last value, which every parameter takes.
std::vector<double> values_of(const ViewParameter& parameter) {
  if (parameter.value.kind == ParameterKind::kChoice) {
    return {0.0, static_cast<double>(parameter.names.size()) - 1.0};
  }
  return {parameter.least, parameter.most};
}

ViewOptions options_with(const ViewParameter& parameter, double value) {
  ViewOptions options{.width = 64};
  parameter.value.set(&options, value);
  return options;
}

TEST(ViewParameterTest, EveryParameterHasItsOwnNamesAndIsExplained) {
  std::set<std::string> keys, flags, texts;
  for (const ViewParameter& parameter : kViewParameters) {
    EXPECT_TRUE(keys.insert(parameter.key).second) << parameter.key;
    EXPECT_NE(parameter.value.get, nullptr) << parameter.key;
    EXPECT_LT(values_of(parameter)[0], values_of(parameter)[1]) << parameter.key;
    EXPECT_TRUE(flags.insert(parameter.flag).second) << parameter.key;
    EXPECT_STRNE(parameter.help, "") << parameter.key;
    EXPECT_STRNE(parameter.cost, "") << parameter.key;
    // Different options have different texts.
    for (const double value : values_of(parameter)) {
      const ViewOptions options = options_with(parameter, value);
      if (options == ViewOptions{.width = 64}) continue;
      EXPECT_TRUE(texts.insert(text_of(options)).second) << parameter.key << ' ' << value;
    }
  }
}

TEST(ViewParameterTest, EveryValueIsReadBackFromOptionsAndText) {
  for (const ViewParameter& parameter : kViewParameters) {
    for (const double value : values_of(parameter)) {
      const ViewOptions options = options_with(parameter, value);
      EXPECT_EQ(parameter.value.get(options), value) << parameter.key;
      EXPECT_EQ(value_of(parameter, text_of(parameter, value)), value) << parameter.key;
      EXPECT_NO_THROW(require_view_options(options)) << parameter.key << ' ' << value;
    }
    EXPECT_FALSE(fault_of(parameter, default_of(parameter))) << parameter.key;
    if (!parameter.sweep || parameter.sweep->of_truth_width) continue;
    for (const double value : parameter.sweep->values) {
      EXPECT_FALSE(fault_of(parameter, value)) << parameter.key;
    }
  }
}

TEST(ViewParameterTest, ValuesBesideTheRangeAreRefused) {
  for (const ViewParameter& parameter : kViewParameters) {
    if (parameter.value.kind == ParameterKind::kChoice) {
      EXPECT_THAT([&] { value_of(parameter, "best"); },
                  ThrowsMessage<std::invalid_argument>(HasSubstr("not a valid choice")));
      continue;
    }
    for (const double value : {parameter.least - 2.0, parameter.most + parameter.multiple_of}) {
      EXPECT_TRUE(fault_of(parameter, value)) << parameter.key << ' ' << value;
      EXPECT_THROW(value_of(parameter, std::to_string(static_cast<int>(value))),
                   std::invalid_argument)
          << parameter.key;
      EXPECT_THAT(error_of([&] { require_view_options(options_with(parameter, value)); }),
                  HasSubstr(parameter.key));
    }
    for (const char* text : {"", "nan", "1e999", "best", "4x"}) {
      EXPECT_THROW(value_of(parameter, text), std::invalid_argument)
          << parameter.key << ' ' << text;
    }
    EXPECT_TRUE(fault_of(parameter, std::nan(""))) << parameter.key;
  }
}

TEST(ViewParameterTest, FaultsNameTheValuesAndTheirUnit) {
  EXPECT_EQ(fault_of(parameter_of("k_deg"), 30.0), "must be in 45..90 degrees");
  EXPECT_EQ(fault_of(parameter_of("width_px"), 30.0),
            "must be 0 or a multiple of 4 in 4..32768 pixels");
  EXPECT_EQ(fault_of(parameter_of("stations_mixed"), 17.0), "must be a whole number in 1..16");
  EXPECT_THAT([] { value_of(parameter_of("interpolation"), "cubik"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("did you mean 'cubic'")));
  EXPECT_THROW(parameter_of("layers"), std::out_of_range);
}

TEST(ViewParameterTest, TheProgramChoosesWhatIsNotGiven) {
  const ViewOptions options = default_options();
  EXPECT_EQ(options.width, 0);
  EXPECT_EQ(value_of(parameter_of("width_px"), "0"), 0.0);
  // A renderer needs the chosen values.
  EXPECT_THAT(error_of([&] { require_view_options(options); }), HasSubstr("width_px is 0"));
  EXPECT_THAT(error_of([] { require_view_options({}); }), HasSubstr("width_px is 0"));
  EXPECT_NO_THROW(require_view_options({.width = 64}));
}

TEST(ViewMethod, NamesAreReadBack) {
  for (const char* name : kViewMethodNames) {
    EXPECT_EQ(method_name(method_from_name(name)), name);
  }
  EXPECT_THAT([] { method_from_name("best"); },
              ThrowsMessage<UsageError>(AllOf(HasSubstr("'best'"), HasSubstr("two-sided"))));
}

constexpr PanoramaSize kPanorama{1024, 512};

Viewport turned(double yaw_deg, double pitch_deg, double roll_deg, double fov_deg) {
  return looking(yaw_deg, pitch_deg, roll_deg, fov_deg, 90, 70);
}

TEST(Viewport, RejectsInvalidPictures) {
  const Viewport good = turned(0, 0, 0, 90);
  EXPECT_NO_THROW(require_viewport(good));
  EXPECT_NO_THROW(require_viewport(turned(0, 0, 0, 170)));
  for (const double fov_deg : {0.0, -1.0, 170.1, 180.0, std::nan("")}) {
    EXPECT_THROW(require_viewport(turned(0, 0, 0, fov_deg)), UsageError) << fov_deg;
  }
  for (const int side : {0, -1, 16385}) {
    Viewport bad = good;
    bad.width = side;
    EXPECT_THROW(require_viewport(bad), UsageError);
    bad = good;
    bad.height = side;
    EXPECT_THROW(require_viewport(bad), UsageError);
  }
  EXPECT_THROW(require_viewport(turned(std::numeric_limits<double>::infinity(), 0, 0, 90)),
               UsageError);
}

// All four pixels around each of its rays, for any attitude, also over the poles and across the
// seam.
TEST(ViewportProperty, PartHoldsEverySampleOfThePicture) {
  std::mt19937_64 random(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int n = 0; n < 400; ++n) {
    const double fov_deg = std::pow(10.0, uniform(-1.0, std::log10(170.0)));
    const double pitch_deg = n % 4 == 0 ? (n % 8 == 0 ? 90.0 : -90.0) : uniform(-90.0, 90.0);
    const Viewport viewport = turned(n % 5 == 0 ? 180.0 : uniform(-400.0, 400.0), pitch_deg,
                                     uniform(-180.0, 180.0), std::min(fov_deg, 170.0));
    const PanoramaPart part = part_shown(viewport, kPanorama);
    ASSERT_GE(part.first_column, 0);
    ASSERT_LT(part.first_column, kPanorama.width);
    ASSERT_LE(part.columns, kPanorama.width);
    for (int column = 0; column < viewport.width; ++column) {
      for (int row = 0; row < viewport.height; ++row) {
        const PixelPosition at =
            pixel_from_angles(angles_from_direction(ray_of(viewport, column, row)), kPanorama);
        const double v = std::clamp(at.v, 0.0, kPanorama.height - 1.0);
        ASSERT_GE(std::floor(v), part.rows.begin);
        ASSERT_LT(std::min(std::floor(v) + 1.0, kPanorama.height - 1.0), part.rows.end);
        if (part.columns == kPanorama.width) continue;
        const int first = static_cast<int>(std::floor(at.u)) - part.first_column;
        const int within = (first % kPanorama.width + kPanorama.width) % kPanorama.width;
        ASSERT_LT(within + 1, part.columns) << "fov " << fov_deg << " pitch " << pitch_deg;
      }
    }
  }
}

// What is not shown is not rendered.
TEST(Viewport, PartIsNotMuchLargerThanThePicture) {
  const PanoramaPart part = part_shown(turned(180.0, 0.0, 0.0, 60.0), kPanorama);
  EXPECT_NEAR(part.columns, kPanorama.width / 6.0, 10.0);
  EXPECT_NEAR(part.first_column, kPanorama.width * 11.0 / 12.0, 8.0);
  const double half_rad = std::atan(70.0 / 90.0 * std::tan(radians_from_degrees(30.0)));
  EXPECT_NEAR(part.rows.end - part.rows.begin, 2.0 * half_rad / kPi * kPanorama.height, 10.0);
}

}  // namespace
}  // namespace raywalk
