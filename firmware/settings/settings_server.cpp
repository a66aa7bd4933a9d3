#include "firmware/settings/settings_server.h"

#include <array>

#include "firmware/events/event_values.h"
#include "firmware/settings/depth_settings.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/field_value.h"
#include "firmware/settings/fields/network_text.h"
#include "firmware/settings/fields/presets.h"
#include "firmware/settings/fields/schema.h"
#include "firmware/settings/network_document.h"
#include "firmware/settings/saved_settings.h"
#include "firmware/settings/text/as_text.h"

namespace stof::settings {
namespace {

using wire::SettingsOperation;

// What others rely on, and what wears the medium: more than a change until the next start.
bool needs_tune(SettingsOperation operation) noexcept {
  return operation == SettingsOperation::kStage || operation == SettingsOperation::kCommit ||
         operation == SettingsOperation::kRevert || operation == SettingsOperation::kSave;
}

std::string_view operation_name(SettingsOperation operation) noexcept {
  switch (operation) {
    case SettingsOperation::kStage:
      return "stage";
    case SettingsOperation::kCommit:
      return "commit";
    case SettingsOperation::kRevert:
      return "revert";
    default:
      return "save";
  }
}

// The serial line, also one that leads to strangers.
bool came_over_line(const firmware::Requester& by) noexcept {
  return !by.peer || by.peer->address == decltype(by.peer->address){};
}

constexpr std::string_view kLineCloses =
    "serial.mode: this line takes no more requests: set it back over the network, or restart the "
    "sensor without saving this";
constexpr std::string_view kNetworkOnTrial =
    "network: in force in a second, for one minute; whoever saves the settings at the sensor's new "
    "place keeps it (stof config SENSOR save), else it is taken back";
constexpr std::string_view kNetworkNotInForce =
    "active, but not saved: network is not in force yet: save over its new place";

}  // namespace

bool usable(const Settings& settings, Limits* limits, PagedWriter& why) noexcept {
  if (const char* const what = problem(settings); *what != '\0') {
    why << "depth.match: " << what;
    return false;
  }
  if (const char* const what = problem(settings.network); *what != '\0') {
    why << what;
    return false;
  }
  return limits == nullptr || limits->accepts(settings, why);
}

SettingsServer::SettingsServer(const Settings& active, const Settings& saved,
                               const Parts& parts) noexcept
    : parts_(parts),
      started_(active),
      active_(active),
      saved_(saved),
      fell_back_(parts.fell_back),
      dropped_(parts.dropped) {
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    overridden_.set(place, !equal(field(place), active_, saved_));
  }
}

bool SettingsServer::restart_needed() const noexcept {
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    const Field known = field(place);
    if (known.applies == Applies::kRestart && !equal(known, started_, active_)) {
      return true;
    }
  }
  return false;
}

Settings SettingsServer::with_staged(const FieldSet& fields) const noexcept {
  Settings settings = active_;
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    if (fields.test(place)) {
      copy_field(field(place), staged_values_, settings);
    }
  }
  return settings;
}

wire::SettingsAnswer SettingsServer::serve(const wire::SettingsRequest& request,
                                           std::span<const std::byte> text,
                                           const firmware::Requester& by,
                                           std::span<std::byte> answer_text,
                                           std::size_t& answer_bytes) noexcept {
  const bool reads = request.operation == SettingsOperation::kGet;
  PagedWriter out(as_writable_text(answer_text), reads ? request.offset : 0);
  const std::uint32_t before = revision_;
  const SerialMode mode = active_.serial.mode;
  const NetworkSettings network = active_.network;
  const Result result = serve(request, as_text(text), by, out);
  if (came_over_line(by) && mode == SerialMode::kStof && active_.serial.mode != mode) {
    out << (out.text().empty() ? "" : "; ") << kLineCloses;
  }
  const bool network_began = network != active_.network && network_runs();
  if (network_began) {
    out << (out.text().empty() ? "" : "; ") << kNetworkOnTrial;
  }
  if (revision_ != before && parts_.changes != nullptr) {
    firmware::Event change{
        .kind = firmware::EventKind::kSettingsChanged,
        .former = network_began ? firmware::kNetworkOnTrial : firmware::kNotOfNetwork};
    if (by.peer) {
      change.address = by.peer->address;
      change.value = firmware::who(change.address);
    }
    static_cast<void>(parts_.changes->push(change));
  }
  answer_bytes = out.text().size();
  return {.result = result,
          .restart = static_cast<std::uint8_t>(restart_needed() ? 1 : 0),
          .total = static_cast<std::uint16_t>(reads ? out.total() : 0),
          .revision = revision_};
}

