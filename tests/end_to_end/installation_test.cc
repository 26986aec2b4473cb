// What `cmake --install` puts into a prefix: programs that find their files, completion of shells
// and manual pages, and libraries that another project finds and links.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "core/files/test_support.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;
namespace fs = std::filesystem;

constexpr const char* kPrograms[] = {"raywalk-capture", "raywalk-calibrate", "raywalk-build-lf",
                                     "raywalk-render"};

class InstallationTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory_ = std::make_unique<TestDirectory>();
    for (const char* component : {"runtime", "simulator", "development"}) {
      ASSERT_EQ(
          run(fmt::format("cmake --install " RAYWALK_BUILD_FOLDER " --prefix {} --component {}",
                          prefix(), component))
              .exit_code,
          0);
    }
  }
  static void TearDownTestSuite() { directory_.reset(); }

  static std::string prefix() { return (directory_->path() / "usr").string(); }

  // In a folder of its own, away from the sources.
  static CommandResult run(const std::string& command) {
    const CommandResult result =
        run_command(fmt::format("cd {} && {}", directory_->path().string(), command));
    if (result.exit_code != 0) std::cerr << result.output << result.errors;
    return result;
  }

  static std::unique_ptr<TestDirectory> directory_;
};

std::unique_ptr<TestDirectory> InstallationTest::directory_;

TEST_F(InstallationTest, ConfigurationsAreFoundByName) {
  const CommandResult plan = run(prefix() + "/bin/raywalk-capture plan capture-osc");
  EXPECT_EQ(plan.exit_code, 0);
  EXPECT_THAT(plan.output, HasSubstr("4 lines, 260 stations"));
  const CommandResult lens =
      run("! " + prefix() + "/bin/raywalk-calibrate lens hall --lens-start theta-lik");
  EXPECT_THAT(lens.errors, AllOf(HasSubstr(prefix() + "/share/raywalk/configs/lenses"),
                                 HasSubstr("did you mean 'theta-like'?")));
}

TEST_F(InstallationTest, ShellsCompleteWhatThePageExplains) {
  // `words` are those typed so far, the last one not yet.
  const auto completed = [](const std::string& program, const std::string& words) {
    std::istringstream lines(
        run(fmt::format(
                "touch \"a b.png\" && bash -c '. {0}/share/bash-completion/completions/{1}; "
                "set -u; COMP_WORDS=({1} {2}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); "
                "_raywalk {0}/bin/{1}; printf \"%s\\n\" \"${{COMPREPLY[@]}}\"'",
                prefix(), program, words))
            .output);
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty()) found.push_back(line);
    }
    return found;
  };
  EXPECT_THAT(completed("raywalk-render", "\"\""),
              AllOf(IsSupersetOf({"view", "path", "serve"}), Not(Contains("raywalk-render"))));
  EXPECT_THAT(completed("raywalk-render", "--v"), ElementsAre("--version"));
  EXPECT_THAT(completed("raywalk-render", "view --method \"\""),
              ElementsAre("initial", "hlf-vd", "two-sided"));
  EXPECT_THAT(completed("raywalk-render", "view --method = in"), ElementsAre("initial"));
  EXPECT_THAT(completed("raywalk-render", "view --threads \"\""), IsEmpty());
  EXPECT_THAT(completed("raywalk-render", "view -o a"), ElementsAre("a b.png"));
  EXPECT_THAT(completed("raywalk-render", "view --threads 2 a"), ElementsAre("a b.png"));
  EXPECT_THAT(completed("raywalk-calibrate", "all --lens-start \"\""), Contains("theta-like"));
  EXPECT_THAT(completed("raywalk-build-lf", "pack --"), IsSupersetOf({"--frames", "--force"}));
  for (const std::string program : kPrograms) {
    const std::string share = prefix() + "/share/";
    for (const std::string& check :
         {"man --warnings -E UTF-8 -l " + share + "man/man1/" + program + "*.1.gz > page",
          "bash -n " + share + "bash-completion/completions/" + program}) {
      const std::string tool = check.substr(0, check.find(' '));
      if (run_command("command -v " + tool).exit_code != 0) {
        std::cerr << "skipped, as " << tool << " is not installed: " << check << "\n";
        continue;
      }
      EXPECT_EQ(run(check).errors, "") << check;
    }
  }
}

TEST_F(InstallationTest, CommandsHaveManualPages) {
  const std::string pages = prefix() + "/share/man/man1/";
  EXPECT_TRUE(fs::exists(pages + "raywalk-capture.1.gz"));
  const CommandResult page = run("zcat " + pages + "raywalk-render-view.1.gz");
  EXPECT_THAT(page.output, AllOf(HasSubstr("raywalk-render-view \\- Render one view"),
                                 HasSubstr("\\fB\\-\\-yaw\\-deg\\fR FLOAT\nTurn to the right"),
                                 HasSubstr("EXIT STATUS"), HasSubstr("EXAMPLES")));
}

TEST_F(InstallationTest, AnotherProjectFindsTheLibraries) {
  EXPECT_EQ(run("cmake -S " RAYWALK_EXAMPLES "/render-a-view -B example -DCMAKE_PREFIX_PATH=" +
                prefix() + " && cmake --build example")
                .exit_code,
            0);
  EXPECT_EQ(run(prefix() + "/bin/raywalk-build-lf pack --frames " RAYWALK_TEST_ROOM
                           "/poses.csv --distance " RAYWALK_TEST_ROOM "/dist --out room.lf")
                .exit_code,
            0);
  const CommandResult view = run("example/render-a-view room.lf -0.1 0.25 view.png");
  EXPECT_EQ(view.exit_code, 0);
  EXPECT_THAT(view.output, HasSubstr("view.png: 512 x 256 pixels"));
  EXPECT_GT(fs::file_size(*directory_ / "view.png"), 50000U);
}

}  // namespace
}  // namespace raywalk
