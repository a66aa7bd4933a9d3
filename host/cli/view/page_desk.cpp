#include "host/cli/view/page_desk.h"

#include <exception>
#include <variant>

#include "host/cli/failure.h"
#include "host/cli/fault.h"

namespace stof::host {
namespace {

constexpr const char* kBusy = "what was asked before is not done: wait a moment";

template <typename... Kinds>
bool is_one_of(const viewer::Wish& wish) {
  return (std::holds_alternative<Kinds>(wish) || ...);
}

std::vector<viewer::FaultState> states_of(const std::vector<DeviceFaults>& devices) {
  std::vector<viewer::FaultState> states;
  for (const DeviceFaults& one : devices) {
    const bool counts = !one.edges.empty() && one.edges.size() <= 10 &&
                        one.edges.find_first_not_of("0123456789") == std::string::npos;
    states.push_back({.device = one.device,
                      .now = one.now,
                      .edges = counts ? std::stoull(one.edges) : 0,
                      .kinds = one.kinds});
  }
  return states;
}

}  // namespace

PageDesk::PageDesk(DeskOptions options)
    : options_(std::move(options)),
      pairing_(options_.config,
               [this](const viewer::PairingState& state) {
                 tell(viewer::Topic::kPairing, viewer::pairing_message(state));
               }),
      update_(options_.config, options_.update_from,
              [this](const viewer::UpdateState& state) {
                tell(viewer::Topic::kUpdate, viewer::update_message(state));
              }),
      thread_([this] { run(); }) {}

PageDesk::~PageDesk() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void PageDesk::run() {
  while (true) {
    Job job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
      if (stop_) {
        return;
      }
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    job();
  }
}

bool PageDesk::enqueue(Job job) {
  {
    const std::scoped_lock lock(mutex_);
    if (jobs_.size() == kMostJobs) {
      return false;
    }
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
  return true;
}

void PageDesk::serve(const viewer::Page& page, viewer::Wish wish, viewer::Answer answer) {
  if (is_one_of<viewer::SetRecording, viewer::SetPlaying, viewer::SeekTo>(wish)) {
    const std::scoped_lock lock(mutex_);
    if (own_.size() < kMostJobs) {
      own_.emplace_back(std::move(wish), std::move(answer));
      return;
    }
  } else if (!options_.sensor) {
    answer(false, "this is a recording: there is no sensor to change");
    return;
  } else if (const auto* const fault = std::get_if<viewer::GiveFault>(&wish)) {
    if (options_.fault_socket.empty()) {
      answer(false, "only an emulated sensor fails on demand: stofd --fault-socket PATH");
      return;
    }
    if (enqueue([this, given = fault->order, answer] {
          try {
            order(given);
            answer(true, "");
          } catch (const std::exception& problem) {
            answer(false, problem.what());
          }
        })) {
      return;
    }
  } else if (is_one_of<viewer::ReadSettings, viewer::ChangeSettings, viewer::SaveSettings>(wish)) {
    if (enqueue([this, wish, answer] { do_settings(wish, answer); })) {
      return;
    }
  } else if (enqueue([this, page, wish, answer] { do_others(page, wish, answer); })) {
    return;
  }
  answer(false, kBusy);
}

void PageDesk::order(const std::string& order) {
  tell(viewer::Topic::kFaults,
       viewer::faults_message(states_of(order_fault(options_.fault_socket, order)), ""));
}

void PageDesk::do_settings(const viewer::Wish& wish, const viewer::Answer& answer) {
  const ShownSensor shown = sensor();
  std::string said;
  bool done = true;
  try {
    if (const auto* const change = std::get_if<viewer::ChangeSettings>(&wish)) {
      said = change_settings(shown, options_.config, change->assignments);
    } else if (std::holds_alternative<viewer::SaveSettings>(wish)) {
      said = save_settings(shown, options_.config);
    }
  } catch (const std::exception& problem) {
    done = false;
    said = problem.what();
  }
  // First: the answer is about what there is now.
  const viewer::SettingsState state = read_settings(shown, options_.config);
  tell(viewer::Topic::kSettings, viewer::settings_message(state));
  answer(done, said);
}

// What has its own thread, and its own message of how it goes.
void PageDesk::do_others(const viewer::Page& page, const viewer::Wish& wish,
                         const viewer::Answer& answer) {
  std::expected<void, std::string> done;
  if (const auto* const begin = std::get_if<viewer::BeginPairing>(&wish)) {
    done = pairing_.begin(page, sensor(), *begin);
  } else if (const auto* const given = std::get_if<viewer::GiveDigits>(&wish)) {
    done = pairing_.give(page, given->digits);
  } else if (std::holds_alternative<viewer::EndPairing>(wish)) {
    done = pairing_.give_up(page);
  } else if (const auto* const release = std::get_if<viewer::PutRelease>(&wish)) {
    done = update_.put(page, sensor(), release->file);
  } else {
    update_.read(sensor());
  }
  answer(done.has_value(), done ? std::string() : done.error());
}

// among_jobs: it is already; guarded by the mutex.
void PageDesk::look_once(bool& among_jobs, Job job) {
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(among_jobs, true)) {
      return;
    }
  }
  const bool queued = enqueue([this, &among_jobs, look = std::move(job)] {
    {
      const std::scoped_lock lock(mutex_);
      among_jobs = false;
    }
    look();
  });
  if (!queued) {
    const std::scoped_lock lock(mutex_);
    among_jobs = false;
  }
}

void PageDesk::look_at_faults() {
  if (options_.fault_socket.empty()) {
    return;
  }
  look_once(looks_at_faults_, [this] {
    try {
      order("list");
    } catch (const std::exception& problem) {
      tell(viewer::Topic::kFaults, viewer::faults_message({}, problem.what()));
    }
  });
}

void PageDesk::look_at_keys() {
  look_once(looks_at_keys_, [this] { pairing_.look(sensor()); });
}

void PageDesk::tell_by(Tell tell) {
  const std::scoped_lock lock(mutex_);
  tell_ = std::move(tell);
}

void PageDesk::tell(viewer::Topic topic, std::string json) {
  const std::scoped_lock lock(mutex_);
  if (tell_) {
    tell_(topic, std::move(json));
  }
}

void PageDesk::know(const ShownSensor& sensor) {
  const std::scoped_lock lock(mutex_);
  sensor_ = sensor;
}

ShownSensor PageDesk::sensor() const {
  const std::scoped_lock lock(mutex_);
  return sensor_;
}

std::optional<PageDesk::Own> PageDesk::take_own() {
  const std::scoped_lock lock(mutex_);
  if (own_.empty()) {
    return std::nullopt;
  }
  std::optional<Own> first(std::move(own_.front()));
  own_.pop_front();
  return first;
}

}  // namespace stof::host
