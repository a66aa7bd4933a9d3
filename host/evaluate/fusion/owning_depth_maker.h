#pragma once

#include <memory>
#include <optional>
#include <string>

#include "dataset/dataset.h"
#include "dsp/depth/depth_maker.h"
#include "host/evaluate/workspace.h"
#include "lab/searches.h"
#include "posix/worker_threads.h"

namespace stof::host {

// How DepthMaker is set up for a scene.
struct DepthMakerOptions {
  dsp::QuarterMm max_range = dsp::FusionParams{}.max_range;
  bool guided = false;
  bool temporal = false;
  int threads = 1;
};

// A DepthMaker with its memory and threads, which may use the searches of lab/.
class OwningDepthMaker {
 public:
  // rig: of a recording, for pictures of width x height. One line when they do
  // not go together, are too large, or the system has no such number of threads.
  static dataset::Loaded<std::unique_ptr<OwningDepthMaker>> make(const std::string& scene,
                                                                 const dsp::Calibration& rig,
                                                                 int width, int height,
                                                                 const lab::MatchParams& match,
                                                                 const DepthMakerOptions& options);
  OwningDepthMaker(const OwningDepthMaker&) = delete;
  OwningDepthMaker& operator=(const OwningDepthMaker&) = delete;

  const dsp::Calibration& calibration() const { return calibration_; }
  dsp::DepthMaker& operator*() { return *maker_; }
  dsp::DepthMaker* operator->() { return &*maker_; }

 private:
  OwningDepthMaker(const dsp::Calibration& calibration, const lab::MatchParams& match, int threads);

  dsp::Calibration calibration_;
  lab::MatchParams match_;
  posix::WorkerThreads workers_;
  dataset::Image<std::uint8_t> continued_;
  std::optional<lab::Searches> searches_;
  std::optional<Workspace> space_;
  std::optional<dsp::DepthMaker> maker_;
};

}  // namespace stof::host
