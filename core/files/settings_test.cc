#include "core/files/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;
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

std::string settings_error(const std::string& yaml) {
  return error_of([&] { parsed(yaml); });
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

TEST(Settings, UnsetKeysKeepTheirValues) {
  EXPECT_EQ(parsed("width: 512\n").k_deg, 76.0);
  EXPECT_EQ(parsed("").width, 4096);
  EXPECT_EQ(parsed("# only a comment\n").width, 4096);
}

TEST(Settings, BoundsAreInclusive) {
  EXPECT_EQ(parsed("k_deg: 45").k_deg, 45.0);
  EXPECT_EQ(parsed("k_deg: 90").k_deg, 90.0);
  EXPECT_EQ(settings_error("width: 512\nk_deg: 90.001"),
            "view.yaml:2: 'k_deg' is '90.001'; it must lie between 45 and 90");
  EXPECT_EQ(settings_error("width: 1"),
            "view.yaml:1: 'width' is '1'; it must lie between 2 and 65536");
}

TEST(Settings, UnknownKeysNameLineAndNearestKey) {
  EXPECT_EQ(settings_error("width: 512\n\nwidht: 512\n"),
            "view.yaml:3: unknown key 'widht'; did you mean 'width'?");
  EXPECT_EQ(settings_error("blend:\n  overlap_dge: 1\n"),
            "view.yaml:2: unknown key 'blend.overlap_dge'; did you mean 'blend.overlap_deg'?");
  EXPECT_THAT(settings_error("exposure: 1\n"),
              StartsWith("view.yaml:1: unknown key 'exposure'; valid are "));
}

TEST(Settings, KeyGivenTwiceIsAnError) {
  EXPECT_EQ(settings_error("width: 512\nk_deg: 50\nwidth: 256\n"),
            "view.yaml:3: key 'width' appears twice");
  EXPECT_EQ(settings_error("blend: {overlap_deg: 1}\nblend: {overlap_deg: 2}\n"),
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
    EXPECT_THAT(settings_error(bad), StartsWith("view.yaml:1: ")) << bad;
  }
  EXPECT_EQ(
      settings_error("connection: hybird"),
      "view.yaml:1: 'connection' is 'hybird'; it is not a valid choice; did you mean 'hybrid'?");
  EXPECT_EQ(settings_error("k_deg:"), "view.yaml:1: 'k_deg' has no value");
}

TEST(Settings, DocumentThatIsNotAMappingIsAnError) {
  for (const std::string bad :
       {"- k_deg", "just text", "k_deg: 50\n---\nwidth: 512\n", "? [a]\n: b", "k_deg: [", "a: b: c",
        "\t- x", "*nowhere", "{", "'open"}) {
    const std::string error = settings_error(bad);
    EXPECT_THAT(error, StartsWith("view.yaml:")) << bad;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  EXPECT_THAT(settings_error("width: 512\nk_deg: [\n"), HasSubstr("not valid YAML"));
}

TEST(Settings, AliasesThatMultiplyEndQuickly) {
  std::string bomb = "a0: &a0 {x: 1}\n";
  for (int i = 1; i < 60; ++i) {
    bomb += fmt::format("a{0}: &a{0} {{p: *a{1}, q: *a{1}}}\n", i, i - 1);
  }
  EXPECT_THAT(settings_error(bomb), StartsWith("view.yaml:1: unknown key 'a0'"));
  EXPECT_THAT(settings_error("blend: &b {blend: *b}"), HasSubstr("unknown key 'blend.blend'"));
}

TEST(Settings, TextAfterTheDocumentEnds) {
  const std::string stray = "{k_deg: 09, bdend: &overlap_deg\x1a 1s\x1a 1}, oth`r@ *$}";
  EXPECT_THAT(settings_error(stray), StartsWith("view.yaml:1: "));
  EXPECT_THAT(settings_error("{k_deg: 50}, x}"), StartsWith("view.yaml:1: "));
}

TEST(Settings, WholeNumbersMayBeHexadecimal) {
  EXPECT_EQ(parsed("width: 0x0200").width, 512);
  EXPECT_EQ(parsed("width: 0X2aF").width, 687);
  for (const std::string bad : {"width: 0x", "width: 0xg", "width: 0x-200", "width: -0x200",
                                "width: 0x10.0", "width: 0x200000000", "width: \"0x200\""}) {
    EXPECT_THAT(settings_error(bad), StartsWith("view.yaml:1: 'width' is '")) << bad;
  }
}

struct Mark {
  std::string axis = "x";
  std::vector<double> at_m{};
};

struct Drawing {
  std::vector<double> steps{0.5};
  std::vector<std::string> layers{};
  std::vector<Mark> marks{};
  std::filesystem::path background{};
};

SettingsSchema schema_of(Drawing& drawing) {
  SettingsSchema schema;
  schema.numbers("plot.steps", &drawing.steps, -1.0, 1.0, 3)
      .words("layers", &drawing.layers, 2)
      .path("background", &drawing.background)
      .items(
          "marks",
          [&drawing] {
            Mark& mark = drawing.marks.emplace_back();
            SettingsSchema item;
            item.choice("axis", &mark.axis, {"x", "z"}).numbers("at_m", &mark.at_m, 0.0, 9.0, 2);
            return item;
          },
          2);
  return schema;
}

Drawing drawing_from(const std::string& yaml) {
  Drawing drawing;
  schema_of(drawing).parse(yaml, "plan.yaml");
  return drawing;
}

std::string drawing_error(const std::string& yaml) {
  return error_of([&] { drawing_from(yaml); });
}

TEST(Settings, SequencesReplaceEarlierValues) {
  const Drawing drawing = drawing_from(
      "plot:\n  steps: [1, -0.25]\nlayers: [\"0x10\", grid]\nmarks:\n  - axis: z\n    at_m: [2]\n"
      "  - {}\n");
  EXPECT_THAT(drawing.steps, ElementsAre(1.0, -0.25));
  EXPECT_THAT(drawing.layers, ElementsAre("0x10", "grid"));
  ASSERT_EQ(drawing.marks.size(), 2u);
  EXPECT_EQ(drawing.marks[0].axis, "z");
  EXPECT_THAT(drawing.marks[0].at_m, ElementsAre(2.0));
  EXPECT_EQ(drawing.marks[1].axis, "x");
  EXPECT_EQ(drawing_from("background: \"a b/c.png\"").background, "a b/c.png");
  EXPECT_THAT(drawing_from("").steps, ElementsAre(0.5));
  EXPECT_THAT(drawing_from("plot: {steps: []}\nmarks: []").steps, IsEmpty());
}

TEST(Settings, MistakesInSequencesNameTheElement) {
  EXPECT_EQ(drawing_error("plot:\n  steps:\n    - 1\n    - 2\n"),
            "plan.yaml:4: 'plot.steps[1]' is '2'; it must lie between -1 and 1");
  EXPECT_EQ(drawing_error("plot: {steps: [0, 0, 0, 0]}"),
            "plan.yaml:1: 'plot.steps' has 4 items; it may have 3 at most");
  EXPECT_EQ(drawing_error("plot: {steps: 1}"),
            "plan.yaml:1: 'plot.steps' must be a list; write it as [first, second]");
  EXPECT_EQ(drawing_error("plot: {steps: [1, [1]]}"),
            "plan.yaml:1: 'plot.steps[1]' must be a single value");
  EXPECT_EQ(drawing_error("plot: {steps: [~]}"), "plan.yaml:1: 'plot.steps[0]' has no value");
  EXPECT_EQ(drawing_error("plot: {steps: ['1']}"),
            "plan.yaml:1: 'plot.steps[0]' is '1' in quotes; write it without them");
  EXPECT_EQ(drawing_error("layers: [a, b, c]"),
            "plan.yaml:1: 'layers' has 3 items; it may have 2 at most");
}

TEST(Settings, MistakesInItemsNameItemLineAndKey) {
  EXPECT_EQ(drawing_error("marks:\n- axis: x\n- axis: y\n"),
            "plan.yaml:3: 'marks[1].axis' is 'y'; it is not a valid choice; valid are x, z");
  EXPECT_EQ(drawing_error("marks:\n- axs: x\n"),
            "plan.yaml:2: unknown key 'marks[0].axs'; did you mean 'marks[0].axis'?");
  EXPECT_EQ(drawing_error("marks:\n- axis: x\n  axis: z\n"),
            "plan.yaml:3: key 'marks[0].axis' appears twice");
  EXPECT_EQ(drawing_error("marks:\n- at_m: [1, 10]\n"),
            "plan.yaml:2: 'marks[0].at_m[1]' is '10'; it must lie between 0 and 9");
  EXPECT_EQ(drawing_error("marks: [x]"),
            "plan.yaml:1: 'marks[0]' must be lines of 'key: value' after '- '");
  EXPECT_EQ(drawing_error("marks: {axis: x}"),
            "plan.yaml:1: 'marks' must be a list; start every item under it with '- '");
  EXPECT_EQ(drawing_error("marks:"),
            "plan.yaml:1: 'marks' must be a list; start every item under it with '- '");
  EXPECT_EQ(drawing_error("marks: [{}, {}, {}]"),
            "plan.yaml:1: 'marks' has 3 items; it may have 2 at most");
}

TEST(Settings, LinesAreThoseOfTheValues) {
  Drawing drawing;
  const SettingsLines lines = schema_of(drawing).parse(
      "# a plan\nplot:\n  steps: [1,\n    0]\nmarks:\n  - axis: x\n  - at_m: [1]\n    axis:\n      "
      "z\n",
      "plan.yaml");
  EXPECT_THAT(lines,
              ElementsAre(Pair("marks", 6), Pair("marks[0].axis", 6), Pair("marks[1].at_m", 7),
                          Pair("marks[1].axis", 9), Pair("plot.steps", 3)));
}

TEST(Settings, LoadNamesTheFile) {
  const TestDirectory directory;
  write_file_atomically(directory / "view.yaml", "k_deg: 50\n");
  ViewSettings view;
  schema_of(view).load(directory / "view.yaml");
  EXPECT_EQ(view.k_deg, 50.0);
  EXPECT_THROW(schema_of(view).load(directory / "missing.yaml"), UsageError);
}

}  // namespace
}  // namespace raywalk
