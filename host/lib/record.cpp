#include "host/lib/record.h"

#include <mutex>
#include <system_error>

#include "host/lib/sensor.h"

using namespace stof;
using lib::guarded;

namespace stof::lib {

std::expected<std::unique_ptr<Record>, recording::Problem> Record::start(
    const std::filesystem::path& file, Options options) {
  auto sink = mcap::FileSink::open(file, options.replace ? mcap::FileSink::Existing::kReplace
                                                         : mcap::FileSink::Existing::kRefuse);
  if (!sink) {
    return std::unexpected(std::move(sink.error()));
  }
  constexpr const char* kProgram = "libstof " STOF_VERSION;
  std::unique_ptr<Record> made(new Record(file, std::move(*sink)));
  auto recorder = recording::Recorder::start(made->sink_, {.library = kProgram});
  if (!recorder) {
    std::error_code none;
    std::filesystem::remove(file, none);
    return std::unexpected(std::move(recorder.error()));
  }
  made->recorder_ = std::move(*recorder);
  const char* const later = options.read ? "read while it was recorded: see its topic"
                                         : "the sensor was not asked: it sends here by itself";
  made->session_.emplace(*made->recorder_,
                         recording::SessionRecording::Options{.program = kProgram,
                                                              .sensor = std::move(options.sensor),
                                                              .is_signed = options.is_signed,
                                                              .read = std::move(options.read)},
                         recording::SensorDocuments{.no_settings = later, .no_calibration = later});
  return made;
}

stof_recorded Record::state() const {
  stof_recorded state{};
  state.recording = 1;
  state.frames = session_->frames();
  state.frames_dropped = session_->dropped();
  state.failed = recorder_->failed() ? 1 : 0;
  return state;
}

std::pair<stof_recorded, std::optional<recording::Problem>> Record::finish() {
  session_->finish();
  recording::Recorder::Ended ended = recorder_->finish();
  stof_recorded state{};
  state.frames = ended.frames;
  state.frames_dropped = session_->dropped();
  state.bytes = ended.bytes;
  state.failed = ended.problem ? 1 : 0;
  state.indexed = ended.indexed ? 1 : 0;
  if (ended.frames == 0) {
    std::error_code none;
    std::filesystem::remove(file_, none);
    state.bytes = 0;
  }
  return {state, std::move(ended.problem)};
}

namespace {

// Of the sensor over its control, with its mutex.
recording::SensorDocuments documents_of(stof_sensor& sensor, bool calibration) {
  const std::scoped_lock lock(sensor.control_mutex);
  if (!sensor.control) {
    if (const std::optional<Refusal> refusal = open_control(sensor)) {
      return {.no_settings = refusal->text, .no_calibration = refusal->text};
    }
  }
  return recording::read_documents(*sensor.control, calibration);
}

}  // namespace
}  // namespace stof::lib

extern "C" {

stof_status stof_record(stof_sensor* sensor, const char* file, const stof_record_options* options,
                        char* why, size_t why_size) {
  lib::give_text("", why, why_size);
  const auto known = options == nullptr ? std::optional(stof_record_options{}) : lib::read(options);
  if (sensor == nullptr || file == nullptr || *file == '\0' || !known) {
    lib::give_text("stof_record: no sensor, no file, or options without struct_size", why,
                   why_size);
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->played) {
    lib::give_text("stof_record: it is a recording already: copy its file", why, why_size);
    return STOF_UNSUPPORTED;
  }
  return guarded([&] {
    const std::scoped_lock lock(sensor->record_mutex);
    if (sensor->record) {
      lib::give_text("stof_record: it is recorded already: stof_record_end() first", why, why_size);
      return STOF_BUSY;
    }
    const bool asks = !sensor->sensor.empty() || sensor->line != nullptr;
    const std::string address = sensor->sensor.empty() ? "sends here" : sensor->sensor;
    lib::Record::Options wanted{.replace = known->replace != 0,
                                .sensor = sensor->line ? sensor->line->device() : address,
                                .is_signed = sensor->is_signed};
    if (asks) {
      wanted.read = [sensor](bool calibration) { return lib::documents_of(*sensor, calibration); };
    }
    auto record = lib::Record::start(file, std::move(wanted));
    if (!record) {
      lib::give_text(record.error().message, why, why_size);
      return STOF_FILE;
    }
    sensor->record = *std::move(record);
    return STOF_OK;
  });
}

stof_status stof_record_end(stof_sensor* sensor, stof_recorded* recorded, char* why,
                            size_t why_size) {
  lib::give_text("", why, why_size);
  if (sensor == nullptr || (recorded != nullptr && recorded->struct_size < sizeof(std::uint32_t))) {
    return STOF_BAD_ARGUMENT;
  }
  return guarded([&] {
    std::unique_ptr<lib::Record> record;
    {
      const std::scoped_lock lock(sensor->record_mutex);
      record = std::move(sensor->record);
    }
    if (!record) {
      return STOF_NOT_YET;
    }
    const auto [state, problem] = record->finish();  // whoever receives goes on meanwhile
    {
      const std::scoped_lock lock(sensor->record_mutex);
      sensor->recorded = state;
    }
    static_cast<void>(lib::give(recorded, state));
    if (problem) {
      lib::give_text(problem->message, why, why_size);
      return STOF_FILE;
    }
    return STOF_OK;
  });
}

stof_status stof_get_recorded(stof_sensor* sensor, stof_recorded* recorded) {
  if (sensor == nullptr) {
    return STOF_BAD_ARGUMENT;
  }
  const std::scoped_lock lock(sensor->record_mutex);
  if (!sensor->record && !sensor->recorded) {
    return STOF_NOT_YET;
  }
  return lib::give(recorded, sensor->record ? sensor->record->state() : *sensor->recorded)
             ? STOF_OK
             : STOF_BAD_ARGUMENT;
}

}  // extern "C"
