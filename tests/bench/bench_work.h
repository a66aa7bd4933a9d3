#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "dsp/stereo/match_params.h"
#include "lab/match_params.h"

// What is timed on the host (stof_bench) and counted for ARM (stof_count): the same work on the
// same inputs. No OpenCV.
namespace stof::bench {

using Work = std::function<void()>;

struct Pictures {
  std::string name;
  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;
};

// The scene in another size, bilinear.
Pictures resized(const dataset::StereoScene& scene, int width, int height);
// The emulated corridor with the noise of its first exposure.
Pictures corridor_pictures(int width, int height);
// Value noise with surfaces at several disparities; integers alone, so that a slow processor has it
// at once.
Pictures made_pictures(int width, int height);

// 15x15 SAD of derivatives, the best candidate of every pixel, fitted to 1/16 px; no checks: what
// OpenCV's StereoBM computes with its filters off.
dsp::MatchParams block_params(int disparities);
dsp::MatchParams preset_params(const char* preset, int disparities);
// What the appliance makes of it: fitted, with the confidence that fusion needs.
dsp::MatchParams appliance_params(const char* preset, int disparities);
// The same search in whole pixels, from coarse to fine; 0: from all candidates.
lab::MatchParams pyramid_params(int levels, int disparities);

// Matches the pair. The map is made with `threads` threads.
Work match_work(const Pictures& pictures, const dsp::MatchParams& params, int threads = 1);
Work match_work(const Pictures& pictures, const lab::MatchParams& params, int threads = 1);

// Four PMD samples of noise, 12 bits.
struct Samples {
  Samples(int width, int height);
  std::vector<dataset::Image<std::uint16_t>> images;
};
// Samples to phase, amplitude, offset and flags.
Work phase_work(const Samples& samples);

// Both pictures of a pair whose lenses bend and which are turned against each other.
dsp::StereoRig raw_rig(int width, int height);
Work rectify_work(const Pictures& pictures);

// The emulated corridor, 640x480 with a 176x144 PMD camera, and what becomes of a frame of it.
class CorridorWork {
 public:
  // Matches with `params`. temporal: as in DepthParams.
  explicit CorridorWork(const dsp::MatchParams& params, bool temporal = false);
  ~CorridorWork();
  CorridorWork(const CorridorWork&) = delete;
  CorridorWork& operator=(const CorridorWork&) = delete;

  void convert();  // PMD samples to distance with an interval
  void match();
  void fuse();  // both to depth; after match(). Once for each convert(): it also tells periods
  void convert_and_fuse();
  void stand();       // convert_and_fuse() of the next exposure of the same view
  void code_depth();  // depth by RVL, as datagrams
  void code_three();  // depth, width and source as they are sent where nothing else is asked for
  void encode();      // depth as RVL
  void decode();      // and back; after encode()
  void check();       // CRC-32C of the bytes of the depth
  // All of a frame: convert(), match(), fuse(), code_depth().
  void frame();

  const Pictures& pictures() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stof::bench
