#include "core/files/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <string>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct ViewSettings {
  double k_deg = 76.0;
  int width = 4096;
  bool two_sided = false;
  std::string title = "untitled";
  std::string connection = "hybrid";
  double overlap_deg = 5.0;
};

SettingsSchema schema_of(ViewSettings& view) {
  SettingsSchema schema;
  schema.number("k_deg", &view.k_deg, 45.0, 90.0)
      .integer("width", &view.width, 2, 65536)
      .boolean("two_sided", &view.two_sided)
      .text("title", &view.title)
      .choice("connection", &view.connection, {"hybrid", "lfu", "rayspace360"})
      .number("blend.overlap_deg", &view.overlap_deg, 0.0, 30.0);
  return schema;
}

ViewSettings parsed(const std::string& yaml) {
  ViewSettings view;
  schema_of(view).parse(yaml, "view.yaml");
  return view;
}

std::string error_of(const std::string& yaml) {
  try {
    parsed(yaml);
  } catch (const UsageError& e) {
    return e.what();
  }
  return "";
}

TEST(Settings, SetsEveryTypeAndNestedKeys) {
  const ViewSettings view = parsed(
      "# a view\nk_deg: 80.5\nwidth: 2048\ntwo_sided: true\ntitle: \"12\"\nconnection: lfu\n"
      "blend:\n  overlap_deg: 2\n");
  EXPECT_EQ(view.k_deg, 80.5);
  EXPECT_EQ(view.width, 2048);
  EXPECT_TRUE(view.two_sided);
  EXPECT_EQ(view.title, "12");
  EXPECT_EQ(view.connection, "lfu");
  EXPECT_EQ(view.overlap_deg, 2.0);
}

TEST(Settings, WhatTheFileDoesNotSetKeepsItsValue) {
  const ViewSettings view = parsed("width: 512\n");
  EXPECT_EQ(view.k_deg, 76.0);
  EXPECT_EQ(view.connection, "hybrid");
  EXPECT_EQ(parsed("").width, 4096);
  EXPECT_EQ(parsed("# only a comment\n").width, 4096);
}

TEST(Settings, BoundsAreInclusive) {
  EXPECT_EQ(parsed("k_deg: 45").k_deg, 45.0);
  EXPECT_EQ(parsed("k_deg: 90").k_deg, 90.0);
  EXPECT_EQ(error_of("width: 512\nk_deg: 90.001"),
            "view.yaml:2: 'k_deg' is '90.001'; it must lie between 45 and 90");
  EXPECT_EQ(error_of("width: 1"), "view.yaml:1: 'width' is '1'; it must lie between 2 and 65536");
}

TEST(Settings, UnknownKeysNameLineAndNearestKey) {
  EXPECT_EQ(error_of("width: 512\n\nwidht: 512\n"),
            "view.yaml:3: unknown key 'widht'; did you mean 'width'?");
  EXPECT_EQ(error_of("blend:\n  overlap_dge: 1\n"),
            "view.yaml:2: unknown key 'blend.overlap_dge'; did you mean 'blend.overlap_deg'?");
  EXPECT_THAT(error_of("exposure: 1\n"),
              StartsWith("view.yaml:1: unknown key 'exposure'; valid are "));
}

TEST(Settings, KeyGivenTwiceIsAnError) {
  EXPECT_EQ(error_of("width: 512\nk_deg: 50\nwidth: 256\n"),
            "view.yaml:3: key 'width' appears twice");
  EXPECT_EQ(error_of("blend: {overlap_deg: 1}\nblend: {overlap_deg: 2}\n"),
            "view.yaml:2: key 'blend.overlap_deg' appears twice");
}

TEST(Settings, WrongTypesAreErrors) {
  for (const std::string bad : {"k_deg: high",    "k_deg: .nan",   "k_deg: .inf",
                                "k_deg: 1e999",   "k_deg: \"50\"", "k_deg: '50'",
                                "k_deg: [50]",    "k_deg: {a: 1}", "k_deg:",
                                "k_deg: ~",       "width: 512.0",  "width: 99999999999",
                                "two_sided: yes", "two_sided: 1",  "two_sided: \"true\"",
                                "title: [a]",     "title:",        "connection: hybird",
                                "blend: 5",       "blend:",        "blend: [overlap_deg]"}) {
    EXPECT_THAT(error_of(bad), StartsWith("view.yaml:1: ")) << bad;
  }
  EXPECT_EQ(error_of("connection: hybird"),
            "view.yaml:1: 'connection' is 'hybird'; it is not a choice; did you mean 'hybrid'?");
  EXPECT_EQ(error_of("k_deg:"), "view.yaml:1: 'k_deg' has no value");
}

TEST(Settings, WhatIsNotOneMappingIsAnError) {
  for (const std::string bad :
       {"- k_deg", "just text", "k_deg: 50\n---\nwidth: 512\n", "? [a]\n: b", "k_deg: [", "a: b: c",
        "\t- x", "*nowhere", "{", "'open"}) {
    const std::string error = error_of(bad);
    EXPECT_THAT(error, StartsWith("view.yaml:")) << bad;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  EXPECT_THAT(error_of("width: 512\nk_deg: [\n"), HasSubstr("not valid YAML"));
}

TEST(Settings, AliasesThatMultiplyEndQuickly) {
  std::string bomb = "a0: &a0 {x: 1}\n";
  for (int i = 1; i < 60; ++i) {
    bomb += fmt::format("a{0}: &a{0} {{p: *a{1}, q: *a{1}}}\n", i, i - 1);
  }
  EXPECT_THAT(error_of(bomb), StartsWith("view.yaml:1: unknown key 'a0'"));
  EXPECT_THAT(error_of("blend: &b {blend: *b}"), HasSubstr("unknown key 'blend.blend'"));
}

TEST(Settings, TextAfterTheDocumentEnds) {
  const std::string stray = "{k_deg: 09, bdend: &overlap_deg\x1a 1s\x1a 1}, oth`r@ *$}";
  EXPECT_THAT(error_of(stray), StartsWith("view.yaml:1: "));
  EXPECT_THAT(error_of("{k_deg: 50}, x}"), StartsWith("view.yaml:1: "));
}

TEST(Settings, LoadNamesTheFile) {
  const TestDirectory directory;
  write_file_atomically(directory / "view.yaml", "k_deg: 50\n");
  ViewSettings view;
  const SettingsSchema schema = schema_of(view);
  schema.load(directory / "view.yaml");
  EXPECT_EQ(view.k_deg, 50.0);
  EXPECT_THROW(schema.load(directory / "missing.yaml"), UsageError);
  EXPECT_THROW(schema.load(directory.path()), UsageError);
}

}  // namespace
}  // namespace raywalk