SettingsServer::Result SettingsServer::serve(const wire::SettingsRequest& request,
                                             std::string_view text, const firmware::Requester& by,
                                             PagedWriter& out) noexcept {
  using Operation = wire::SettingsOperation;
  if (needs_tune(request.operation) && by.access < Access::kTune) {
    static_cast<void>(deny(operation_name(request.operation), by.access, Access::kTune, out));
    return Result::kDenied;
  }
  switch (request.operation) {
    case Operation::kGet:
      return get(request.document, by.access, out);
    case Operation::kSet:
      return change(text, by, out);
    case Operation::kStage:
      return stage(text, by, out);
    case Operation::kCommit:
      return commit(by, out);
    case Operation::kRevert:
      revert(by);
      return Result::kOk;
    case Operation::kPreset:
      return preset(text, by, out);
    case Operation::kSave:
      return save(by, out);
    case Operation::kReset:
      return reset(by, out);
    case Operation::kKeys:
    case Operation::kUnpair:
    case Operation::kUpload:
    case Operation::kDownload:
      break;
  }
  return Result::kUnsupported;
}

SettingsServer::Result SettingsServer::get(wire::SettingsDocument document, firmware::Access access,
                                           PagedWriter& out) const noexcept {
  using Document = wire::SettingsDocument;
  switch (document) {
    case Document::kActive:
      write_document(active_, out);
      return Result::kOk;
    case Document::kStaged:
      write_document(staged(), out);
      return Result::kOk;
    case Document::kSaved:
      write_document(saved_, out);
      return Result::kOk;
    case Document::kDefaults:
      write_document({}, out);
      return Result::kOk;
    case Document::kSchema:
      write_schema(out);
      return Result::kOk;
    case Document::kNetwork:
      return write_network(parts_.interfaces, access, out);
  }
  return Result::kUnsupported;
}

bool SettingsServer::staged_by(const firmware::Requester& by, std::string_view operation,
                               PagedWriter& why) noexcept {
  if (losers_.has(by.key_id)) {
    why << operation
        << ": somebody else has reverted what you had staged: revert, and stage all of it again";
    return false;
  }
  if (staged_fields_.none() || by.key_id == staged_key_) {
    return true;
  }
  why << operation << ": somebody else has staged settings; revert forgets them";
  return false;
}

void SettingsServer::revert(const firmware::Requester& by) noexcept {
  static_cast<void>(losers_.take(by.key_id));  // begins anew
  if (staged_fields_.any() && by.key_id != staged_key_) {
    losers_.add(staged_key_);
  }
  forget_staged();
}

void SettingsServer::forget_staged() noexcept {
  staged_fields_.reset();
  staged_by_tune_.reset();
  staged_fell_back_ = false;
}

// Whoever may not set a field may not make it fall back either.
SettingsServer::Result SettingsServer::read(std::string_view json, const firmware::Requester& by,
                                            Settings& next, FieldSet& named, PagedWriter& notes,
                                            PagedWriter& why) noexcept {
  FellBack fell_back;
  if (!parse(json, next, notes, &named, &fell_back)) {
    why << notes.text();
    return Result::kInvalid;
  }
  if (fell_back.access > by.access) {
    static_cast<void>(deny(fell_back.path.view(), by.access, fell_back.access, why));
    return Result::kDenied;
  }
  return Result::kOk;
}

