#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "dsp/calib/calibration.h"
#include "host/calibrate/rig/planes/plane_disparities.h"
#include "host/calibrate/rig/target/target_calibration.h"
#include "host/cli/live/live_lines.h"
#include "host/cli/live/raw_feed.h"
#include "host/cli/rig/calib_rig.h"

// What the live forms of `stof calib` share: the folder that views are kept in, the lines that tell
// how it goes, and when it ends.
namespace stof::host {

// A folder of views as the folder forms read it: PREFIX_001, PREFIX_002, ...
class KeptViews {
 public:
  // Made where missing; throws Failure, also where a view in it lacks one of its pictures. Views
  // that lie in it count.
  KeptViews(std::filesystem::path folder, std::string prefix);
  KeptViews(const KeptViews&) = delete;
  KeptViews& operator=(const KeptViews&) = delete;
  // Where no view was kept no folder is left that was made for them.
  ~KeptViews();

  const std::filesystem::path& folder() const { return folder_; }
  bool empty() const;
  std::size_t count() const;
  std::string next_name() const;  // that is free
  // left.pgm and right.pgm into the folder of that name, both or none; its path. Throws Failure.
  std::filesystem::path write(const std::string& name, const RawShot& shot) const;
  // The same for a view that is still to be judged: staged().parent_path() holds it alone, until
  // keep() or drop().
  std::filesystem::path stage(const std::string& name, const RawShot& shot) const;
  void keep(const std::filesystem::path& staged) const;
  static void drop(const std::filesystem::path& staged);

 private:
  std::filesystem::path folder_;
  std::string prefix_;
  bool made_ = false;
};

// PMD samples beside a pair: pmd.json and pmd_raw.pgm, with the constants of the calibration.
void write_samples(const std::filesystem::path& folder,
                   const std::vector<dataset::Image<std::uint16_t>>& frames,
                   std::int32_t after_pair_us, const dsp::PmdSensor& sensor);

// The exposures of a sensor until the time is over or somebody asks to stop. What ends it early
// says what was kept.
class LiveShots {
 public:
  LiveShots(const CalibLiveOptions& options, bool pmd);
  // None: asked to stop, or the time is over: why() says it. Throws Failure where the sensor gives
  // none; `kept` is added to its line.
  std::optional<RawShot> next(const std::string& kept);
  const std::string& why() const { return why_; }
  std::optional<dsp::Pinhole> told_lens() const { return feed_.told_lens(); }

 private:
  RawFeed feed_;
  std::chrono::steady_clock::time_point end_;
  double limit_s_;
  std::string why_;
};

// live.keep, else a folder beside the file that is made.
std::filesystem::path live_folder(const CalibLiveOptions& live, const std::filesystem::path& out,
                                  const char* ending);

// With --live; it also keeps the views. All of them are there, or the Failure says how many are.
TargetCalibration calib_live_stereo(const CalibStereoOptions& options, const TargetOptions& target);
// Fills the folder of --planes with a wall at each of --distances that it does not hold yet.
void calib_live_planes(const CalibStereoOptions& options, const PlaneOptions& search);
// The folder that it filled.
std::filesystem::path calib_live_walls(const CalibFolderOptions& options,
                                       const dsp::Calibration& rig);
std::filesystem::path calib_live_pictures(const CalibFolderOptions& options,
                                          const dsp::Calibration& rig);

}  // namespace stof::host
