#include "calibrate/poses/colmap_program.h"

#include <gmock/gmock.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "calibrate/base/capture_set.h"
#include "calibrate/poses/colmap_database.h"
#include "calibrate/poses/colmap_workspace.h"
#include "calibrate/poses/matching_faces.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/sqlite_connection.h"
#include "core/files/test_support.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::Pair;

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
                    testing::EndsWith("see " + fake.log().string())));
  EXPECT_THAT(fake.log_text(), HasSubstr("Aborted"));
  EXPECT_THAT(failure_of("kill -9 $$"),
              AllOf(HasSubstr("was killed by signal 9"), HasSubstr("memory was not enough"),
                    testing::Not(HasSubstr("Check failed"))));  // of the run before
  EXPECT_THAT(failure_of("echo 'ERROR: database or disk is full'; echo more; exit 1"),
              HasSubstr("(ERROR: database or disk is full): the disk is full; free some"));
  EXPECT_THAT(failure_of("echo 'I20261123 a.cc:1] first'; echo last words; exit 1"),
              HasSubstr("(last words)"));
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

// --- What COLMAP is given, the faces of panoramas, and what it stores of them -------------------

// Two images of two features each, of which one matches; numbers as COLMAP writes them: float32
// and uint32, little-endian. Only the columns that every version has.
void write_database(const std::filesystem::path& file) {
  SqliteConnection connection(file, SqliteAccess::kReadWrite);
  connection.execute(
      "CREATE TABLE images (image_id INTEGER, name TEXT, camera_id INTEGER);"
      "CREATE TABLE keypoints (image_id INTEGER, rows INTEGER, cols INTEGER, data BLOB);"
      "CREATE TABLE two_view_geometries (pair_id INTEGER, rows INTEGER, cols INTEGER, data BLOB);"
      "INSERT INTO images VALUES (1, 'f0/1.png', 5), (2, 'f0/2.png', 5), (3, 'f0/3.png', 5);"
      // (1, 2), (3, 4)
      "INSERT INTO keypoints VALUES (1, 2, 2, x'0000803f000000400000404000008040');"
      // (1, 2, 0, 0), (0.5, 8, 0, 0)
      "INSERT INTO keypoints VALUES (2, 2, 4, "
      "x'0000803f0000004000000000000000000000003f000000410000000000000000');"
      // 2^31 - 1 + 2: images 1 and 2; feature 0 of the first is feature 1 of the second
      "INSERT INTO two_view_geometries VALUES (2147483649, 1, 2, x'0000000001000000');"
      "INSERT INTO two_view_geometries VALUES (2147483650, 0, 2, NULL);");
}

// COLMAP 3.8 has a prior pose of images, newer ones more tables.
constexpr const char* kOfOtherVersions =
    "ALTER TABLE images ADD COLUMN prior_qw REAL;"
    "ALTER TABLE two_view_geometries ADD COLUMN qvec BLOB;"
    "CREATE TABLE frames (frame_id INTEGER, rig_id INTEGER);"
    "INSERT INTO frames VALUES (1, 5);";

TEST(ColmapDatabase, HasImagesAndVerifiedMatchesInEveryVersion) {
  const TestDirectory directory;
  const std::filesystem::path file = directory / "database.db";
  write_database(file);
  for (const char* more : {"", kOfOtherVersions}) {
    SqliteConnection(file, SqliteAccess::kReadWrite).execute(more);
    const auto images = read_database_images(file);
    ASSERT_EQ(images.size(), 3U);
    EXPECT_EQ(images.at("f0/2.png").id, 2U);
    EXPECT_EQ(images.at("f0/2.png").camera, 5U);
    EXPECT_EQ(images.at("f0/2.png").features, 2);
    EXPECT_EQ(images.at("f0/3.png").features, 0);
    const auto is_at = [](double x, double y) {
      return AllOf(Field(&FacePixel::x, x), Field(&FacePixel::y, y));
    };
    EXPECT_THAT(read_verified_pairs(file),
                ElementsAre(AllOf(Field(&VerifiedPair::first, 1U), Field(&VerifiedPair::second, 2U),
                                  Field(&VerifiedPair::in_first, ElementsAre(is_at(1.0, 2.0))),
                                  Field(&VerifiedPair::in_second, ElementsAre(is_at(0.5, 8.0))))));
  }
}

