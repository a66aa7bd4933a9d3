#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "host/cli/config/config.h"
#include "host/cli/view/page_settings.h"
#include "host/viewer/panel_messages.h"

namespace stof::host {

// The update panel of the page: what `stof update` does, with the releases of one folder that the
// user named at the start. A page names a file of that folder and sends none: so nothing that a
// page says is ever written, the server takes no long request, and a release is what the user put
// there. For one thread, unless said otherwise; none of it waits for an update but the destructor,
// which leaves it.
class PageUpdate {
 public:
  using Tell = std::function<void(const viewer::UpdateState& state)>;  // for any thread

  PageUpdate(ConfigOptions config, std::filesystem::path folder, Tell tell);
  ~PageUpdate();
  PageUpdate(const PageUpdate&) = delete;
  PageUpdate& operator=(const PageUpdate&) = delete;

  // Tells the folder's releases and, but while an update is under way, what runs on the sensor,
  // whoever put it there; blocks as long as the answer takes.
  void read(const ShownSensor& sensor);
  // One line: why not.
  std::expected<void, std::string> put(const ShownSensor& sensor, const std::string& file);

 private:
  void run(const std::string& sensor, const std::filesystem::path& file);
  bool goes_on() const;
  template <typename Change>
  void change(Change&& how);

  const ConfigOptions config_;
  const std::filesystem::path folder_;
  const Tell tell_;
  mutable std::mutex mutex_;
  viewer::UpdateState state_;
  bool under_way_ = false;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace stof::host