SettingsServer::Result SettingsServer::stage(std::string_view text, const firmware::Requester& by,
                                             PagedWriter& why) noexcept {
  if (!staged_by(by, "stage", why)) {
    return Result::kDenied;
  }
  Settings next = active_;
  FieldSet named;
  std::array<char, firmware::kSettingsTextBytes> space;
  PagedWriter notes(space);
  if (const Result read_so = read(text, by, next, named, notes, why); read_so != Result::kOk) {
    return read_so;
  }
  if (!permitted(active_, next, by.access, why)) {
    return Result::kDenied;
  }
  why << notes.text();
  staged_key_ = by.key_id;
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    const Field known = field(place);
    // What he may not change is as it is active: it says nothing, and is not staged.
    if (named.test(place) && known.access <= by.access) {
      copy_field(known, next, staged_values_);
      staged_fields_.set(place);
      staged_by_tune_.set(place, by.access < Access::kAdmin);
    }
  }
  staged_fell_back_ = staged_fell_back_ || notes.total() > 0;
  return Result::kOk;
}

SettingsServer::Result SettingsServer::commit(const firmware::Requester& by,
                                              PagedWriter& why) noexcept {
  if (!staged_by(by, "commit", why)) {
    return Result::kDenied;
  }
  // The limits may have changed since.
  if (!permitted(active_, with_staged(staged_by_tune_), Access::kTune, why)) {
    return Result::kDenied;
  }
  std::array<char, kWhyBytes> space;
  PagedWriter notes(space);
  const Result result = become(staged(), by, staged_fell_back_, notes, why);
  if (result != Result::kOk) {
    return result;  // what is staged stays
  }
  name_fields(staged_fields_, by);
  forget_staged();
  return save(by, why);
}

SettingsServer::Result SettingsServer::preset(std::string_view name, const firmware::Requester& by,
                                              PagedWriter& why) noexcept {
  if (const SettingsPreset* const found = find_preset(name)) {
    return change(found->json, by, why);
  }
  why << "preset: takes ";
  write_preset_names(why);
  return Result::kInvalid;
}

const Settings* SettingsServer::saved_in_force() const noexcept {
  const bool runs = revision_ == 1 || (to_save() == saved_ && !restart_needed());
  return runs && !dropped_ ? &saved_ : nullptr;
}

Settings SettingsServer::to_save() const noexcept {
  Settings settings = active_;
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    if (overridden_.test(place)) {
      copy_field(field(place), saved_, settings);
    }
  }
  return settings;
}

bool SettingsServer::confirm_network(const firmware::Requester& by, Settings& next,
                                     PagedWriter& why) const noexcept {
  if (by.access < Access::kAdmin) {
    next.network = saved_.network;
    return true;
  }
  // Who holds the cable reaches the sensor at any address.
  if (!came_over_line(by) && !parts_.network->in_force()) {
    why << (why.text().empty() ? "" : "; ") << kNetworkNotInForce;
    return false;
  }
  parts_.network->confirm();
  return true;
}

void SettingsServer::tick(hal::Time now) noexcept {
  const std::optional<NetworkSettings> former =
      parts_.network == nullptr ? std::nullopt : parts_.network->tick(now);
  if (!former) {
    return;
  }
  Settings next = active_;
  next.network = *former;
  std::array<char, kWhyBytes> space;
  PagedWriter unused(space);
  // Where the loop has not got to the last settings yet it is tried again.
  if (become(next, {.peer = {}, .now = now, .access = Access::kAdmin}, false, unused, unused) ==
          Result::kOk &&
      parts_.changes != nullptr) {
    static_cast<void>(parts_.changes->push(
        {.kind = firmware::EventKind::kSettingsChanged, .former = firmware::kNetworkTakenBack}));
  }
}

