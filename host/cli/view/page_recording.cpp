#include "host/cli/view/page_recording.h"

#include <array>
#include <atomic>
#include <chrono>
#include <ctime>
#include <system_error>
#include <utility>

#include "host/cli/recording/sensor_documents.h"
#include "host/recording/session_recording.h"

namespace stof::host {
namespace {

std::string name_of_now() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 32> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), "stof_%Y%m%d_%H%M%S", &local);
  return {text.data(), size};
}

// Two of one second have names of their own.
std::expected<std::pair<std::filesystem::path, mcap::FileSink>, mcap::Problem> make_file(
    const std::filesystem::path& folder) {
  constexpr int kMost = 9;
  const std::string name = name_of_now();
  for (int i = 1;; ++i) {
    const std::string more = i == 1 ? std::string() : "_" + std::to_string(i);
    std::filesystem::path file = folder / (name + more + ".mcap");
    std::error_code error;
    if (i < kMost && std::filesystem::exists(file, error)) {
      continue;
    }
    auto sink = mcap::FileSink::open(file, mcap::FileSink::Existing::kRefuse);
    if (!sink) {
      return std::unexpected(sink.error());
    }
    return std::pair(std::move(file), std::move(*sink));
  }
}

// The problem without the file's name, which the page tells itself.
std::string ending_text(const recording::Recorder::Ended& ended, const std::string& file) {
  if (!ended.problem) {
    return ended.frames == 0 ? "no frame came: there is no file" : "";
  }
  const std::string& message = ended.problem->message;
  return (message.starts_with(file + ": ") ? message.substr(file.size() + 2) : message) +
         (ended.frames == 0 ? "; there is no file" : "; what was written whole is there");
}

}  // namespace

struct PageRecording::Open {
  // Tells how much is written already, from any thread.
  class CountedSink : public mcap::ByteSink {
   public:
    explicit CountedSink(mcap::FileSink file) : file_(std::move(file)) {}
    std::expected<void, mcap::Problem> write(mcap::Bytes bytes) override {
      auto done = file_.write(bytes);
      if (done) {
        bytes_ += bytes.size();
      }
      return done;
    }
    std::expected<void, mcap::Problem> sync() override { return file_.sync(); }
    std::expected<void, mcap::Problem> cut_to(std::uint64_t size) override {
      auto done = file_.cut_to(size);
      if (done) {
        bytes_ = size;
      }
      return done;
    }
    std::uint64_t bytes() const noexcept { return bytes_; }

   private:
    mcap::FileSink file_;
    std::atomic<std::uint64_t> bytes_{0};
  };

  std::filesystem::path file;
  CountedSink sink;
  std::unique_ptr<recording::Recorder> recorder{};
  std::optional<recording::SessionRecording> session{};  // last: it uses the others
  client::Time began = client::Time::clock::now();

  // Blocks until all is written.
  recording::Recorder::Ended finish() {
    session->finish();
    recording::Recorder::Ended ended = recorder->finish();
    if (ended.frames == 0) {
      std::error_code none;
      std::filesystem::remove(file, none);
    }
    return ended;
  }
};

PageRecording::PageRecording(std::filesystem::path folder, std::string program)
    : folder_(std::move(folder)), program_(std::move(program)) {
  last_.possible = true;
}

PageRecording::~PageRecording() {
  end();
  if (ending_.valid()) {
    ending_.wait();
  }
}

std::expected<void, std::string> PageRecording::begin(const ReceiveOptions& receive) {
  static_cast<void>(state());  // what came of the last one
  if (on() ||
      (ending_.valid() && ending_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)) {
    return std::unexpected(on() ? "it is recorded already"
                                : "the last recording is not written yet: wait a moment");
  }
  auto made = make_file(folder_);
  if (!made) {
    return std::unexpected(made.error().message);
  }
  std::unique_ptr<Open> open(new Open{.file = made->first,  // NOLINT: it does not move
                                      .sink = Open::CountedSink(std::move(made->second))});
  auto recorder = recording::Recorder::start(open->sink, {.library = program_});
  if (!recorder) {
    std::error_code none;
    std::filesystem::remove(open->file, none);
    return std::unexpected(recorder.error().message);
  }
  open->recorder = std::move(*recorder);
  constexpr const char* kLater = "read while it was recorded: see its topic";
  open->session.emplace(
      *open->recorder,
      recording::SessionRecording::Options{.program = program_,
                                           .sensor = name_for_file(receive),
                                           .is_signed = receive.signed_streams,
                                           .read = documents_reader(receive)},
      recording::SensorDocuments{.no_settings = kLater, .no_calibration = kLater});
  open_ = std::move(open);
  last_ = {.possible = true, .on = true, .file = open_->file.string()};
  return {};
}

void PageRecording::end() {
  static_cast<void>(state());  // the last counts
  close();
}

void PageRecording::close() {
  if (!on()) {
    return;
  }
  last_.on = false;
  last_.writing = true;
  ending_ = std::async(std::launch::async,
                       [open = std::shared_ptr<Open>(std::move(open_))] { return open->finish(); });
}

void PageRecording::take(const client::Frame& frame, const std::string& place) {
  if (on()) {
    open_->session->take(frame, place);
  }
}

void PageRecording::take(const client::ToldEvent& event) {
  if (on() && open_->session->begun()) {
    open_->session->take(event);
  }
}

void PageRecording::look(client::Receiver& receiver) {
  if (on()) {
    open_->session->look(receiver);
  }
}

viewer::RecordingState PageRecording::state() {
  if (on()) {
    last_.bytes = open_->sink.bytes();
    last_.frames = open_->session->frames();
    last_.dropped = open_->session->dropped();
    last_.seconds =
        std::chrono::duration<double>(client::Time::clock::now() - open_->began).count();
    if (open_->recorder->failed()) {
      close();
    }
  }
  if (ending_.valid() && ending_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const recording::Recorder::Ended ended = ending_.get();
    last_.bytes = ended.bytes;
    last_.frames = ended.frames;
    last_.writing = false;
    last_.problem = ending_text(ended, last_.file);
  }
  return last_;
}

}  // namespace stof::host
