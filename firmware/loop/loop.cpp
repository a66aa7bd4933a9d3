#include "firmware/loop/loop.h"

#include <algorithm>
#include <utility>

#include "firmware/wire/frame/raw_packets.h"

namespace stof::firmware {
namespace {

// kDeviceLost where it is one of them, else kOk.
Status lost_or_ok(Status a, Status b) noexcept {
  return a == Status::kDeviceLost || b == Status::kDeviceLost ? Status::kDeviceLost : Status::kOk;
}

void count_stages(const Stats& stats, hal::Duration publish, Counters& counters) noexcept {
  counters.stage(Stage::kMatch).add(stats.match);
  counters.stage(Stage::kConvert).add(stats.convert);
  counters.stage(Stage::kFuse).add(stats.fuse);
  counters.stage(Stage::kPublish).add(publish);
}

}  // namespace

Loop::Loop(board::Board& board, const board::TimingConfig& timing, const Setup& setup,
           Pipeline& pipeline, Publisher& publisher, Events& events,
           DeviceLending* lending) noexcept
    : board_(board),
      pipeline_(pipeline),
      publisher_(publisher),
      lending_(lending),
      conditions_(board.clock, events, publisher.health()),
      schedule_(timing, board.pmd != nullptr, board.clock.now()),
      collector_(board, setup, conditions_, lending) {}

bool Loop::wait_part() noexcept {
  const hal::Time now = board_.clock.now();
  if (schedule_.next() - now <= 2 * kWaitPart) {
    return true;
  }
  publisher_.wait_until(now + kWaitPart);
  return false;
}

Status Loop::step() noexcept {
  const Status status = run_period();
  lend_devices();
  return status;
}

Status Loop::run_period() noexcept {
  follow_replay();
  wait_for_edge();
  const Result<hal::Time> edge = pulse();  // shot n begins to expose
  Status status = publish_waiting();       // shot n - 1, if it had to wait for its turn
  if (!edge) {
    return lost_or_ok(edge.error(), status);
  }
  status = lost_or_ok(status, collect(*edge));  // pairs stereo and PMD with this edge
  publisher_.report_events();                   // not after what is paced over the period
  // What is computed again is computed with what holds at its own edge.
  const bool in_time = schedule_.same_period() && board_.clock.now() < schedule_.next();
  if (in_time || board_.replay != nullptr) {
    status = lost_or_ok(status, publish_held(schedule_.send_deadline(), true));
  }
  return status;
}

void Loop::lend_devices() noexcept {
  if (lending_ == nullptr) {
    return;
  }
  const hal::Time now = board_.clock.now();
  const auto lend = [&](board::Device device, Component component, bool borrowed) {
    using Need = DeviceLending::Need;
    const Need other = conditions_.repeats(component) ? Need::kRepeats : Need::kNone;
    const Need need = conditions_.lost(component) ? Need::kLost : other;
    if (need != Need::kNone) {
      publisher_.give_back_raw(device == board::Device::kStereo, device == board::Device::kPmd);
    }
    if (lending_->after_round(device, need, borrowed, now) && need == Need::kRepeats) {
      collector_.expect_anew(device);
    }
  };
  lend(board::Device::kTrigger, Component::kTrigger, false);
  lend(board::Device::kStereo, Component::kStereo, held_ && held_->stereo);
  lend(board::Device::kPmd, Component::kPmd, collector_.holds_pmd() || (held_ && held_->pmd));
}

void Loop::note_begun_anew() noexcept {
  begun_anew_ = true;
  pipeline_.forget_match();
  collector_.forget_pmd();
  last_edge_.reset();
}

void Loop::restart(const board::TimingConfig& timing) noexcept {
  schedule_.restart(timing, board_.clock.now());
  pipeline_.forget_match();
  collector_.forget_pmd();
  last_edge_.reset();
}

void Loop::rest_part() noexcept {
  publisher_.give_back_raw(true, true);
  held_.reset();
  pipeline_.forget_match();
  collector_.forget_pmd();
  last_edge_.reset();
  publisher_.wait_until(board_.clock.now() + kWaitPart);
}

bool Loop::has_trouble() const noexcept {
  return conditions_.lost(Component::kTrigger) || conditions_.lost(Component::kStereo) ||
         conditions_.lost(Component::kPmd) || conditions_.repeats(Component::kStereo) ||
         conditions_.repeats(Component::kPmd);
}

// What frames cost is as it was: the first one need not wait for its turn.
void Loop::wake() noexcept { schedule_.follow(std::max(schedule_.next(), board_.clock.now())); }

// Edges of a recording are due when they were.
void Loop::follow_replay() noexcept {
  const std::optional<hal::Time> due =
      board_.replay == nullptr ? std::nullopt : board_.replay->next_edge();
  if (due) {
    schedule_.follow(*due);
  }
}

void Loop::wait_for_edge() noexcept {
  const hal::Time now = board_.clock.now();
  conditions_.note_lateness(schedule_.arrive(now), now);
  publisher_.wait_until(schedule_.next());
}

// The edge that went out, later than any before it; errors as Trigger::pulse.
Result<hal::Time> Loop::pulse() noexcept {
  const hal::Time planned = schedule_.advance();
  const bool usable = lending_ == nullptr || lending_->usable(board::Device::kTrigger);
  Result<hal::Time> edge = usable ? board_.trigger.pulse() : fail(Status::kDeviceLost);
  conditions_.note_device_status(Component::kTrigger, edge ? Status::kOk : edge.error());
  if (edge) {
    Counters& counters = conditions_.counters();
    ++counters.edges;
    const hal::Duration tolerance = schedule_.timing().edge_tolerance;
    if (*edge >= planned - tolerance && *edge <= board_.clock.now()) {
      counters.skipped_periods += schedule_.keep_distance(*edge);
      follow_replay();  // until then frames of this edge may come
      return edge;
    }
    // A time that cannot be: nobody knows what was exposed when.
    edge = fail(Status::kDeviceError);
    conditions_.note_device_status(Component::kTrigger, edge.error());
  }
  conditions_.note_no_frame(Component::kTrigger, edge.error());
  return edge;
}

Status Loop::publish_waiting() noexcept {
  if (!held_) {
    return Status::kOk;
  }
  if (!schedule_.same_period()) {
    return publish_held(schedule_.send_deadline(), true);
  }
  // Shot n shall be out in this period as well, so the packets of this one wait for nothing. What
  // it waited for was a sensor, unless that came.
  return publish_held(board_.clock.now(), is_whole(*held_));
}

Status Loop::publish_held(hal::Time latest, bool usual) noexcept {
  Counters& counters = conditions_.counters();
  if (!held_ || (most_frames_ != 0 && counters.published >= most_frames_)) {
    return Status::kOk;
  }
  Status sent = Status::kOk;
  if (schedule_.expired(held_->edge, board_.clock.now())) {
    ++counters.expired;
    collector_.forget_pmd();  // the pipeline has not seen its samples
  } else {
    note_gap(*held_);
    const Output& output = pipeline_.compute(*held_, board_.clock);
    const hal::Time computed = board_.clock.now();
    if (board_.replay != nullptr) {
      board_.replay->computed(held_->edge, output.map);
    }
    ++counters.published;
    counters.with_pair += held_->stereo ? 1U : 0U;
    counters.with_pmd += held_->pmd_exposed ? 1U : 0U;
    sent = publisher_.publish(*held_, output, latest);
    conditions_.note_link_status(sent);
    const hal::Duration published = board_.clock.now() - computed;
    pipeline_.watch(board_.clock);
    count_stages(output.stats, published, counters);
    if (usual && held_->stereo) {  // without a pair it costs less than usual
      update_schedule(output.stats, held_->edge);
    }
    publisher_.offer_raw(*held_, schedule_.next());
  }
  pipeline_.forget_match();
  held_.reset();  // its slots go home
  return sent;
}

bool Loop::is_whole(const Shot& shot) const noexcept {
  return shot.sensors() == (board_.pmd == nullptr ? kStereoSensor : kBothSensors);
}

void Loop::note_gap(Shot& shot) noexcept {
  if (std::exchange(begun_anew_, false)) {
    shot.state |= wire::kRawBegunAnew;
  }
  // A camera that was lost may expose otherwise than before, however soon it is back.
  const bool follows = last_edge_ && !schedule_.gap(*last_edge_, shot.edge) &&
                       shot.stereo_losses == stereo_losses_ && shot.sensors() == sensors_;
  if (board_.replay == nullptr ? !follows : board_.replay->forgets_past()) {
    shot.state |= wire::kRawForgotPast;
    pipeline_.forget_past();
  }
  last_edge_ = shot.edge;
  stereo_losses_ = shot.stereo_losses;
  sensors_ = shot.sensors();
}

void Loop::update_schedule(const Stats& stats, hal::Time edge) noexcept {
  const PublisherTimes& times = publisher_.times();
  schedule_.note_sent(edge,
                      {.search = stats.match,
                       .other = stats.convert + stats.fuse + stats.watch + times.code + times.send,
                       .paced = times.waited,
                       .search_first = pipeline_.may_match_first()},
                      board_.clock.now());
}

Status Loop::collect(hal::Time edge) noexcept {
  const hal::Time begin = board_.clock.now();
  const bool search_first = schedule_.same_period() && pipeline_.may_match_first();
  Collected collected = collector_.collect(edge, schedule_.frame_deadline(edge), schedule_.timing(),
                                           search_first ? &pipeline_ : nullptr);
  if (collected.shot) {
    if (is_whole(*collected.shot)) {  // else it waited for what did not come
      schedule_.note_fetch(edge, begin, board_.clock.now());
    }
    held_.emplace(std::move(*collected.shot));
  }
  return collected.lost ? Status::kDeviceLost : Status::kOk;
}

}  // namespace stof::firmware
