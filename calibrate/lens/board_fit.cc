#include "calibrate/lens/board_fit.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "calibrate/base/cauchy_loss.h"
#include "calibrate/lens/camera_model.h"
#include "calibrate/lens/charuco_detection.h"
#include "calibrate/lens/fit_details.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

constexpr int kLeastBoardCorners = 40;  // of a lens, in all pictures

struct CornerResidual {
  CameraFrame frame{};
  BoardCorner corner{};
  double sigma_px = 1.0;

  template <typename T>
  bool operator()(const T* lens, const T* back_pose, const T* board, T* residual) const {
    const T on_board[3] = {T(corner.on_board_m.x()), T(corner.on_board_m.y()),
                           T(corner.on_board_m.z())};
    T in_camera[3], pixel[2];
    ceres::AngleAxisRotatePoint(board, on_board, in_camera);
    for (int i = 0; i < 3; ++i) in_camera[i] += board[3 + i];
    image_point(frame, corner.back, lens, back_pose, in_camera, T(1.0), pixel);
    residual[0] = (corner.seen.u - pixel[0]) / sigma_px;
    residual[1] = (corner.seen.v - pixel[1]) / sigma_px;
    return true;
  }
};

PoseParameters pose_of(const BoardView& view) {
  PoseParameters pose{};
  ceres::RotationMatrixToAngleAxis(view.turn.data(), pose.data());
  for (std::size_t i = 0; i < 3; ++i) pose[3 + i] = view.shift_m[static_cast<Eigen::Index>(i)];
  return pose;
}

bool has_both_lenses(const BoardView& view) {
  const auto by_back = [](const BoardCorner& corner) { return corner.back; };
  return std::any_of(view.corners.begin(), view.corners.end(), by_back) &&
         !std::all_of(view.corners.begin(), view.corners.end(), by_back);
}

class CornerFit {
 public:
  CornerFit(const std::vector<BoardView>& views, const DualFisheyeLayout& start)
      : views_(views), start_(start), camera_(parameters_of(start)) {
    for (const BoardView& view : views) boards_.push_back(pose_of(view));
    connected_ = std::any_of(views.begin(), views.end(), has_both_lenses);
  }

  void fit() {
    constexpr int kMostIterations = 100;
    // Twice, as the noise of the corners is known only after the first fit.
    for (int round = 0; round < 2; ++round) {
      ceres::Problem problem;
      build(&problem);
      solve_fit(&problem, {}, kMostIterations);
      sigma_px_ = std::clamp(robust_sigma_px(), 0.01, sigma_px_);
    }
  }

  LensFit result();

 private:
  LensParameters& lens(bool back) { return back ? camera_.back : camera_.front; }

  void build(ceres::Problem* problem) {
    const CameraFrame frame = camera_frame_of(start_);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (const BoardCorner& corner : views_[v].corners) {
        using Cost = ceres::AutoDiffCostFunction<CornerResidual, 2, kLensParameters,
                                                 kPoseParameters, kPoseParameters>;
        problem->AddResidualBlock(new Cost(new CornerResidual{frame, corner, sigma_px_}),
                                  new ceres::CauchyLoss(kCauchySigmas), lens(corner.back).data(),
                                  camera_.back_pose.data(), boards_[v].data());
      }
    }
    for (const bool back : {false, true}) {
      problem->AddResidualBlock(
          new ceres::AutoDiffCostFunction<LensPrior, kLensParameters, kLensParameters>(
              new LensPrior(back ? start_.back : start_.front)),
          nullptr, lens(back).data());
    }
    if (!connected_) problem->SetParameterBlockConstant(camera_.back_pose.data());
  }

  Eigen::Vector2d residual(std::size_t view, const BoardCorner& corner) {
    Eigen::Vector2d px;
    CornerResidual{camera_frame_of(start_), corner, 1.0}(
        lens(corner.back).data(), camera_.back_pose.data(), boards_[view].data(), px.data());
    return px;
  }

  double robust_sigma_px() {
    std::vector<double> sizes;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (const BoardCorner& corner : views_[v].corners) {
        const Eigen::Vector2d px = residual(v, corner);
        sizes.push_back(std::fabs(px.x()));
        sizes.push_back(std::fabs(px.y()));
      }
    }
    return robust_sigma(std::move(sizes));
  }

  const std::vector<BoardView>& views_;
  const DualFisheyeLayout& start_;
  CameraParameters camera_;
  std::vector<PoseParameters> boards_;
  bool connected_ = false;  // some picture shows the board to both lenses
  double sigma_px_ = 2.0;
};

