#include "host/calibrate/rig/extrinsics/pmd_board_views.h"

#include "dataset/files/file.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/evaluate/owning_converter.h"

namespace stof::host {
namespace {

dataset::Image<float> mean_amplitude(const dsp::PmdSensor& sensor,
                                     const dataset::PmdRecording& recording) {
  OwningConverter converter(sensor);
  dataset::Image<float> sum(sensor.lens.width, sensor.lens.height);
  for (std::size_t n = 0; n < recording.frames.size(); ++n) {
    const dsp::PmdMaps& maps = converter->convert(recording.samples(n));
    for (int y = 0; y < sum.height; ++y) {
      for (int x = 0; x < sum.width; ++x) {
        sum.view().at(x, y) += static_cast<float>(maps.amp2.at(x, y));
      }
    }
  }
  return sum;
}

bool same(const dsp::Pinhole& a, const dsp::Pinhole& b) {
  return a.width == b.width && a.height == b.height;
}

}  // namespace

dataset::Loaded<PmdBoardViews> read_board_views(const std::filesystem::path& dir,
                                                const dsp::Calibration& calibration,
                                                const Board& board) {
  const dataset::Loaded<std::vector<std::filesystem::path>> pairs = list_pairs(dir);
  if (!pairs) {
    return std::unexpected(pairs.error());
  }
  const dsp::RawPair eyes = fixed_pair(calibration.stereo).rig;
  PmdBoardViews found;
  for (const std::filesystem::path& folder : *pairs) {
    const dataset::Loaded<Pair> pair = read_pair(folder);
    if (!pair) {
      return std::unexpected(pair.error());
    }
    const dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd(folder / "pmd");
    if (!recording) {
      return std::unexpected(recording.error());
    }
    const dsp::Pinhole& left = calibration.stereo.left;
    if (pair->left.width != left.width || pair->left.height != left.height ||
        !same(recording->calibration.pmd.lens, calibration.pmd.lens)) {
      return dataset::refuse(folder, "is of another size than the calibration's cameras",
                             "give the calibration of this rig");
    }
    const std::optional<FoundBoard> by_left = find_board_through(eyes.left, pair->left, board);
    const std::optional<FoundBoard> by_right = find_board_through(eyes.right, pair->right, board);
    std::vector<PixelPoint> by_pmd = corners_in_amplitude(
        mean_amplitude(calibration.pmd, *recording), calibration.pmd.lens, board);
    if (!by_left || !by_right || by_pmd.empty()) {
      const char* who = by_right ? "PMD" : "right";
      who = by_left ? who : "left";
      found.refused.push_back(pair->name + ": the " + who +
                              " camera does not see the whole board, or too coarsely");
      continue;
    }
    found.views.push_back(
        {.pair = {.name = pair->name, .left = by_left->corners, .right = by_right->corners},
         .pmd = std::move(by_pmd)});
  }
  return found;
}

}  // namespace stof::host
