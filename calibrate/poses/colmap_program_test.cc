#include "calibrate/poses/colmap_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <thread>

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

// Of the options that are used, as the help of COLMAP 3.12 and 4.1 lists them.
constexpr const char* kCommonHelp = R"(Options can either be specified via command-line or by ...
  -h [ --help ]
  --database_path arg
  --image_path arg
  --input_path arg
  --output_path arg
  --match_list_path arg
  --match_type arg (=pairs)             {'pairs', 'raw', 'inliers'}
  --clear_points arg (=1)
  --ImageReader.mask_path arg
  --ImageReader.camera_model arg (=SIMPLE_RADIAL)
  --ImageReader.single_camera_per_folder arg (=0)
  --ImageReader.camera_params arg
  --SiftExtraction.max_num_features arg (=8192)
  --SiftExtraction.max_num_orientations arg (=2)
  --SiftExtraction.first_octave arg (=-1)
  --TwoViewGeometry.max_error arg (=4)
  --Mapper.extract_colors arg (=1)
  --Mapper.num_threads arg (=-1)
  --Mapper.tri_create_max_angle_error arg (=2)
  --Mapper.tri_continue_max_angle_error arg (=2)
  --Mapper.tri_re_max_angle_error arg (=5)
  --Mapper.tri_merge_max_reproj_error arg (=4)
  --Mapper.tri_complete_max_reproj_error arg (=4)
  --Mapper.filter_max_reproj_error arg (=4)
  --Mapper.ba_global_max_refinements arg (=5)
)";
constexpr const char* kHelpOf312 = R"(  --SiftExtraction.num_threads arg (=-1)
  --SiftExtraction.use_gpu arg (=1)
  --SiftMatching.num_threads arg (=-1)
  --SiftMatching.use_gpu arg (=1)
)";
constexpr const char* kHelpOf41 = R"(  --FeatureExtraction.type arg (=SIFT)
  --FeatureExtraction.num_threads arg (=-1)
  --FeatureExtraction.use_gpu arg (=1)
  --FeatureMatching.type arg (=SIFT_BRUTEFORCE)
  --FeatureMatching.num_threads arg (=-1)
  --FeatureMatching.use_gpu arg (=1)
)";

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
  fake.install("3.12.6", "", std::string(kCommonHelp) + kHelpOf312);
  const ColmapProgram older = ColmapProgram::find();
  EXPECT_THAT(
      options_of(older, "matches_importer"),
      ElementsAre(Pair("--SiftExtraction.use_gpu", "0"), Pair("--SiftMatching.num_threads", "3"),
                  Pair("--TwoViewGeometry.max_error", "2")));
  const CaptureSet set;
  const TestDirectory directory;
  const WorkspaceOptions options{.directory = directory / "colmap", .mask = cv::Mat()};
  ColmapWorkspace(set, {}, older, options);
  fake.install("4.1.1", "", std::string(kCommonHelp) + kHelpOf41);
  const ColmapProgram newer = ColmapProgram::find();
  EXPECT_EQ(options_of(newer, "matches_importer"), options_of(newer, "mapper"));  // unchanged
  ColmapWorkspace(set, {}, newer, options);
  // A later one without them.
  fake.install("5.0", "", kCommonHelp);
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

TEST(ColmapProgram, FailsWithTheErrorLineAndTheLog) {
  FakeColmap fake;
  fake.install("3.8",
               "echo 'Loading'; echo 'E1122 10:00:00 model.cc:9] Check failed: x == y' >&2; "
               "echo '*** Aborted at 1'; echo '    @     0x7f raise'; exit 3");
  const ColmapProgram colmap = ColmapProgram::find();
  EXPECT_THAT(error_of([&] {
                colmap.run({"mapper", {}}, fake.log());
              }),
              AllOf(HasSubstr("colmap mapper failed with exit code 3"),
                    HasSubstr("Check failed: x == y"), EndsWith(fake.log().string())));
  EXPECT_THAT(fake.log_text(), HasSubstr("Aborted"));
}

TEST(ColmapProgram, ReportsThatItWasKilled) {
  FakeColmap fake;
  fake.install("3.8", "kill -9 $$");
  const ColmapProgram colmap = ColmapProgram::find();
  EXPECT_THAT(error_of([&] {
                colmap.run({"mapper", {}}, fake.log());
              }),
              AllOf(HasSubstr("was killed by signal 9"), HasSubstr("memory was not enough")));
}

TEST(ColmapProgram, SaysWhatAFailureMeans) {
  FakeColmap fake;
  fake.install("3.8", "echo 'ERROR: database or disk is full'; exit 1");
  EXPECT_THAT(error_of([&] {
                ColmapProgram::find().run({"mapper", {}}, fake.log());
              }),
              AllOf(HasSubstr("(ERROR: database or disk is full): the disk is full; free some"),
                    EndsWith("see " + fake.log().string())));
  fake.install("3.8", "echo 'Check failed: x'; exit 1");
  EXPECT_THAT(error_of([&] {
                ColmapProgram::find().run({"mapper", {}}, fake.log());
              }),
              HasSubstr("(Check failed: x): it cannot work with these pictures; check"));
}

TEST(ColmapProgram, QuotesOnlyItsOwnRun) {
  FakeColmap fake;
  fake.install("3.8", "if [ $1 = one ]; then echo ERROR: of the first; fi; exit $3");
  const ColmapProgram colmap = ColmapProgram::find();
  colmap.run({"one", {{"--exit", "0"}}}, fake.log());
  EXPECT_THAT(error_of([&] {
                colmap.run({"two", {{"--exit", "1"}}}, fake.log());
              }),
              Not(HasSubstr("of the first")));
}

TEST(ColmapProgram, ReportsALogThatCannotBeWritten) {
  FakeColmap fake;
  fake.install("3.8", "");
  const ColmapProgram colmap = ColmapProgram::find();
  EXPECT_THAT(error_of([&] {
                colmap.run({"mapper", {}}, fake.log() / "not/there.txt");
              }),
              HasSubstr("cannot be written"));
}

// In a child process, as the interrupt request cannot be cleared.
TEST(ColmapProgram, IsEndedByCtrlCWithItsChildren) {
  FakeColmap fake;
  fake.install("3.8", "sleep 300 & echo $!; sleep 300");
  const pid_t child = fork();
  if (child == 0) {
    install_interrupt_handlers();
    int code = 1;
    try {
      ColmapProgram::find().run({"mapper", {}}, fake.log(),
                                [](std::string_view) { raise(SIGINT); });
    } catch (const Interrupted&) {
      code = 42;
    } catch (...) {
      code = 2;
    }
    _exit(code);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 42);
  // Its second line is the process id of its child.
  std::istringstream log(fake.log_text());
  pid_t grandchild = 0;
  for (std::string line; std::getline(log, line);) {
    if (!line.empty() && line.find_first_not_of("0123456789") == std::string::npos) {
      grandchild = std::stoi(line);
    }
  }
  ASSERT_GT(grandchild, 0);
  // It is reparented to init, which may take a moment to reap it.
  for (int i = 0; i < 100 && kill(grandchild, 0) == 0; ++i) {
    std::ifstream stat("/proc/" + std::to_string(grandchild) + "/stat");
    std::string word;
    stat >> word >> word >> word;
    if (word == "Z") break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    ASSERT_LT(i, 99) << "still running";
  }
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
