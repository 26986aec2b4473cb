#include "calibrate/poses/colmap_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "calibrate/base/capture_set.h"
#include "calibrate/poses/colmap_workspace.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pair;

// The options that are used: under the same names in all versions, and in COLMAP 3.12 and 4.1.
constexpr const char* kCommonOptions =
    "database_path image_path input_path output_path match_list_path match_type clear_points "
    "ImageReader.mask_path ImageReader.camera_model ImageReader.single_camera_per_folder "
    "ImageReader.camera_params SiftExtraction.max_num_features "
    "SiftExtraction.max_num_orientations SiftExtraction.first_octave TwoViewGeometry.max_error "
    "Mapper.extract_colors Mapper.num_threads Mapper.tri_create_max_angle_error "
    "Mapper.tri_continue_max_angle_error Mapper.tri_re_max_angle_error "
    "Mapper.tri_merge_max_reproj_error Mapper.tri_complete_max_reproj_error "
    "Mapper.filter_max_reproj_error Mapper.ba_global_max_refinements ";
constexpr const char* kOptionsOf312 =
    "SiftExtraction.num_threads SiftExtraction.use_gpu SiftMatching.num_threads "
    "SiftMatching.use_gpu";
constexpr const char* kOptionsOf41 =
    "FeatureExtraction.num_threads FeatureExtraction.use_gpu FeatureMatching.num_threads "
    "FeatureMatching.use_gpu";

// The help of a command that has these options, as COLMAP prints it.
std::string help_with(const std::string& options) {
  std::string help =
      "Options can either be specified via command-line or by ...\n  -h [ --help ]\n";
  std::istringstream names(options);
  for (std::string name; names >> name;) help += "  --" + name + " arg (=1)\n";
  return help;
}

// Sets PATH to a directory with a `colmap` during the object's lifetime.
class FakeColmap {
 public:
  FakeColmap() : path_before_(std::getenv("PATH")) {
    setenv("PATH", ((directory_ / "bin").string() + ":" + path_before_).c_str(), 1);
    std::filesystem::create_directory(directory_ / "bin");
  }
  ~FakeColmap() { setenv("PATH", path_before_.c_str(), 1); }
  FakeColmap(const FakeColmap&) = delete;
  FakeColmap& operator=(const FakeColmap&) = delete;

