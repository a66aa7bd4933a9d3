#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "host/cli/config/config.h"
#include "host/cli/view/page_pairing.h"
#include "host/cli/view/page_settings.h"
#include "host/cli/view/page_update.h"
#include "host/viewer/broadcast.h"

namespace stof::host {

struct DeskOptions {
  ConfigOptions config{};               // keys, and which sensor is meant
  std::string fault_socket{};           // of an emulated sensor; empty: it cannot be made to fail
  std::filesystem::path update_from{};  // folder of releases; empty: the page puts none
  bool sensor = true;                   // false: what is shown is a recording, which nobody changes
};

// Has done what pages want: what blocks, by a thread of its own, one after the other; what is the
// receiver's to do, it keeps for him.
class PageDesk {
 public:
  // tell: what the panels show; for any thread, and for as long as this lives.
  using Tell = std::function<void(viewer::Topic topic, std::string json)>;

  explicit PageDesk(DeskOptions options);
  ~PageDesk();  // waits for the answer that is awaited
  PageDesk(const PageDesk&) = delete;
  PageDesk& operator=(const PageDesk&) = delete;

  // Of the server's thread. Never waits.
  void serve(const viewer::Page& page, viewer::Wish wish, viewer::Answer answer);

  // Of the receiver's thread.
  void tell_by(Tell tell);
  void know(const ShownSensor& sensor);
  void look_at_faults();  // tells them, soon
  void look_at_keys();    // tells whether there is one of the sensor, soon
  using Own = std::pair<viewer::Wish, viewer::Answer>;
  std::optional<Own> take_own();  // recording and playback

 private:
  using Job = std::function<void()>;
  static constexpr std::size_t kMostJobs = 16;

  bool enqueue(Job job);
  void run();
  void order(const std::string& order);  // throws Failure
  void do_settings(const viewer::Wish& wish, const viewer::Answer& answer);
  void do_others(const viewer::Page& page, const viewer::Wish& wish, const viewer::Answer& answer);
  void look_once(bool& among_jobs, Job job);
  void tell(viewer::Topic topic, std::string json);
  ShownSensor sensor() const;

  const DeskOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  Tell tell_;
  ShownSensor sensor_;
  std::deque<Job> jobs_;
  std::deque<Own> own_;
  bool looks_at_faults_ = false;  // it is among the jobs
  bool looks_at_keys_ = false;    // likewise
  bool stop_ = false;
  PagePairing pairing_;
  PageUpdate update_;
  std::thread thread_;  // last: it uses what stands above
};

}  // namespace stof::host
