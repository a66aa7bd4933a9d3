#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/config/config.h"
#include "host/cli/view/page_settings.h"
#include "host/cli/view/page_task.h"
#include "host/viewer/page_message.h"
#include "host/viewer/panel_messages.h"
#include "host/viewer/requests.h"

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
// fail. A calibration is that of the page which began it: it alone ends it, and its connection's
// end ends it too, with its views kept; what it made that page alone installs, and once it has
// gone, any. For one thread; none of it waits for a calibration but the destructor, which ends it.
class PageCalibration {
 public:
  using Task = PageTask<viewer::CalibrationState>;
  using Done = Task::Done;

  PageCalibration(CalibrationOptions options, Task::Tell tell);

  // Tells how it is, and how many views an unfinished calibration of this sensor has.
  void read(const ShownSensor& sensor);
  Done begin(const viewer::Page& page, const ShownSensor& sensor,
             const viewer::BeginCalibration& wish);
  Done end(const viewer::Page& page);
  // What the calibration before this made; takes a key of role admin.
  Done install(const viewer::Page& page, const ShownSensor& sensor);

 private:
  struct Run;
  Task::End run(const Run& what);
  Task::End calibrate(const Run& what);
  Task::End put(const ShownSensor& sensor, const std::filesystem::path& file);
  std::vector<std::string> words(const Run& what) const;
  void take(const std::string& line);
  bool goes_on(const Run& what) const;

  const CalibrationOptions options_;
  viewer::Page owner_;  // who began the last one
  Task task_;           // last: its thread uses what stands above
};

}  // namespace stof::host
