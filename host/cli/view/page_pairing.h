#pragma once

#include <condition_variable>
#include <cstdint>
#include <expected>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "host/cli/config/config.h"
#include "host/cli/view/page_settings.h"
#include "host/viewer/page_message.h"
#include "host/viewer/panel_messages.h"

namespace stof::host {

// The pairing panel of the page: what `stof pair` does, a step of it at a time; the key goes into
// the user's file, and never to a page. As there, the digits of here are told only once somebody
// has given those of the sensor: who only has to say yes says it too soon. For any thread; none of
// it waits but the destructor.
class PagePairing {
 public:
  using Tell = std::function<void(const viewer::PairingState& state)>;

  // takes_code: that of the label, which opens the sensor for good: never over a network that
  // others read.
  PagePairing(ConfigOptions config, bool takes_code, Tell tell);
  ~PagePairing();  // gives up what is under way, and waits for that
  PagePairing(const PagePairing&) = delete;
  PagePairing& operator=(const PagePairing&) = delete;

  // One line: why not.
  using Done = std::expected<void, std::string>;
  Done begin(const ShownSensor& sensor, const viewer::BeginPairing& wish);
  Done give(const std::string& digits);
  Done give_up();

  // Looks whether there is a key for it, in the user's file; tells where that is news. Reads a
  // file.
  void look(const ShownSensor& sensor);

 private:
  void run(const std::string& sensor, const viewer::BeginPairing& wish);
  std::string pair(const std::string& sensor, const viewer::BeginPairing& wish);
  std::string await_digits();
  bool goes_on() const;
  template <typename Change>
  void change(Change&& how);

  const ConfigOptions config_;
  const Tell tell_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  viewer::PairingState state_;
  bool told_ = false;
  bool under_way_ = false;
  bool ends_ = false;
  std::optional<std::string> digits_;
  std::thread thread_;
};

}  // namespace stof::host
