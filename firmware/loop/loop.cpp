#include "firmware/loop/loop.h"

#include <algorithm>
#include <utility>

#include "dsp/base/check.h"

namespace stof::firmware {
namespace {

// So many edges in a row without a frame are a state, fewer are an incident that is only counted.
constexpr std::uint32_t kSilentEdges = 3;
// The loop is in time again after so many edges in time.
constexpr std::uint32_t kInTimeEdges = 32;
// An edge that was late because of a prompt frame is forgotten after so many that were not.
constexpr int kOverrunWeight = 16;
constexpr hal::Duration kLeastPatience = std::chrono::seconds(2);
constexpr hal::Duration kMostPatience = std::chrono::minutes(1);
// A shot this many periods old is not news any more.
constexpr int kExpiredPeriods = 3;

void count_stages(const Stats& stats, hal::Duration publish, Counters& counters) noexcept {
  counters.stage(Stage::kMatch).add(stats.match);
  counters.stage(Stage::kConvert).add(stats.convert);
  counters.stage(Stage::kFuse).add(stats.fuse);
  counters.stage(Stage::kPublish).add(publish);
}

}  // namespace

const char* problem(const board::TimingConfig& timing) noexcept {
  if (timing.pmd_every < 1 || timing.pmd_every > kMaxPmdEvery) {
    return "the PMD camera must expose at every edge or at every k-th, k at most 8";
  }
  if (timing.edge_tolerance <= hal::Duration::zero() ||
      timing.period <= 16 * timing.edge_tolerance) {
    return "the period must be longer than 16 edge tolerances";
  }
  if (timing.period > std::chrono::minutes(1)) {
    return "the period must be at most a minute";
  }
  // Edges come 7/8 of a period apart at the nearest.
  const hal::Duration spacing = timing.period - timing.period / 8;
  if (spacing <= timing.stereo_exposure + timing.edge_tolerance) {
    return "7/8 of the period must be longer than the exposure of the stereo cameras";
  }
  if (timing.pmd_every * spacing <= timing.pmd_integration + timing.edge_tolerance) {
    return "7/8 of the period must be longer than the integration of the PMD camera";
  }
  return "";
}

Loop::Loop(board::Board& board, const board::TimingConfig& timing, const Setup& setup,
           Pipeline& pipeline, Stream& stream, Events& events) noexcept
    : board_(board),
      timing_(timing),
      pipeline_(pipeline),
      stream_(stream),
      events_(events),
      stereo_pairing_(setup.calibration.stereo.left.width, setup.calibration.stereo.left.height),
      pmd_pairing_(setup.calibration.pmd.lens.width, setup.calibration.pmd.lens.height),
      next_(board.clock.now()),
      edges_in_time_(kInTimeEdges) {
  STOF_CHECK(*problem(timing) == '\0');
}

Status Loop::step() noexcept {
  wait_for_grid();
  const Result<hal::Time> edge = pulse();  // shot n begins to expose
  Status sent = publish_held();            // shot n - 1, if it had to wait for its turn
  if (!edge) {
    return first_lost(edge.error(), sent) == Status::kDeviceLost ? Status::kDeviceLost
                                                                 : Status::kOk;
  }
  const Status collected = collect(*edge);  // pairs stereo and PMD with this edge
  if (prompt_) {
    sent = first_lost(sent, publish_held());
  }
  return first_lost(sent, collected);
}

void Loop::restart(const board::TimingConfig& timing) noexcept {
  STOF_CHECK(*problem(timing) == '\0');
  timing_ = timing;
  next_ = std::max(next_, board_.clock.now());
  prompt_ = false;
  prompt_again_ = {};
  patience_ = {};
  fetch_cost_ = {};
  search_cost_ = {};
  other_cost_ = {};
  pipeline_.forget_match();
}

void Loop::wait_for_grid() noexcept {
  Counters& counters = events_.counters;
  const hal::Time now = board_.clock.now();
  const hal::Duration late = now - next_;
  if (late > timing_.period / 8) {
    const auto skipped = (late + timing_.period - hal::Duration(1)) / timing_.period;
    next_ += skipped * timing_.period;
    counters.skipped_periods += static_cast<std::uint64_t>(skipped);
    if (std::exchange(edges_in_time_, 0) >= kInTimeEdges) {
      note({now, EventKind::kLate, Part::kLoop, Status::kTimeout,
            static_cast<std::uint32_t>(skipped)});
    }
  } else {
    if (edges_in_time_ < kInTimeEdges && ++edges_in_time_ == kInTimeEdges) {
      note({now, EventKind::kInTime, Part::kLoop, Status::kOk, 0});
    }
    counters.late_edges += late > timing_.edge_tolerance ? 1U : 0U;
  }
  board_.clock.wait_until(next_);
}

// The edge that went out, later than any before it; errors as Trigger::pulse.
Result<hal::Time> Loop::pulse() noexcept {
  const hal::Time planned = std::exchange(next_, next_ + timing_.period);
  Result<hal::Time> edge = board_.trigger.pulse();
  heard(Part::kTrigger, edge ? Status::kOk : edge.error());
  if (!edge) {
    paired(false, Part::kTrigger, edge.error());
    return edge;
  }
  ++events_.counters.edges;
  // A time that cannot be: nobody knows what was exposed when.
  if (*edge < planned - timing_.edge_tolerance || *edge > board_.clock.now()) {
    heard(Part::kTrigger, Status::kDeviceError);
    paired(false, Part::kTrigger, Status::kDeviceError);
    return fail(Status::kDeviceError);
  }
  while (next_ - *edge < timing_.period - timing_.period / 8) {
    next_ += timing_.period;
    ++events_.counters.skipped_periods;
  }
  return edge;
}

Status Loop::publish_held() noexcept {
  if (!held_) {
    return Status::kOk;
  }
  Status sent = Status::kOk;
  if (board_.clock.now() - held_->edge > kExpiredPeriods * timing_.period) {
    ++events_.counters.expired;
  } else {
    const Output& output = pipeline_.compute(*held_);
    const hal::Time computed = board_.clock.now();
    ++events_.counters.published;
    // Done well before the next edge, for a thread that wakes up late.
    sent = stream_.publish(*held_, output, next_ - timing_.period / 8);
    link_answered(sent);
    const hal::Duration published = board_.clock.now() - computed;
    pipeline_.watch();
    count_stages(output.stats, published, events_.counters);
    learn(output.stats, held_->edge);
  }
  pipeline_.forget_match();
  held_.reset();  // its slots go home
  return sent;
}

void Loop::learn(const Stats& stats, hal::Time edge) noexcept {
  const StreamTimes& stream = stream_.times();
  follow(search_cost_, stats.match);
  follow(other_cost_, stats.convert + stats.fuse + stats.watch + stream.code + stream.send);
  const hal::Time now = board_.clock.now();
  if (!prompt_) {
    const bool overlaps = pipeline_.may_match_first();
    hal::Duration collected =
        timing_.stereo_exposure + fetch_cost_ + (overlaps ? search_cost_ : hal::Duration{});
    if (board_.pmd != nullptr) {
      collected = std::max(collected, timing_.pmd_integration);
    }
    collected += overlaps ? hal::Duration{} : search_cost_;
    prompt_ = collected + other_cost_ <= timing_.period * 15 / 16 && now >= prompt_again_;
    overruns_ = 0;
    return;
  }
  const bool overrun = now - stream.waited - edge > timing_.period;
  overruns_ = overrun ? overruns_ + kOverrunWeight : std::max(0, overruns_ - 1);
  if (overruns_ >= 3 * kOverrunWeight) {
    prompt_ = false;
    patience_ = std::clamp(2 * patience_, kLeastPatience, kMostPatience);
    prompt_again_ = now + patience_;
  } else if (now - prompt_again_ > kMostPatience) {
    patience_ = {};
  }
}

void Loop::note(const Event& event) noexcept {
  events_.note(event);
  stream_.observe(event);
}

void Loop::heard(Part part, Status status) noexcept {
  const auto at = static_cast<std::size_t>(part);
  const bool lost = status == Status::kDeviceLost;
  if (lost != std::exchange(lost_[at], lost)) {
    note({board_.clock.now(), lost ? EventKind::kLost : EventKind::kBack, part, status, 0});
  }
  if (lost) {
    ++events_.counters.losses[at];
    if (part == Part::kStereo) {
      stereo_pairing_.forget();
    } else if (part == Part::kPmd) {
      pmd_pairing_.forget();
    }
  } else if (status == Status::kTimeout) {
    ++events_.counters.timeouts[at];
  } else if (status != Status::kOk) {
    ++events_.counters.errors[at];
  }
}

void Loop::link_answered(Status status) noexcept {
  heard(Part::kLink,
        status == Status::kWouldBlock ? Status::kOk : status);  // the stream counts drops
  const bool unreachable = status == Status::kDeviceError;
  if (unreachable != std::exchange(unreachable_, unreachable)) {
    note({board_.clock.now(), unreachable ? EventKind::kSendFailed : EventKind::kSending,
          Part::kLink, status, 0});
  }
}

void Loop::paired(bool success, Part missing, Status why) noexcept {
  if (success) {
    if (!std::exchange(publishing_, true)) {
      note({board_.clock.now(), EventKind::kPublishing, Part::kLoop, Status::kOk, silent_edges_});
    }
    silent_edges_ = 0;
    return;
  }
  ++events_.counters.unpaired_edges;
  ++silent_edges_;
  if (silent_edges_ == kSilentEdges) {
    publishing_ = false;
    note({board_.clock.now(), EventKind::kUnpaired, missing, why, silent_edges_});
  }
}

}  // namespace stof::firmware
