#include "calibrate/rectify/rectify_blocks.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "calibrate/base/number_bytes.h"
#include "calibrate/rectify/compared_light.h"
#include "calibrate/rectify/rectified_frames.h"
#include "core/base/error.h"
#include "core/files/block_results.h"
#include "core/files/fingerprint.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr Block kWhole{};  // the gains are found in one piece

class RectifyBlocks {
 public:
  RectifyBlocks(const CaptureSet& panoramas, const FramePoses& poses, const RectifyOptions& options)
      : set_(panoramas),
        poses_(poses),
        options_(options),
        mask_(options.mask.value_or(cv::Mat())),
        folder_(options.out / "blocks") {}

  BlockResults light() const { return {folder_, "rectify-light", light_fingerprint()}; }
  BlockResults gains() const { return {folder_, "rectify-gains", light_fingerprint()}; }
  LightComparison comparison() const { return {set_, poses_, mask_}; }

  // From what all blocks compared; nullopt if nothing is to be.
  std::optional<ExposureResult> exposure() const {
    if (!options_.equalise_gain) return std::nullopt;
    std::vector<LinkPatches> links;
    for (const std::string& bytes : light().merged()) {
      std::vector<LinkPatches> of_block = read_link_patches(bytes, set_.frames.size());
      std::move(of_block.begin(), of_block.end(), std::back_inserter(links));
    }
    return comparison().exposures(links);
  }

  // The gains that merge_light found.
  std::vector<LightGain> merged_gains() const {
    if (!options_.equalise_gain) return gains_of(std::nullopt, set_.frames.size());
    if (!gains().done(kWhole)) {
      throw Error(fmt::format(
          "{}: the light of these frames has not been compared; do that first with --light --block "
          "1/N to N/N and --light --merge, or give --no-gain",
          options_.out.string()));
    }
    const std::string bytes = gains().merged().front();
    NumberReader reader(bytes, "the gains of the frames are damaged; run --light --merge again");
    std::vector<LightGain> found(set_.frames.size());
    for (LightGain& gain : found) {
      for (double& of_colour : gain) of_colour = reader.number<double>();
    }
    reader.end();
    return found;
  }

  std::string frames_fingerprint(const std::vector<LightGain>& gains) const {
    return rectified_fingerprint(set_, poses_, gains, mask_, options_.fisheye);
  }
  BlockResults frames(const std::string& fingerprint) const {
    return {folder_, "rectify", fingerprint};
  }
  // Of the frames that blocks wrote; removed with their results.
  fs::path frames_folder(const std::string& fingerprint) const {
    return folder_ / "rectify" / (fingerprint + ".frames");
  }

  void write_block(const std::vector<LightGain>& gains, Block block, const fs::path& folder) const {
    write_rectified_block(set_, poses_, gains, mask_, options_.fisheye, block, folder);
  }
  void install(const fs::path& folder) const {
    install_rectified_frames(set_, poses_, mask_, options_.fisheye, folder, options_.out);
  }

 private:
  std::string light_fingerprint() const {
    std::string text = "light 1";
    if (!mask_.empty()) text += " mask " + sha256_of_pixels(mask_);
    for (const int frame : posed_frames(poses_)) {
      const CaptureFrame& of = set_.frames[static_cast<std::size_t>(frame)];
      const FramePose& pose = *poses_[static_cast<std::size_t>(frame)];
      text +=
          fmt::format("\n{} {} {} {}", frame, of.line, of.file.string(), stamp_of(of.file).text());
      if (of.mask) text += " mask " + of.mask->string() + " " + stamp_of(*of.mask).text();
      for (const double number : pose.position_m) text += fmt::format(" {:.17g}", number);
      for (const double number : pose.world_from_camera.reshaped()) {
        text += fmt::format(" {:.17g}", number);
      }
    }
    return sha256_hex(text);
  }

  const CaptureSet& set_;
  const FramePoses& poses_;
  const RectifyOptions& options_;
  cv::Mat mask_;
  fs::path folder_;
};

}  // namespace

std::size_t compare_light_block(const CaptureSet& panoramas, const FramePoses& poses,
                                const RectifyOptions& options, Block block) {
  if (!options.equalise_gain) return 0;
  const RectifyBlocks blocks(panoramas, poses, options);
  const LightComparison comparison = blocks.comparison();
  const IndexRange share = block.share_of(comparison.pairs());
  blocks.light().make(block, [&] { return bytes_of(comparison.compare(share)); });
  return share.size();
}

void merge_light(const CaptureSet& panoramas, const FramePoses& poses,
                 const RectifyOptions& options) {
  const RectifyBlocks blocks(panoramas, poses, options);
  const auto exposure = blocks.exposure();
  if (!exposure) return;
  blocks.gains().make(kWhole, [&] {
    NumberWriter writer;
    for (const LightGain& gain : exposure->gains) {
      for (const double of_colour : gain) writer.number(of_colour);
    }
    return writer.take();
  });
}

std::size_t rectify_block(const CaptureSet& panoramas, const FramePoses& poses,
                          const RectifyOptions& options, Block block) {
  const RectifyBlocks blocks(panoramas, poses, options);
  const std::vector<LightGain> gains = blocks.merged_gains();
  const std::string fingerprint = blocks.frames_fingerprint(gains);
  blocks.frames(fingerprint).make(block, [&] {
    blocks.write_block(gains, block, blocks.frames_folder(fingerprint));
    return std::string();
  });
  return block.share_of(posed_frames(poses).size()).size();
}

RectifyResult merge_rectified(const CaptureSet& panoramas, const FramePoses& poses,
                              const RectifyOptions& options) {
  const RectifyBlocks blocks(panoramas, poses, options);
  const std::string fingerprint = blocks.frames_fingerprint(blocks.merged_gains());
  const BlockResults frames = blocks.frames(fingerprint);
  frames.merged();  // names what is missing
  std::optional<ExposureResult> exposure = blocks.exposure();
  blocks.install(blocks.frames_folder(fingerprint));
  RectifyResult result = finish_rectified(panoramas, poses, options, std::move(exposure));
  frames.remove();
  blocks.gains().remove();
  blocks.light().remove();
  return result;
}

}  // namespace raywalk::calibrate
