#include "firmware/update/updater.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::update {

using settings::PagedWriter;

namespace {

constexpr hal::Duration kBefore = std::chrono::seconds(10);

// Of a sensor that publishes seldom three periods count.
hal::Duration before_of(hal::Duration period) noexcept {
  return std::max(kBefore, Trial::gap_of(period));
}

wire::SettingsResult worn(PagedWriter& why) noexcept {
  why << "update: the card takes no writes any more, or gives back other bytes; the running "
         "release "
         "stays: use another card";
  return wire::SettingsResult::kNotSaved;
}

wire::SettingsResult writing(PagedWriter& why) noexcept {
  why << "update: the card is still writing: repeat it";
  return wire::SettingsResult::kBusy;
}

}  // namespace

Updater::Updater(const UpdaterSetup& setup) : setup_(setup) {
  if (setup_.slots == nullptr) {
    return;
  }
  writer_.emplace(*setup_.slots);
  sector_ = BootSector::find(*setup_.slots);
  const std::size_t chunks = (room_of_slot() + kChunkBytes - 1) / kChunkBytes;
  hashes_.resize(std::min(chunks, kMostChunks) * kHashBytes);
  running_ = load_record(setup_.running);
  const Record beside = load_record(other(setup_.running));
  other_ = beside.release ? fingerprint_of(beside.bytes) : 0;
  if (sector_ && on_trial(sector_->choice(), setup_.running)) {
    trial_.emplace(running_.before.value_or(kRoundsAlone | 2U));
    outcome_ = {.what = TrialOutcome::What::kRuns, .release = fingerprint_of(running_.bytes)};
  } else if (other_ != 0 && beside.trial > running_.trial) {
    outcome_ = {.what = TrialOutcome::What::kLeft, .release = other_};
  }
}

std::size_t Updater::room_of_slot() const noexcept {
  const std::size_t bytes = setup_.slots->bytes(part_of(other(setup_.running)));
  return bytes - std::min(bytes, kRecordBytes);
}

Record Updater::load_record(Slot slot) const noexcept {
  const hal::DiskPart part = part_of(slot);
  const std::size_t bytes = setup_.slots->bytes(part);
  RecordBytes record{};
  if (bytes < kRecordBytes ||
      setup_.slots->read(part, bytes - kRecordBytes, record) != Status::kOk) {
    return {};
  }
  return read_record(record);
}

std::string_view Updater::version() const noexcept {
  return running_.release ? text_of(running_.release->version) : std::string_view();
}

upload::Versions Updater::versions() const noexcept {
  upload::Versions versions{.in_force = running_.release ? fingerprint_of(running_.bytes) : 0,
                            .former = other_};
  if (wish_ != Restart::kNone) {
    versions.state = wire::UploadState::kRestarting;
  } else if (trial_) {
    versions.state = wire::UploadState::kOnTrial;
  } else if (outcome_.what == TrialOutcome::What::kLeft) {
    versions.state = wire::UploadState::kLeft;
  }
  return versions;
}

Updater::Result Updater::may_begin(PagedWriter& why) noexcept {
  why << "update: ";
  if (setup_.slots == nullptr) {
    why << "this sensor runs from no image of scripts/image: install the program as it was "
           "installed";
  } else if (setup_.keys.empty()) {
    why << "this sensor knows no maker's key: write the card again";
  } else if (!sector_ || room_of_slot() == 0) {
    why << "there is no autoboot.txt or no other slot on this card: write the card again";
  } else if (setup_.old_loader) {
    why << "the boot loader in this board's EEPROM is too old to start the other slot on trial: "
           "update it (sudo rpi-eeprom-update -a, on a card with Raspberry Pi OS)";
  } else if (!setup_.can_try) {
    why << "this board's kernel cannot start the other slot on trial: write the card again, with "
           "Raspberry Pi's kernel";
  } else if (trial_) {
    why << "the running release is on trial, half a minute of frames confirms it: try again then";
  } else if (wish_ != Restart::kNone) {
    why << "the sensor restarts: try again in a minute";
  } else {
    return Result::kOk;
  }
  return Result::kNotSaved;
}

Updater::Result Updater::begin(std::uint32_t total, PagedWriter& why) noexcept {
  if (const Result result = may_begin(why); result != Result::kOk) {
    return result;
  }
  const std::size_t least = kReleaseBytes + kHashBytes + 1;
  const std::size_t most = kReleaseBytes + hashes_.size() + room_of_slot();
  if (total < least || total > most) {
    why << "takes files of " << least << " to " << most << " bytes, not of " << total
        << ": is it an update file of this board?";
    return Result::kInvalid;
  }
  if (keeping_ != Keeping::kNot || writer_->pump() == Status::kTimeout) {
    return writing(why);
  }
  place_ = Place::kHead;
  release_.reset();
  total_ = total;
  filled_ = 0;
  chunk_ = 0;
  return Result::kOk;
}