  // A shell script that answers `help` and the -h of a command, and does `commands` for everything
  // else.
  void install(const std::string& version, const std::string& commands,
               const std::string& help = "") {
    const std::filesystem::path file = directory_ / "bin/colmap";
    write_file_atomically(directory_ / "help.txt", help);
    std::ofstream(file) << "#!/bin/sh\nif [ \"$1\" = help ]; then echo 'COLMAP " << version
                        << " -- Structure-from-Motion'; exit 0; fi\n"
                        << "if [ \"$2\" = -h ]; then cat " << directory_ / "help.txt"
                        << " >&2; exit 0; fi\n"
                        << commands << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  // Empties PATH.
  void remove_all() { setenv("PATH", (directory_ / "bin").c_str(), 1); }

  std::filesystem::path log() const { return directory_ / "log.txt"; }
  std::string log_text() const { return read_file(log()); }

 private:
  TestDirectory directory_;
  std::string path_before_;
};

TEST(ColmapProgram, IsFoundInPathWithItsVersion) {
  FakeColmap fake;
  for (const std::string version : {"3.8", "3.9.1", "3.12.6", "4.1.1"}) {
    fake.install(version, "");
    EXPECT_EQ(ColmapProgram::find().version(), version);
  }
  fake.install("3.14.0.dev0", "");
  EXPECT_EQ(ColmapProgram::find().version(), "3.14.0");
}

// All that the steps need, under each version's names.
TEST(ColmapProgram, UnderstandsOptionsOfEveryVersion) {
  FakeColmap fake;
  const auto options_of = [](const ColmapProgram& colmap, const std::string& command) {
    return colmap
        .translated({command,
                     {{"--FeatureExtraction.use_gpu", "0"},
                      {"--FeatureMatching.num_threads", "3"},
                      {"--TwoViewGeometry.max_error", "2"}}})
        .options;
  };
  fake.install("3.12.6", "", help_with(std::string(kCommonOptions) + kOptionsOf312));
  const ColmapProgram older = ColmapProgram::find();
  EXPECT_THAT(
      options_of(older, "matches_importer"),
      ElementsAre(Pair("--SiftExtraction.use_gpu", "0"), Pair("--SiftMatching.num_threads", "3"),
                  Pair("--TwoViewGeometry.max_error", "2")));
  const CaptureSet set;
  const TestDirectory directory;
  const WorkspaceOptions options{.directory = directory / "colmap", .mask = cv::Mat()};
  ColmapWorkspace(set, {}, older, options);
  fake.install("4.1.1", "", help_with(std::string(kCommonOptions) + kOptionsOf41));
  const ColmapProgram newer = ColmapProgram::find();
  EXPECT_EQ(options_of(newer, "matches_importer"), options_of(newer, "mapper"));  // unchanged
  ColmapWorkspace(set, {}, newer, options);
  // A later one without them.
  fake.install("5.0", "", help_with(kCommonOptions));
  EXPECT_THAT(error_of([&] { ColmapWorkspace(set, {}, ColmapProgram::find(), options); }),
              AllOf(HasSubstr("is COLMAP 5.0, whose feature_extractor has no option "
                              "--FeatureExtraction.use_gpu; install COLMAP 3.8 or newer"),
                    HasSubstr("rectify --poses")));
}

TEST(ColmapProgram, IsReportedMissingWithAdvice) {
  FakeColmap fake;
  fake.remove_all();
  EXPECT_THAT(error_of([] { ColmapProgram::find(); }),
              AllOf(HasSubstr("no COLMAP found in PATH"), HasSubstr("apt install colmap"),
                    HasSubstr("rectify --poses")));
}

TEST(ColmapProgram, OfAnOldVersionIsRefusedByName) {
  FakeColmap fake;
  for (const std::string version : {"2.9", "3.1", "3.7"}) {
    fake.install(version, "");
    EXPECT_THAT(error_of([] { ColmapProgram::find(); }),
                AllOf(HasSubstr("is COLMAP " + version + ", which is too old"),
                      HasSubstr("3.8 or newer"), HasSubstr("rectify --poses")));
  }
  fake.install("3.8", "");
  std::ofstream(std::filesystem::path(ColmapProgram::find().executable()))
      << "#!/bin/sh\necho I am something else\n";
  EXPECT_THAT(error_of([] { ColmapProgram::find(); }), HasSubstr("something else"));
}

TEST(ColmapProgram, GetsItsArgumentsUnchangedAndNoDisplay) {
  FakeColmap fake;
  fake.install("3.8", "for a in \"$@\"; do echo \"[$a]\"; done; echo $QT_QPA_PLATFORM");
  std::vector<std::string> lines;
  ColmapProgram::find().run({"mapper", {{"--path", "a b; rm $HOME \"'"}}}, fake.log(),
                            [&](std::string_view line) { lines.emplace_back(line); });
  EXPECT_THAT(lines, ElementsAre("[mapper]", "[--path]", "[a b; rm $HOME \"']", "offscreen"));
  EXPECT_THAT(fake.log_text(), HasSubstr("$ colmap mapper --path"));
}

TEST(ColmapProgram, FailsWithTheErrorLineItsMeaningAndTheLog) {
  FakeColmap fake;
  const auto failure_of = [&](const std::string& commands) {
    fake.install("3.8", commands);
    return error_of([&] { ColmapProgram::find().run({"mapper", {}}, fake.log()); });
  };
  EXPECT_THAT(failure_of("echo 'Loading'; echo 'E1122 10:00:00 model.cc:9] Check failed: x' >&2; "
                         "echo '*** Aborted at 1'; echo '    @     0x7f raise'; exit 3"),
              AllOf(HasSubstr("colmap mapper failed with exit code 3"),
                    HasSubstr("Check failed: x): it cannot work with these pictures; check"),
                    EndsWith("see " + fake.log().string())));
  EXPECT_THAT(fake.log_text(), HasSubstr("Aborted"));
  EXPECT_THAT(failure_of("kill -9 $$"),
              AllOf(HasSubstr("was killed by signal 9"), HasSubstr("memory was not enough"),
                    Not(HasSubstr("Check failed"))));  // of the run before
  EXPECT_THAT(failure_of("echo 'ERROR: database or disk is full'; exit 1"),
              HasSubstr("(ERROR: database or disk is full): the disk is full; free some"));
}

TEST(ColmapProgram, ReportsALogThatCannotBeWritten) {
  FakeColmap fake;
  fake.install("3.8", "");
  EXPECT_THAT(error_of([&] {
                ColmapProgram::find().run({"mapper", {}}, fake.log() / "not/there.txt");
              }),
              HasSubstr("cannot be written"));
}

// In a process of its own, as the interrupt request cannot be cleared.
TEST(ColmapProgramDeathTest, IsEndedByCtrlC) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  FakeColmap fake;
  fake.install("3.8", "echo started; sleep 300");
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        try {
          ColmapProgram::find().run({"mapper", {}}, fake.log(),
                                    [](std::string_view) { raise(SIGINT); });
        } catch (const Interrupted&) {
          std::exit(42);
        }
      },
      testing::ExitedWithCode(42), "");
}

TEST(ErrorLine, PrefersErrorsToTheLastLine) {
  EXPECT_EQ(error_line("a\nERROR: no images\nb\n"), "ERROR: no images");
  EXPECT_EQ(error_line("I20261123 a.cc:1] b\nE20261123 10:00:00 a.cc:2] no images\nb\n"),
            "E20261123 10:00:00 a.cc:2] no images");
  EXPECT_EQ(error_line("first\nlast words\n*** Aborted\n    @  0x1 x\n\n"), "last words");
  EXPECT_EQ(error_line(""), "");
}

}  // namespace
}  // namespace raywalk::calibrate
