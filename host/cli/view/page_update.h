#pragma once

#include <filesystem>
#include <string>

#include "host/cli/config/config.h"
#include "host/cli/view/page_settings.h"
#include "host/cli/view/page_task.h"
#include "host/viewer/panel_messages.h"
#include "host/viewer/requests.h"

namespace stof::host {

// The update panel of the page: what `stof update` does, with the releases of one folder that the
// user named at the start. A page names a file of that folder and sends none: so nothing that a
// page says is ever written, the server takes no long request, and a release is what the user put
// there. An update that has begun no page ends: it outlives the one that began it. For one thread;
// none of it waits for an update but the destructor, which leaves it.
class PageUpdate {
 public:
  using Task = PageTask<viewer::UpdateState>;

  PageUpdate(ConfigOptions config, std::filesystem::path folder, Task::Tell tell);

  // Tells the folder's releases and, but while an update is under way, what runs on the sensor,
  // whoever put it there; blocks as long as the answer takes.
  void read(const ShownSensor& sensor);
  Task::Done put(const viewer::Page& page, const ShownSensor& sensor, const std::string& file);

 private:
  Task::End run(const std::string& sensor, const std::filesystem::path& file);

  const ConfigOptions config_;
  const std::filesystem::path folder_;
  Task task_;  // last: its thread uses what stands above
};

}  // namespace stof::host