std::span<std::byte> Updater::place() noexcept {
  switch (place_) {
    case Place::kHead:
      return head_;
    case Place::kHashes:
      return std::span(hashes_).first(release_->chunks() * kHashBytes);
    case Place::kChunks:
      return writer_->room().first(chunk_bytes());
    case Place::kEnd:
      break;
  }
  return {};
}

std::size_t Updater::chunk_bytes() const noexcept {
  return std::min(kChunkBytes, release_->bytes - chunk_ * kChunkBytes);
}

Updater::Result Updater::write(std::span<const std::byte> bytes, PagedWriter& why) noexcept {
  STOF_CHECK(bytes.size() <= kMostAtOnce);
  if (place_ == Place::kChunks) {
    const Status status = writer_->pump();
    if (status != Status::kOk && status != Status::kTimeout) {
      place_ = Place::kEnd;
      filled_ = 0;
      return worn(why);
    }
    // Whole or not at all, also where it ends one chunk and begins the next.
    if (!writer_->has_room_for(filled_ + bytes.size() > chunk_bytes() ? 2 : 1)) {
      why << "update: the card is slower than what comes: repeat it";
      return Result::kBusy;
    }
  }
  why << "update: ";
  while (!bytes.empty()) {
    const std::span<std::byte> to = place();
    const std::size_t count = std::min(bytes.size(), to.size() - filled_);
    std::ranges::copy(bytes.first(count), to.subspan(filled_).begin());
    filled_ += count;
    bytes = bytes.subspan(count);
    if (filled_ < to.size()) {
      return Result::kOk;
    }
    filled_ = 0;
    if (const Result result = finish_place(why); result != Result::kOk) {
      place_ = Place::kEnd;
      release_.reset();
      return result;
    }
  }
  return Result::kOk;
}

Updater::Result Updater::finish_place(PagedWriter& why) noexcept {
  switch (place_) {
    case Place::kHead:
      return judge_head(why);
    case Place::kHashes: {
      const auto hashes = std::span(hashes_).first(release_->chunks() * kHashBytes);
      if (wire::digest_of({}, {hashes}) != release_->hashes) {
        why << "its list of hashes is not the signed one: it is damaged, get it again";
        return Result::kInvalid;
      }
      place_ = Place::kChunks;
      writer_->begin(other(setup_.running));
      other_ = 0;
      if (outcome_.what == TrialOutcome::What::kLeft) {
        outcome_ = {};
      }
      static_cast<void>(writer_->pump());
      return Result::kOk;
    }
    case Place::kChunks:
      return finish_chunk(why);
    case Place::kEnd:
      break;
  }
  why << "there are more bytes than the signed size: get it again";
  return Result::kInvalid;
}

Updater::Result Updater::judge_head(PagedWriter& why) noexcept {
  release_ = read_release(head_);
  if (!release_) {
    why << "this is no update file, or of another version: name a file of scripts/image";
    return Result::kInvalid;
  }
  if (!is_signed(head_, setup_.keys)) {
    why << "it is not signed with a maker's key that this sensor knows: get it from the maker";
    return Result::kInvalid;
  }
  if (const Result result = judge_release(*release_, why); result != Result::kOk) {
    return result;
  }
  if (release_->file_bytes() != total_) {
    why << "it has " << total_ << " bytes, the signed size is " << release_->file_bytes()
        << ": get it again";
    return Result::kInvalid;
  }
  place_ = Place::kHashes;
  return Result::kOk;
}

Updater::Result Updater::judge_release(const Release& release, PagedWriter& why) const noexcept {
  const std::string_view camera =
      running_.release ? text_of(running_.release->camera) : text_of(release.camera);
  const std::uint32_t counter = running_.release ? running_.release->counter : 0;
  if (text_of(release.board) != setup_.board || text_of(release.camera) != camera) {
    why << "it is for board ";
    settings::write_clipped(text_of(release.board), why);
    why << " with camera ";
    settings::write_clipped(text_of(release.camera), why);
    why << ", this one is " << setup_.board << " with " << camera << ": get the file for it";
  } else if (release.counter < counter) {
    why << "its downgrade counter is " << release.counter << ", that of the running release "
        << counter << ": get a newer one";
  } else if (release.bytes > room_of_slot() || release.chunks() * kHashBytes > hashes_.size()) {
    why << "it has " << release.bytes << " bytes, a slot of this card " << room_of_slot()
        << ": write the card again";
  } else {
    return Result::kOk;
  }
  return Result::kInvalid;
}