LensFit CornerFit::result() {
  LensFit fit;
  fit.camera.layout = layout_of(camera_, start_);
  fit.method = "charuco";
  fit.pictures = static_cast<int>(views_.size());
  fit.back_pose_fitted = connected_;
  std::vector<FitResidual> residuals;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    std::set<std::pair<double, double>> places;  // corners by their position on the board
    std::array<int, 2> by_lens{};
    for (const BoardCorner& corner : views_[v].corners) {
      const Eigen::Vector2d px = residual(v, corner);
      if (px.norm() > kOutlierSigmas * sigma_px_) {
        ++fit.dropped_observations;
        continue;
      }
      residuals.push_back({corner.back, corner.seen, px});
      places.emplace(corner.on_board_m.x(), corner.on_board_m.y());
      ++by_lens[corner.back ? 1 : 0];
    }
    fit.points += static_cast<int>(places.size());
    // A board that each lens sees in part connects them as well as common corners.
    fit.overlap_points += std::min(by_lens[0], by_lens[1]);
  }
  set_residuals(residuals, &fit);
  ceres::Problem problem;
  build(&problem);
  set_uncertainty(camera_, camera_covariance(&problem, camera_), &fit);
  if (!connected_) {
    fit.warnings.emplace_back(
        "no picture shows the board to both lenses, so the pose of the back lens keeps its "
        "starting "
        "values; add pictures of the board at the camera's side");
  }
  return fit;
}

void require_corners(const std::vector<BoardView>& views) {
  for (const bool back : {false, true}) {
    int corners = 0;
    for (const BoardView& view : views) {
      corners += static_cast<int>(
          std::count_if(view.corners.begin(), view.corners.end(),
                        [back](const BoardCorner& corner) { return corner.back == back; }));
    }
    if (corners >= kLeastBoardCorners) continue;
    throw Error(fmt::format(
        "the {} lens sees {} corners of the board in all pictures together, but {} are needed: add "
        "pictures with the board near that lens, and check the board's dictionary and numbers of "
        "squares",
        back ? "back" : "front", corners, kLeastBoardCorners));
  }
}

LensPictures pictures_at(const LensOptions& options, bool two_files, std::size_t index) {
  const std::size_t step = two_files ? 2 : 1;
  LensPictures pictures;
  pictures.front = read_picture(options.board_pictures[index * step]);
  pictures.back =
      two_files ? read_picture(options.board_pictures[index * step + 1]) : pictures.front;
  return pictures;
}

PanoramaSize size_of_all(const std::vector<std::filesystem::path>& pictures) {
  const PanoramaSize size = picture_header_of(pictures.front()).size;
  TurnedPictures turned;
  for (const std::filesystem::path& file : pictures) {
    const ImageHeader header = picture_header_of(file);
    turned.add(file, header.orientation);
    if (header.size == size) continue;
    throw Error(file.string() + ": not of the size of " + pictures.front().string() +
                "; the pictures of the board must be of one camera and setting");
  }
  turned.warn();
  return size;
}

LensFit fit_to_corners(const std::vector<BoardView>& views, const DualFisheyeCamera& start) {
  require_corners(views);
  CornerFit fit(views, start.layout);
  fit.fit();
  LensFit result = fit.result();
  result.start = start;
  result.camera.picture = start.picture;
  result.camera.two_files = start.two_files;
  return result;
}

}  // namespace

LensFit fit_to_board(const DualFisheyeCamera& start_as_given, const LensOptions& options) {
  require_valid(*options.board);
  const std::size_t files = options.board_pictures.size();
  const std::size_t per_picture = start_as_given.two_files ? 2 : 1;
  if (files == 0 || files % per_picture != 0) {
    throw UsageError(
        "pictures of the board are missing; give several, for a camera with two files as front, "
        "back, front, back, ...");
  }
  const DualFisheyeCamera start = scaled_to(start_as_given, size_of_all(options.board_pictures));
  const int count = static_cast<int>(files / per_picture);
  std::vector<std::optional<BoardView>> found(static_cast<std::size_t>(count));
  const BoardFinder finder(start, *options.board);
  Progress progress("looking for the board", count, "pictures");
  parallel_for(0, count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto at = static_cast<std::size_t>(i);
      found[at] = finder.find(pictures_at(options, start.two_files, at));
      progress.advance();
    }
  });
  std::vector<BoardView> views;
  for (const auto& view : found) {
    if (view) views.push_back(*view);
  }
  return fit_to_corners(views, start);
}

}  // namespace raywalk::calibrate
