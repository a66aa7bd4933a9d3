#include "host/recording/recorder.h"

#include <utility>

namespace stof::recording {

std::expected<std::unique_ptr<Recorder>, Problem> Recorder::start(mcap::ByteSink& sink,
                                                                  const RecorderOptions& options) {
  auto writer =
      mcap::Writer::begin(sink, {.profile = std::string(kProfile), .library = options.library});
  if (!writer) {
    return std::unexpected(writer.error());
  }
  return std::unique_ptr<Recorder>(new Recorder(std::move(*writer), options));
}

Recorder::Recorder(mcap::Writer&& writer, RecorderOptions options)
    : writer_(std::move(writer)), options_(std::move(options)), thread_([this] { run(); }) {}

Recorder::~Recorder() { finish(); }

bool Recorder::enqueue(Batch&& batch, bool always) {
  {
    const std::scoped_lock lock(mutex_);
    if (stop_ || ended_.problem ||
        (!always && queued_bytes_ + batch.bytes > options_.queue_bytes)) {
      return false;
    }
    queued_bytes_ += batch.bytes;
    queue_.push_back(std::move(batch));
  }
  wake_.notify_one();
  return true;
}

bool Recorder::put(TopicMessages&& messages) {
  Batch batch{.messages = std::move(messages)};
  for (const TopicMessage& message : batch.messages) {
    batch.bytes += message.data.size();
  }
  return enqueue(std::move(batch), false);
}

void Recorder::put(mcap::Metadata&& metadata) { enqueue({.metadata = std::move(metadata)}, true); }

void Recorder::put(OwnedAttachment&& attachment) {
  enqueue({.attachment = std::move(attachment)}, true);
}

bool Recorder::failed() const {
  const std::scoped_lock lock(mutex_);
  return ended_.problem.has_value();
}

std::expected<void, Problem> Recorder::write(const Batch& batch) {
  for (const TopicMessage& message : batch.messages) {
    auto known = channels_.find(message.topic);
    if (known == channels_.end()) {
      const TopicInfo& info = info_of(message.topic);
      mcap::TextMap metadata;
      if (!info.unit.empty()) {
        metadata["unit"] = info.unit;
      }
      const auto id = writer_.add_channel(info.name, kEncoding, info.schema(), metadata);
      if (!id) {
        return std::unexpected(id.error());
      }
      known = channels_.emplace(message.topic, *id).first;
    }
    if (auto done = writer_.add_message({.channel_id = known->second,
                                         .sequence = message.sequence,
                                         .log_time = message.log_time,
                                         .publish_time = message.log_time,
                                         .data = message.data});
        !done) {
      return done;
    }
  }
  if (batch.metadata) {
    return writer_.add_metadata(*batch.metadata);
  }
  if (batch.attachment) {
    const OwnedAttachment& attachment = *batch.attachment;
    return writer_.add_attachment({.log_time = attachment.log_time,
                                   .create_time = attachment.log_time,
                                   .name = attachment.name,
                                   .media_type = attachment.media_type,
                                   .data = attachment.data});
  }
  return {};
}

std::uint64_t Recorder::messages_of(Topic topic) const {
  const auto& counts = writer_.index().statistics.messages_by_channel;
  const auto channel = channels_.find(topic);
  const auto count = channel == channels_.end() ? counts.end() : counts.find(channel->second);
  return count == counts.end() ? 0 : count->second;
}

void Recorder::run() {
  using Clock = std::chrono::steady_clock;
  Clock::time_point sync_due = Clock::now() + options_.sync_period;
  std::expected<void, Problem> done;
  while (done) {
    std::optional<Batch> batch;
    bool stop = false;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_until(lock, sync_due, [this] { return stop_ || !queue_.empty(); });
      stop = stop_;
      if (!queue_.empty()) {
        batch = std::move(queue_.front());
        queue_.pop_front();
        queued_bytes_ -= batch->bytes;
      }
    }
    if (batch) {
      done = write(*batch);
    } else if (stop) {
      break;
    }
    if (done && Clock::now() >= sync_due) {
      done = writer_.flush();
      sync_due = Clock::now() + options_.sync_period;
    }
  }
  if (done) {
    done = writer_.finish();
  }
  const bool indexed = done.has_value() || writer_.rescue();
  const std::scoped_lock lock(mutex_);
  if (!done) {
    ended_.problem = done.error();
  }
  ended_.indexed = indexed;
  ended_.frames = messages_of(Topic::kFrameInfo);
  ended_.exposures = messages_of(Topic::kRawEdge);
  ended_.statistics = writer_.index().statistics;
  ended_.bytes = indexed ? writer_.bytes() : writer_.position();
}

Recorder::Ended Recorder::finish() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) {
    thread_.join();
  }
  return ended_;
}

}  // namespace stof::recording