TEST(ColmapDatabase, RefusesDamage) {
  const TestDirectory directory;
  const std::filesystem::path file = directory / "database.db";
  const auto error = [&] { return error_of([&] { read_verified_pairs(file); }); };
  for (const char* damage :
       {"UPDATE keypoints SET rows = 3 WHERE image_id = 1", "UPDATE keypoints SET cols = 900",
        "UPDATE keypoints SET rows = -1",
        "UPDATE two_view_geometries SET data = x'0000000009000000' WHERE rows = 1",
        "DELETE FROM keypoints WHERE image_id = 2"}) {
    std::filesystem::remove(file);
    write_database(file);
    SqliteConnection(file, SqliteAccess::kReadWrite).execute(damage);
    EXPECT_THAT(error(), HasSubstr("damaged")) << damage;
  }
  std::ofstream(file) << "this is no database, however long the text in it may be";
  EXPECT_NE(error(), "no error");
  std::filesystem::remove(file);
  EXPECT_NE(error(), "no error");
}

constexpr int kMatchedFace_px = 64;

DualFisheyeLayout two_lenses() {
  DualFisheyeLayout lenses;
  lenses.front_position_m = {0.001, 0.002, 0.006};
  lenses.back_position_m = {-0.001, 0.0, -0.004};
  return lenses;
}

TEST(MatchingFaces, LieEachInOneLensAndMeetAtFrontSidesAndBack) {
  const DualFisheyeLayout lenses = two_lenses();
  const auto faces = panorama_faces(lenses);
  int front = 0;
  for (const PanoramaFace& face : faces) {
    const bool is_front = face.camera_from_face.col(2).z() > 0;
    front += is_front ? 1 : 0;
    EXPECT_EQ(face.centre_m, is_front ? lenses.front_position_m : lenses.back_position_m);
    for (const double x : {0.0, static_cast<double>(kMatchedFace_px)}) {
      for (const double y : {0.0, 0.5 * kMatchedFace_px, static_cast<double>(kMatchedFace_px)}) {
        const double z = direction_of(face, kMatchedFace_px, {x, y}).z();
        EXPECT_GE(is_front ? z : -z, -1e-12);
      }
    }
  }
  EXPECT_EQ(front, 2);
  EXPECT_EQ(panorama_faces(std::nullopt)[2].centre_m.norm(), 0.0);
}

TEST(MatchingFaces, AreAsLargeAsThePanoramaDemandsWithinLimits) {
  EXPECT_EQ(default_face_px(256), 384);
  EXPECT_EQ(default_face_px(1024), 512);
  EXPECT_EQ(default_face_px(4096), 768);
}

TEST(OverlappingFaces, LookTheSameWay) {
  const auto faces = panorama_faces(std::nullopt);
  const auto pairs_of = [&](const Attitude& first, const Attitude& second) {
    return overlapping_faces(faces, world_from_camera(first), world_from_camera(second));
  };
  const std::vector<FacePair> alike = pairs_of({0.1, 0.0, 0.05}, {-0.1, 0.1, 0.0});
  ASSERT_EQ(alike.size(), 4U);
  for (const FacePair& pair : alike) EXPECT_EQ(pair.first, pair.second);
  const std::vector<FacePair> to_right = pairs_of({}, {kHalfPi, 0, 0});
  ASSERT_EQ(to_right.size(), 4U);
  for (const auto& [ahead, turned] : to_right) {
    EXPECT_NEAR(faces[ahead].camera_from_face.col(2).dot(world_from_camera({kHalfPi, 0, 0}) *
                                                         faces[turned].camera_from_face.col(2)),
                1.0, 1e-12);
  }
  // Half way between two faces, both overlap by half.
  EXPECT_EQ(pairs_of({}, {0.5 * kHalfPi, 0, 0}).size(), 8U);
}

}  // namespace
}  // namespace raywalk::calibrate
