#include "core/view/view_parameter.h"

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

}  // namespace
}  // namespace raywalk
