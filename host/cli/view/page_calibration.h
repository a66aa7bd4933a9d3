#pragma once

#include <expected>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "host/cli/config/config.h"
#include "host/cli/view/line_program.h"
#include "host/cli/view/page_settings.h"
#include "host/viewer/page_message.h"
#include "host/viewer/panel_messages.h"

namespace stof::host {

struct CalibrationOptions {
  ConfigOptions config{};          // keys, and which sensor is meant
  std::filesystem::path folder{};  // calibrations get folders of their own in it
  // What runs `calib stereo --live --json`: this program, which may lack it (`absence`: one line
  // why; empty: it has it).
  std::string program = "/proc/self/exe";
  std::string absence{};
};

// The calibration panel of the page: runs `stof calib stereo --live --json` as a program of its
// own, whose lines it passes on, and installs what comes of it, as `stof calib install`. Its own
// program, because it is ended as a user ends it, and because what it needs beside is heavy and may
// fail. One calibration at a time. The page that began it alone has it ended and installed, as long
// as its connection lasts. For one thread, unless said otherwise; none of it waits for a
// calibration but the destructor, which ends it.
class PageCalibration {
 public:
  using Tell = std::function<void(const viewer::CalibrationState& state)>;  // for any thread
  // Which page's connection: expired once it has ended.
  using Asker = std::weak_ptr<const void>;

  PageCalibration(CalibrationOptions options, Tell tell);
  ~PageCalibration();
  PageCalibration(const PageCalibration&) = delete;
  PageCalibration& operator=(const PageCalibration&) = delete;

  // Tells how it is, and how many views an unfinished calibration of this sensor has.
  void read(const ShownSensor& sensor);
  // One line: why not.
  using Done = std::expected<void, std::string>;
  Done begin(const ShownSensor& sensor, const viewer::BeginCalibration& wish, const Asker& asker);
  Done end(const Asker& asker);
  // What the calibration before this made; takes a key of role admin.
  Done install(const ShownSensor& sensor, const Asker& asker);

 private:
  struct Run;
  void run(const Run& what);
  void put(const ShownSensor& sensor, const std::filesystem::path& file);
  std::vector<std::string> words(const Run& what) const;
  void follow(LineProgram& program);
  void take(const std::string& line);
  Done begin_work(const Asker& asker);
  std::string not_yours(const Asker& asker) const;
  template <typename Change>
  void change(Change&& how);

  const CalibrationOptions options_;
  const Tell tell_;
  mutable std::mutex mutex_;
  viewer::CalibrationState state_;
  Asker asker_;  // who began it
  bool under_way_ = false;
  bool ends_ = false;
  std::filesystem::path file_;            // what was made; empty: nothing
  const LineProgram* program_ = nullptr;  // that may be interrupted
  std::thread thread_;
};

}  // namespace stof::host
