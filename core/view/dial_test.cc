#include "core/view/dial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/view/view_options.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// The first and the last value, which every dial takes.
std::vector<double> values_of(const Dial& dial) {
  if (dial.value.kind == DialKind::kChoice) {
    return {0.0, static_cast<double>(dial.names.size()) - 1.0};
  }
  return {dial.least, dial.most};
}

ViewOptions options_with(const Dial& dial, double value) {
  ViewOptions options{.width = 64};
  dial.value.set(&options, value);
  return options;
}

TEST(DialTest, EveryDialHasItsOwnNamesAndIsExplained) {
  std::set<std::string> keys, flags, texts;
  for (const Dial& dial : kDials) {
    EXPECT_TRUE(keys.insert(dial.key).second) << dial.key;
    EXPECT_NE(dial.value.get, nullptr) << dial.key;
    EXPECT_LT(values_of(dial)[0], values_of(dial)[1]) << dial.key;
    EXPECT_TRUE(flags.insert(dial.flag).second) << dial.key;
    EXPECT_STRNE(dial.help, "") << dial.key;
    EXPECT_STRNE(dial.cost, "") << dial.key;
    // Different options have different texts.
    for (const double value : values_of(dial)) {
      const ViewOptions options = options_with(dial, value);
      if (options == ViewOptions{.width = 64}) continue;
      EXPECT_TRUE(texts.insert(text_of(options)).second) << dial.key << ' ' << value;
    }
  }
}

TEST(DialTest, EveryValueIsReadBackFromOptionsAndText) {
  for (const Dial& dial : kDials) {
    for (const double value : values_of(dial)) {
      const ViewOptions options = options_with(dial, value);
      EXPECT_EQ(dial.value.get(options), value) << dial.key;
      EXPECT_EQ(value_of(dial, text_of(dial, value)), value) << dial.key;
      EXPECT_NO_THROW(require_view_options(options)) << dial.key << ' ' << value;
    }
    EXPECT_FALSE(fault_of(dial, default_of(dial))) << dial.key;
    if (!dial.sweep || dial.sweep->of_truth_width) continue;
    for (const double value : dial.sweep->values) {
      EXPECT_FALSE(fault_of(dial, value)) << dial.key;
    }
  }
}

TEST(DialTest, ValuesBesideTheRangeAreRefused) {
  for (const Dial& dial : kDials) {
    if (dial.value.kind == DialKind::kChoice) {
      EXPECT_THAT([&] { value_of(dial, "best"); },
                  ThrowsMessage<std::invalid_argument>(HasSubstr("not a valid choice")));
      continue;
    }
    for (const double value : {dial.least - 2.0, dial.most + dial.multiple_of}) {
      EXPECT_TRUE(fault_of(dial, value)) << dial.key << ' ' << value;
      EXPECT_THROW(value_of(dial, std::to_string(static_cast<int>(value))), std::invalid_argument)
          << dial.key;
      EXPECT_THAT(error_of([&] { require_view_options(options_with(dial, value)); }),
                  HasSubstr(dial.key));
    }
    for (const char* text : {"", "nan", "1e999", "best", "4x"}) {
      EXPECT_THROW(value_of(dial, text), std::invalid_argument) << dial.key << ' ' << text;
    }
    EXPECT_TRUE(fault_of(dial, std::nan(""))) << dial.key;
  }
}

TEST(DialTest, FaultsNameTheValuesAndTheirUnit) {
  EXPECT_EQ(fault_of(dial_of("k_deg"), 30.0), "must be in 45..90 degrees");
  EXPECT_EQ(fault_of(dial_of("width_px"), 30.0), "must be 0 or a multiple of 4 in 4..32768 pixels");
  EXPECT_EQ(fault_of(dial_of("stations_mixed"), 17.0), "must be a whole number in 1..16");
  EXPECT_THAT([] { value_of(dial_of("interpolation"), "cubik"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("did you mean 'cubic'")));
  EXPECT_THROW(dial_of("layers"), std::out_of_range);
}

TEST(DialTest, TheProgramChoosesWhatIsNotGiven) {
  const ViewOptions options = default_options();
  EXPECT_EQ(options.width, 0);
  EXPECT_EQ(value_of(dial_of("width_px"), "0"), 0.0);
  // A renderer needs the chosen values.
  EXPECT_THAT(error_of([&] { require_view_options(options); }), HasSubstr("width_px is 0"));
  EXPECT_THAT(error_of([] { require_view_options({}); }), HasSubstr("width_px is 0"));
  EXPECT_NO_THROW(require_view_options({.width = 64}));
}

TEST(Generation, NamesAreReadBack) {
  for (const char* name : kGenerationNames) {
    EXPECT_EQ(generation_name(generation_from_name(name)), name);
  }
  EXPECT_THAT([] { generation_from_name("best"); },
              ThrowsMessage<UsageError>(AllOf(HasSubstr("'best'"), HasSubstr("two-sided"))));
}

}  // namespace
}  // namespace raywalk
