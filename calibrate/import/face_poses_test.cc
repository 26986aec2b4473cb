#include "calibrate/import/face_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/import/test_poses.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using ::testing::HasSubstr;

std::vector<ColmapImagePose> images_of(const std::vector<ImportedFrame>& frames,
                                       const std::vector<NamedFace>& faces) {
  std::vector<ColmapImagePose> images;
  for (const ImportedFrame& frame : frames) {
    for (const NamedFace& face : faces) {
      images.push_back(
          {face.folder + "/" + frame.file, colmap_pose(frame.pose, {face.camera_from_face})});
    }
  }
  return images;
}

TEST(FacePoses, GiveThePosesOfTheirPanoramas) {
  const std::vector<ImportedFrame> frames = square_frames();
  std::vector<ColmapImagePose> images = images_of(frames, exported_faces());
  images.erase(images.begin() + 2, images.begin() + 6);  // two faces of the first are enough
  const auto found = panoramas_of_faces(images, exported_faces(), "model");
  ASSERT_EQ(found.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(found[i].file + ".png", frames[i].file);
    EXPECT_LT((found[i].pose.position_m - frames[i].pose.position_m).norm(), 1e-13);
    EXPECT_LT((found[i].pose.world_from_camera - frames[i].pose.world_from_camera).norm(), 1e-13);
  }
}

TEST(FacePoses, FollowATable) {
  const TestDirectory directory;
  write_file_atomically(directory / "faces.csv",
                        "folder,yaw,pitch\npano_camera0,0,-35\npano_camera1,45,35\n");
  const std::vector<NamedFace> faces = read_face_table(directory / "faces.csv");
  ASSERT_EQ(faces.size(), 2U);
  EXPECT_LT(faces[0].camera_from_face.col(2).y(), -0.5);  // looks down
  EXPECT_GT(faces[1].camera_from_face.col(2).x(), 0.5);   // and to the right
  const std::vector<ImportedFrame> frames = square_frames();
  const auto found = panoramas_of_faces(images_of(frames, faces), faces, "model");
  EXPECT_LT((found[3].pose.world_from_camera - frames[3].pose.world_from_camera).norm(), 1e-13);
}

TEST(FacePoses, OfOtherFacesAreRefused) {
  const std::vector<ImportedFrame> frames = square_frames();
  const auto error_for = [&](const std::vector<ColmapImagePose>& images) {
    return error_of([&] { panoramas_of_faces(images, exported_faces(), "sparse/0"); });
  };
  EXPECT_THAT(
      error_for({{"IMG_1.jpg", {}}}),
      HasSubstr("sparse/0: image 'IMG_1.jpg' is in none of the folders of faces (front, right"));
  // Left and right exchanged.
  std::vector<NamedFace> swapped = exported_faces();
  std::swap(swapped[1].folder, swapped[3].folder);
  EXPECT_THAT(error_for(images_of(frames, swapped)), HasSubstr("disagree by"));
  std::vector<ColmapImagePose> images = images_of(frames, exported_faces());
  images[1].pose.translation.x() += 0.9;
  EXPECT_THAT(error_for(images), HasSubstr("apart, while panoramas are"));
}

}  // namespace
}  // namespace raywalk::calibrate