SettingsServer::Result SettingsServer::save(const firmware::Requester& by,
                                            PagedWriter& why) noexcept {
  Settings next = to_save();
  if (network_runs() && !confirm_network(by, next, why)) {
    return Result::kNotSaved;
  }
  if (next == saved_ && !unsaved_ && !fell_back_ && !dropped_) {
    return Result::kOk;  // a repeated request does not wear the medium
  }
  const std::string_view joint = why.text().empty() ? "" : "; ";
  if (parts_.store == nullptr) {
    why << joint << "active, but not saved: the sensor was started without a file for its settings";
    return Result::kNotSaved;
  }
  unsaved_ = true;
  std::array<char, kWhyBytes> space;
  PagedWriter refusal(space);
  if (!usable(next, &parts_.limits, refusal)) {
    why << joint << "active, but not saved, since without the command line it would not do: "
        << refusal.text();
    return Result::kNotSaved;
  }
  if (!saves_.take(by.now)) {
    why << joint << "active, but not saved: " << kMostSaves
        << " saves at once, then one a minute: save again later";
    return Result::kNotSaved;
  }
  const Status status = write(next);
  if (status != Status::kOk) {
    why << joint << "active, but not saved: "
        << (status == Status::kUnsupported ? "what has the file's name is no file"
                                           : "the file cannot be written");
    return Result::kNotSaved;
  }
  saved_ = next;
  unsaved_ = false;
  fell_back_ = false;
  dropped_ = false;
  return Result::kOk;
}

// The record first: where only one of the two is written, the next start goes by the document.
Status SettingsServer::write(const Settings& settings) const noexcept {
  const Status kept = parts_.fixed == nullptr ? Status::kOk : save_fixed(*parts_.fixed, settings);
  return kept == Status::kOk ? save_document(*parts_.store, settings) : kept;
}

SettingsServer::Result SettingsServer::change(std::string_view json, const firmware::Requester& by,
                                              PagedWriter& why) noexcept {
  Settings next = active_;
  FieldSet named;
  std::array<char, firmware::kSettingsTextBytes> space;
  PagedWriter notes(space);
  Result result = read(json, by, next, named, notes, why);
  if (result == Result::kOk) {
    result = become(next, by, notes.total() > 0, notes, why);
  }
  if (result == Result::kOk) {
    name_fields(named, by);
  }
  return result;
}

// Who names a field with the value that it has changes nothing: not what a later save writes
// either, unless the field is his to set.
void SettingsServer::name_fields(const FieldSet& fields, const firmware::Requester& by) noexcept {
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    if (fields.test(place) && field(place).access <= by.access) {
      overridden_.reset(place);
    }
  }
}

SettingsServer::Result SettingsServer::reset(const firmware::Requester& by,
                                             PagedWriter& why) noexcept {
  // Where it listens now is not for a reset to change: of the port the next start sees to it, and
  // the network stays as it is.
  const std::size_t port = find_field("udp.port");
  FieldSet kept;
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    kept.set(place, place == port || field(place).group == "network");
  }
  kept &= overridden_;
  Settings next;
  next.udp_port = kept.test(port) ? active_.udp_port : next.udp_port;
  next.network = active_.network;
  std::array<char, kWhyBytes> space;
  PagedWriter notes(space);
  const Result result = become(next, by, false, notes, why);
  if (result == Result::kOk) {
    name_fields(~kept, by);
  }
  return result;
}

SettingsServer::Result SettingsServer::become(Settings next, const firmware::Requester& by,
                                              bool fell_back, PagedWriter& notes,
                                              PagedWriter& why) noexcept {
  // Before blocks are fitted too: what is asked for counts, not what becomes of it.
  if (!permitted(active_, next, by.access, why)) {
    return Result::kDenied;
  }
  fit_blocks(next, notes);
  const bool falls_back = fell_back || notes.total() > 0;
  // Without a file nothing is ever saved: there the last change counts of who may make it fall
  // back.
  const bool stays = fell_back_ && (parts_.store != nullptr || by.access < Access::kTune);
  if (next == active_ && !falls_back) {
    fell_back_ = stays;
    return Result::kOk;
  }
  if (!permitted(active_, next, by.access, why)) {
    return Result::kDenied;
  }
  if (!usable(next, &parts_.limits, why)) {
    return Result::kInvalid;
  }
  if (!parts_.sink.apply(next, revision_ + 1)) {
    return Result::kBusy;
  }
  why << notes.text();
  active_ = next;
  fell_back_ = falls_back || stays;
  ++revision_;
  if (parts_.network != nullptr) {
    parts_.network->change(next.network, by.now);
  }
  return Result::kOk;
}

}  // namespace stof::settings
