#include "host/evaluate/sequence/sequence.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "dataset/files/file.h"
#include "host/evaluate/fusion/depth_images.h"
#include "host/evaluate/fusion/fusion.h"
#include "host/evaluate/stereo/median.h"

namespace stof::host {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// A frame as recorded; no recording where the PMD camera did not expose.
struct RecordedFrame {
  dataset::StereoScene pair;
  std::optional<dataset::PmdRecording> recording;
};

dataset::Loaded<RecordedFrame> read_frame(const fs::path& folder) {
  dataset::Loaded<dataset::StereoScene> pair = dataset::read_stereo_scene(folder);
  if (!pair) {
    return std::unexpected(std::move(pair.error()));
  }
  if (!pair->truth) {
    return dataset::refuse(folder.string() + ": has no gt_left.pgm: give frames with ground truth");
  }
  RecordedFrame frame{.pair = std::move(*pair), .recording = std::nullopt};
  if (fs::exists(folder / "pmd.json")) {
    dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd(folder / "pmd");
    if (!recording) {
      return std::unexpected(std::move(recording.error()));
    }
    frame.recording = std::move(*recording);
  }
  return frame;
}

std::vector<fs::path> frames_in(const fs::path& folder) {
  std::vector<fs::path> frames;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (fs::exists(entry.path() / "meta.txt", error)) {
      frames.push_back(entry.path());
    }
  }
  std::ranges::sort(frames);
  return frames;
}

// One run on its way through the frames.
struct Runner {
  std::unique_ptr<OwningDepthMaker> maker;
  SequenceScorer scorer;
  std::vector<double> fuse_ms;
  std::int32_t pmd_lag_us = 0;

  void take(const RecordedFrame& frame, const dataset::Image<float>& truth) {
    if (frame.recording) {
      (*maker)->convert(FirstFrame(*frame.recording).frame());
      pmd_lag_us = frame.recording->after_pair_us;
    }
    DepthImages images(frame.pair.left.width, frame.pair.left.height);
    (*maker)->match(frame.pair.left.view(), frame.pair.right.view());
    const Clock::time_point begin = Clock::now();
    (*maker)->fuse(images.map(), pmd_lag_us);
    fuse_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    scorer.add(images.planes(), truth);
  }
};

// first: the frame whose recording knows the rig.
dataset::Loaded<Runner> start(const SequenceRun& run, const RecordedFrame& first, int warm_up) {
  const std::expected<lab::MatchParams, dataset::Problem> params =
      fusion_params(run.matcher, first.pair.ndisp);
  if (!params) {
    return std::unexpected(params.error());
  }
  auto maker =
      OwningDepthMaker::make(first.pair.name, first.recording->calibration, first.pair.left.width,
                             first.pair.left.height, *params, run.options);
  if (!maker) {
    return std::unexpected(std::move(maker.error()));
  }
  return Runner{.maker = std::move(*maker),
                .scorer = SequenceScorer(warm_up),
                .fuse_ms = {},
                .pmd_lag_us = 0};
}

}  // namespace

dataset::Loaded<std::vector<SequenceResult>> run_sequence(const fs::path& folder,
                                                          std::span<const SequenceRun> runs,
                                                          int warm_up) {
  const std::vector<fs::path> folders = frames_in(folder);
  if (folders.size() < static_cast<std::size_t>(warm_up) + kWindowFrames) {
    return dataset::refuse(folder.string() + ": holds " + std::to_string(folders.size()) +
                           " frames, fewer than the " + std::to_string(warm_up) +
                           " to warm up and 6 to judge: stof_emu_pair DIR --sequence 24");
  }
  std::optional<RecordedFrame> first;  // lives as long as the makers, which know its fixed pattern
  std::vector<Runner> runners;
  for (const fs::path& each : folders) {
    dataset::Loaded<RecordedFrame> frame = read_frame(each);
    if (!frame) {
      return std::unexpected(std::move(frame.error()));
    }
    if (!first) {  // moved, not copied: its calibration points into it
      if (!frame->recording || !frame->recording->has_rig) {
        return dataset::refuse(each.string() +
                               "/pmd.json: has no rig: give a sequence that begins "
                               "with a recording of both cameras");
      }
      first = std::move(*frame);
      for (const SequenceRun& run : runs) {
        dataset::Loaded<Runner> runner = start(run, *first, warm_up);
        if (!runner) {
          return std::unexpected(std::move(runner.error()));
        }
        runners.push_back(std::move(*runner));
      }
    }
    const RecordedFrame& now = each == folders.front() ? *first : *frame;
    if (now.pair.left.width != first->pair.left.width ||
        now.pair.left.height != first->pair.left.height) {
      return dataset::refuse(each.string() + ": is of another size than the first frame");
    }
    const dataset::Image<float> truth =
        depth_from_disparity(*now.pair.truth, first->recording->calibration.stereo);
    for (Runner& runner : runners) {
      runner.take(now, truth);
    }
  }
  std::vector<SequenceResult> results;
  results.reserve(runners.size());
  for (Runner& runner : runners) {
    results.push_back(
        {.score = runner.scorer.score(), .fuse_ms = median(std::move(runner.fuse_ms)).value_or(0)});
  }
  return results;
}

}  // namespace stof::host