Updater::Result Updater::finish_chunk(PagedWriter& why) noexcept {
  const std::size_t begin = chunk_ * kChunkBytes;
  const std::span<std::byte> chunk = place();
  const auto hash = std::span(hashes_).subspan(chunk_ * kHashBytes, kHashBytes);
  if (!std::ranges::equal(wire::digest_of({}, {chunk}), hash)) {
    why << "chunk " << chunk_
        << " has another hash than the signed one: it is damaged, get it again";
    return Result::kInvalid;
  }
  if (release_->letter_at >= begin && release_->letter_at - begin < chunk.size()) {
    chunk[release_->letter_at - begin] =
        std::byte{static_cast<unsigned char>(letter(other(setup_.running)))};
  }
  writer_->put(chunk.size());
  static_cast<void>(writer_->pump());
  ++chunk_;
  place_ = chunk_ < release_->chunks() ? Place::kChunks : Place::kEnd;
  return Result::kOk;
}

Updater::Result Updater::commit(const firmware::Requester& /*by*/, PagedWriter& why) noexcept {
  if (wish_ == Restart::kTrial) {
    return Result::kOk;
  }
  if (!release_ || chunk_ < release_->chunks()) {
    why << "update: not all of it has come: send it again";
    return Result::kInvalid;
  }
  const Status status = writer_->pump();
  if (status == Status::kTimeout) {
    return writing(why);
  }
  if (status != Status::kOk) {
    release_.reset();
    return worn(why);
  }
  return keep(head_, why);
}

Updater::Result Updater::keep(const ReleaseBytes& release, PagedWriter& why) noexcept {
  if (keeping_ == Keeping::kNot) {
    record_ = write_record(release, shown_, running_.trial + 1);
    other_ = fingerprint_of(release);
    keeping_ = Keeping::kChoice;
  }
  const Status status = go_on_keeping();
  if (status == Status::kTimeout) {
    return writing(why);
  }
  return status == Status::kOk ? Result::kOk : worn(why);
}

// The way to a restart on trial: no start that nobody has asked for it sees anything of it.
Status Updater::go_on_keeping() noexcept {
  Status status = Status::kOk;
  if (keeping_ == Keeping::kChoice) {
    status = sector_->set(settled(setup_.running));
    if (status == Status::kOk) {
      const hal::DiskPart part = part_of(other(setup_.running));
      setup_.slots->write(part, setup_.slots->bytes(part) - kRecordBytes, record_);
      keeping_ = Keeping::kRecord;
    }
  }
  if (keeping_ == Keeping::kRecord) {
    status = setup_.slots->progress();
  }
  if (status != Status::kTimeout) {
    keeping_ = Keeping::kNot;
    wish_ = status == Status::kOk ? Restart::kTrial : Restart::kNone;
  }
  return status;
}

Updater::Result Updater::revert(const firmware::Requester& /*by*/, PagedWriter& why) noexcept {
  if (wish_ == Restart::kTrial) {
    return Result::kOk;
  }
  if (const Result result = may_begin(why); result != Result::kOk) {
    return result;
  }
  if (keeping_ != Keeping::kNot) {
    return keep(head_, why);
  }
  place_ = Place::kEnd;
  release_.reset();
  if (writer_->pump() == Status::kTimeout) {
    return writing(why);
  }
  const Record beside = load_record(other(setup_.running));
  if (!beside.release || !is_signed(beside.bytes, setup_.keys)) {
    why << "there is no whole release in slot " << letter(other(setup_.running))
        << ": send one (stof update SENSOR FILE)";
    return Result::kNotSaved;
  }
  if (const Result result = judge_release(*beside.release, why); result != Result::kOk) {
    return result;
  }
  head_ = beside.bytes;
  return keep(head_, why);
}

void Updater::judge_trial(Trial::Verdict verdict) noexcept {
  if (verdict == Trial::Verdict::kOpen || wish_ != Restart::kNone) {
    return;
  }
  const Status status = verdict == Trial::Verdict::kConfirmed
                            ? sector_->set(settled(setup_.running))
                            : Status::kTimeout;
  if (status == Status::kOk) {
    trial_.reset();
    outcome_.what = TrialOutcome::What::kConfirmed;
  } else if (status != Status::kTimeout || verdict == Trial::Verdict::kLeft) {
    wish_ = Restart::kUsual;  // a card that takes nothing has the former release still
    outcome_.what = TrialOutcome::What::kLeft;
  }
}

void Updater::tick(hal::Time now, const Published& published, hal::Duration period) noexcept {
  lately_.note(now, published);
  if (!published.standby) {  // else what it published before that
    shown_ = lately_.within(now, before_of(period));
  }
  if (trial_) {
    judge_trial(trial_->tick(now, published, period));
  } else if (keeping_ != Keeping::kNot) {
    static_cast<void>(go_on_keeping());
  } else if (writer_) {
    static_cast<void>(writer_->pump());
  }
  if (wish_ != Restart::kNone && !wished_) {
    wished_ = now;
  }
}

Restart Updater::restart(hal::Time now) const noexcept {
  return wished_ && now - *wished_ >= kFarewell ? wish_ : Restart::kNone;
}

}  // namespace stof::update
