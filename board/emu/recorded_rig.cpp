#include "board/emu/recorded_rig.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "board/emu/recorded_depth.h"
#include "firmware/wire/calibration/calibration_file.h"
#include "firmware/wire/frame/raw_packets.h"

namespace stof::board {
namespace {

using recording::RawInput;

hal::Time time_of(std::int64_t ns) noexcept { return hal::Time(hal::Duration(ns)); }

hal::Exposure exposure_of(const wire::Window& window) noexcept {
  return {time_of(window.begin_ns), time_of(window.end_ns)};
}

template <typename T>
dsp::ImageView<const T> view_of(const std::vector<T>& pixels, int width, int height) noexcept {
  return {pixels.data(), width, height};
}

bool has_pair(const RawInput& input) noexcept {
  return !input.left.empty() && !input.right.empty();
}
bool has_samples(const RawInput& input) noexcept { return !input.pmd.front().empty(); }

std::string counted(std::uint64_t count, const char* what) {
  return std::to_string(count) + " " + what;
}

}  // namespace

std::optional<int> RecordedRig::Lent::lend(const Input& input) noexcept {
  const auto free = std::ranges::find(slots_, nullptr);
  if (free == slots_.end()) {
    return std::nullopt;
  }
  *free = input;
  return static_cast<int>(free - slots_.begin());
}

Result<hal::BorrowedFrame<hal::StereoFrame>> RecordedRig::Stereo::wait_frame(
    hal::Time deadline) noexcept {
  const bool there = !std::exchange(taken, true) && has_pair(*rig_.now_);
  const std::optional<int> slot = there ? lent_.lend(rig_.now_) : std::nullopt;
  if (!slot) {
    rig_.clock_.wait_until(deadline);
    return fail(Status::kTimeout);
  }
  const RawInput& input = *rig_.now_;
  const wire::RawInfo& info = input.info;
  const hal::StereoFrame frame{.left = view_of(input.left, info.width, info.height),
                               .right = view_of(input.right, info.width, info.height),
                               .left_exposure = exposure_of(info.pair_exposures[0]),
                               .right_exposure = exposure_of(info.pair_exposures[1]),
                               .left_sequence = info.sequences[0],
                               .right_sequence = info.sequences[1]};
  return hal::BorrowedFrame<hal::StereoFrame>(frame, lent_, *slot);
}

Result<hal::BorrowedFrame<hal::PmdFrame>> RecordedRig::Pmd::wait_frame(
    hal::Time deadline) noexcept {
  const bool there = !std::exchange(taken, true) && has_samples(*rig_.now_);
  const std::optional<int> slot = there ? lent_.lend(rig_.now_) : std::nullopt;
  if (!slot) {
    rig_.clock_.wait_until(deadline);
    return fail(Status::kTimeout);
  }
  const RawInput& input = *rig_.now_;
  hal::PmdFrame frame{.samples = {}, .exposures = {}, .sequence = input.info.sequences[2]};
  for (std::size_t k = 0; k < frame.samples.size(); ++k) {
    frame.samples[k] = view_of(input.pmd[k], input.info.pmd_width, input.info.pmd_height);
    frame.exposures[k] = exposure_of(input.info.pmd_exposures[k]);
  }
  return hal::BorrowedFrame<hal::PmdFrame>(frame, lent_, *slot);
}

std::expected<std::unique_ptr<RecordedRig>, std::string> RecordedRig::open(
    const std::filesystem::path& file, bool paced) {
  auto reader = recording::RawReader::open(file);
  if (!reader) {
    return std::unexpected("--replay: " + reader.error().message);
  }
  const std::string& bytes = reader->summary().calibration;
  const auto calibration_file = std::as_bytes(std::span(bytes));
  std::vector<std::int16_t> pattern(bytes.size());
  const auto calibration = wire::decode_calibration_file(calibration_file, pattern);
  if (!calibration) {
    return std::unexpected("--replay: " + file.string() +
                           ": its calibration file is damaged, or of a later version");
  }
  std::unique_ptr<RecordedRig> rig(new RecordedRig(std::move(*reader), *calibration, paced));
  rig->pattern_ = std::move(pattern);  // the calibration refers to its memory, which stays
  return rig;
}

RecordedRig::RecordedRig(recording::RawReader&& reader, const dsp::Calibration& calibration,
                         bool paced)
    : reader_(std::move(reader)),
      calibration_(calibration),
      clock_(time_of(reader_.summary().first.edge_ns), paced) {
  next_ = read();  // which counts: all members are there
}

RecordedRig::~RecordedRig() = default;

std::vector<std::string> RecordedRig::notes() const {
  const recording::RawSummary& summary = reader_.summary();
  std::vector<std::string> notes{"replay of " + counted(summary.exposures, "exposures of sensor ") +
                                 std::to_string(summary.origin.device_id) + ", session " +
                                 std::to_string(summary.origin.session_id) +
                                 ": nothing of it is new, its clock is the past"};
  if (summary.other_sessions != 0) {
    notes.push_back("the sensor started again: " +
                    counted(summary.other_sessions, "exposures behind that are not replayed"));
  }
  return notes;
}

RecordedRig::Input RecordedRig::read() {
  std::unique_ptr<RawInput> input = reader_.next();
  if (input) {
    count_input(*input);
  }
  return input;
}

void RecordedRig::count_input(const RawInput& input) {
  counts_.missing += input.missing != 0 ? 1U : 0U;
  const wire::RawInfo& info = input.info;
  // A subscription that began anew counts from 1. An exposure that was begun and given up counts as
  // dropped, too: what was never received is no more than the frames between two exposures.
  if (before_ && info.number > before_->number && info.dropped >= before_->dropped) {
    const std::uint64_t told =
        std::uint64_t{info.number} - before_->number - 1 + (info.dropped - before_->dropped);
    const std::uint32_t frames = input.stamp.number - frame_before_;
    counts_.unsent += frames == 0 ? told : std::min<std::uint64_t>(told, frames - 1);
  }
  before_ = info;
  frame_before_ = input.stamp.number;
}

Result<hal::Time> RecordedRig::pulse() noexcept {
  if (!next_) {
    return fail(Status::kDeviceError);
  }
  counts_.failures += awaiting_ ? 1U : 0U;
  now_ = std::exchange(next_, read());
  changed_ = false;
  awaiting_ = true;
  stereo_.taken = false;
  pmd_.taken = false;
  const hal::Time edge = time_of(now_->info.edge_ns);
  clock_.wait_until(edge);
  return edge;
}

std::optional<hal::Time> RecordedRig::next_edge() noexcept {
  return next_ ? std::optional(time_of(next_->info.edge_ns)) : std::nullopt;
}

Replay::Change RecordedRig::take_change() {
  Change change;
  if (!next_ || std::exchange(changed_, true)) {
    return change;
  }
  change.begins_anew = (next_->info.state & wire::kRawBegunAnew) != 0;
  const bool told = next_->frame && next_->frame->info;
  if (!told) {
    return change;
  }
  const wire::FrameInfo& info = *next_->frame->info;
  if (info.settings_fingerprint != 0 && info.settings_fingerprint != settings_) {
    settings_ = info.settings_fingerprint;
    const auto& known = reader_.summary().settings;
    if (const auto found = known.find(settings_); found != known.end()) {
      change.settings = found->second;
    }
  }
  return change;
}

bool RecordedRig::forgets_past() noexcept {
  return now_ && (now_->info.state & wire::kRawForgotPast) != 0;
}

void RecordedRig::computed(hal::Time edge, const dsp::DepthMap& map) noexcept {
  if (!now_ || edge != time_of(now_->info.edge_ns)) {
    return;
  }
  awaiting_ = false;
  const recording::RecordedFrame* const frame = now_->frame ? &*now_->frame : nullptr;
  if (frame == nullptr || !comparable(*frame)) {
    ++counts_.not_compared;
  } else if (!reader_.summary().settings.contains(frame->info->settings_fingerprint)) {
    ++counts_.unknown_settings;
  } else if (frame->info->calibration_fingerprint !=
             wire::calibration_fingerprint(
                 std::as_bytes(std::span(reader_.summary().calibration)))) {
    ++counts_.other_calibration;
  } else if (equals_recorded(map, sent_, *frame)) {
    ++counts_.equal;
  } else {
    ++counts_.different;
    counts_.first_different = counts_.first_different.value_or(frame->stamp.number);
  }
}

TimingConfig RecordedRig::timing(const TimingConfig& own) const noexcept {
  const recording::RawSummary& summary = reader_.summary();
  TimingConfig timing = own;
  if (summary.packet && summary.packet->period_ns > 0) {
    timing.period = hal::Duration(static_cast<std::int64_t>(summary.packet->period_ns));
  }
  const auto take = [](std::int64_t ns, hal::Duration& to) {
    to = ns > 0 ? hal::Duration(ns) : to;
  };
  take(summary.pair_exposure_ns, timing.stereo_exposure);
  take(summary.pmd_exposure_ns, timing.pmd_integration);
  timing.edge_tolerance = std::max(timing.edge_tolerance, hal::Duration(summary.from_edge_ns));
  timing.pmd_every = std::max(int{summary.first.pmd_every}, 1);
  return timing;
}

const std::string& RecordedRig::settings() const noexcept {
  return reader_.summary().first_settings;
}

Replay::Verdict RecordedRig::verdict() const {
  Verdict verdict;
  const std::uint64_t failures = counts_.failures + (awaiting_ ? 1U : 0U);
  verdict.lines.push_back("replay: " + counted(counts_.equal, "frames equal the recorded depth, ") +
                          counted(counts_.different, "differ") +
                          (counts_.first_different
                               ? ", the first is frame " + std::to_string(*counts_.first_different)
                               : std::string()));
  const auto say = [&](std::uint64_t count, const char* what) {
    if (count != 0) {
      verdict.lines.push_back("replay: " + counted(count, what));
    }
  };
  say(counts_.missing, "exposures miss a picture that was lost: it was missing here, too");
  say(counts_.unsent,
      reader_.damaged() == 0
          ? "exposures were never received: the sensor or the link had no time for them"
          : "exposures are not there: damaged records may have held them, or they were never "
            "received");
  say(failures, "exposures gave no frame");
  say(counts_.not_compared, "frames not compared: their recorded depth is missing or incomplete");
  say(counts_.unknown_settings,
      "frames not compared: the settings that they were made with are not in the recording");
  say(counts_.other_calibration,
      "frames not compared: made with a calibration that was installed meanwhile");
  const std::uint64_t behind = reader_.summary().other_sessions;
  say(behind, "exposures behind a restart of the sensor were not replayed");
  say(reader_.damaged(), "damaged records left out");
  verdict.equal = counts_.equal != 0 && counts_.different == 0 && counts_.missing == 0 &&
                  counts_.unsent == 0 && failures == 0 && counts_.not_compared == 0 &&
                  counts_.unknown_settings == 0 && counts_.other_calibration == 0 && behind == 0 &&
                  reader_.damaged() == 0;
  return verdict;
}

}  // namespace stof::board
