#pragma once

#include <optional>
#include <string>

#include "host/cli/config/config.h"
#include "host/cli/view/page_settings.h"
#include "host/cli/view/page_task.h"
#include "host/viewer/page_message.h"
#include "host/viewer/panel_messages.h"
#include "host/viewer/requests.h"

namespace stof::host {

// The pairing panel of the page: what `stof pair` does, a step of it at a time; the key goes into
// the user's file, and never to a page. As there, the digits of here are told only once somebody
// has given those of the sensor: who only has to say yes says it too soon. A pairing is that of the
// page which began it: it alone gives the digits or ends it, and its connection's end ends it too.
// For any thread; none of it waits but the destructor.
class PagePairing {
 public:
  using Task = PageTask<viewer::PairingState>;
  using Done = Task::Done;

  PagePairing(ConfigOptions config, Task::Tell tell);

  Done begin(const viewer::Page& page, const ShownSensor& sensor, const viewer::BeginPairing& wish);
  Done give(const viewer::Page& page, const std::string& digits);
  Done give_up(const viewer::Page& page);

  // Looks whether there is a key for it, in the user's file; tells where that is news. Reads a
  // file. Of one thread.
  void look(const ShownSensor& sensor);

 private:
  Task::End run(const viewer::Page& page, const std::string& sensor,
                const viewer::BeginPairing& wish);
  std::string pair(const viewer::Page& page, const std::string& sensor,
                   const viewer::BeginPairing& wish);
  std::string await_digits(const viewer::Page& page);
  bool goes_on(const viewer::Page& page) const;

  const ConfigOptions config_;
  std::optional<std::string> offer_;  // that was told last; none: none was
  Task task_;                         // last: its thread uses what stands above
};

}  // namespace stof::host
