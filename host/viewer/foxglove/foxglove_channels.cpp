#include "host/viewer/foxglove/foxglove_channels.h"

#include <algorithm>
#include <deque>
#include <utility>

#include "host/viewer/foxglove/foxglove_message.h"
#include "host/viewer/rate_limit.h"
#include "host/viewer/web_access.h"

namespace stof::viewer {
namespace {

// What is true until something else is told has no age.
bool ages(bridge::Topic topic) noexcept {
  return topic != bridge::Topic::kDiagnostics && topic != bridge::Topic::kTransforms;
}

}  // namespace

// One client.
class FoxgloveConversation : public Conversation {
 public:
  explicit FoxgloveConversation(FoxgloveChannels& all) : all_(all) {
    all_.visited_ = true;
    owed_ = {all_.server_info_, all_.advertise_};
  }
  ~FoxgloveConversation() override {
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      if (topics_[i].subscribed) {
        --all_.subscribers_[i];
      }
    }
  }
  FoxgloveConversation(const FoxgloveConversation&) = delete;
  FoxgloveConversation& operator=(const FoxgloveConversation&) = delete;

  bool take(std::string_view message) override;
  std::optional<MessageKind> next(std::vector<std::uint8_t>& bytes) override;

 private:
  // Of the messages that a client may ask for without end.
  static constexpr std::size_t kMostOwed = 32;

  struct State {
    bool subscribed = false;
    std::uint32_t id = 0;
    std::uint64_t sent = 0;
  };

  void subscribe(const Subscription& wanted);
  void unsubscribe(std::uint32_t id);
  void refuse(const std::string& why) {
    owed_.push_back(foxglove_status_message(StatusLevel::kError, why));
  }
  auto subscription(std::uint32_t id) {
    return std::ranges::find_if(topics_,
                                [&](const State& one) { return one.subscribed && one.id == id; });
  }

  FoxgloveChannels& all_;
  std::deque<std::string> owed_;
  RateLimit limit_{100, std::chrono::milliseconds(10)};
  std::array<State, bridge::kTopics> topics_{};
  std::size_t turn_ = 0;  // the topic that is asked first
};

void FoxgloveConversation::subscribe(const Subscription& wanted) {
  const std::optional<bridge::Topic> topic = topic_of_channel(wanted.channel);
  if (!topic) {
    refuse("subscribe: there is no channel " + std::to_string(wanted.channel));
    return;
  }
  const auto index = static_cast<std::size_t>(*topic);
  if (topics_[index].subscribed) {
    refuse("subscribe: channel " + std::to_string(wanted.channel) + " is subscribed already");
  } else if (subscription(wanted.id) != topics_.end()) {
    refuse("subscribe: another subscription has the id " + std::to_string(wanted.id));
  } else {
    // What was sent to an older subscription of it is sent again: this one has not got it.
    topics_[index] = {.subscribed = true, .id = wanted.id};
    ++all_.subscribers_[index];
  }
}

void FoxgloveConversation::unsubscribe(std::uint32_t id) {
  const auto found = subscription(id);
  if (found == topics_.end()) {
    refuse("unsubscribe: there is no subscription " + std::to_string(id));
    return;
  }
  found->subscribed = false;
  --all_.subscribers_[static_cast<std::size_t>(found - topics_.begin())];
}

bool FoxgloveConversation::take(std::string_view message) {
  const std::optional<FoxgloveRequest> request = parse_foxglove_message(message);
  if (!request || owed_.size() > kMostOwed || !limit_.take(FoxgloveChannels::Clock::now())) {
    return false;
  }
  if (const auto* const subscribed = std::get_if<Subscribe>(&*request)) {
    std::ranges::for_each(subscribed->subscriptions, [&](const auto& one) { subscribe(one); });
  } else if (const auto* const ended = std::get_if<Unsubscribe>(&*request)) {
    std::ranges::for_each(ended->ids, [&](std::uint32_t id) { unsubscribe(id); });
  } else {
    refuse("this server takes subscribe and unsubscribe alone");
  }
  return true;
}

std::optional<MessageKind> FoxgloveConversation::next(std::vector<std::uint8_t>& bytes) {
  if (!owed_.empty()) {
    bytes.insert(bytes.end(), owed_.front().begin(), owed_.front().end());
    owed_.pop_front();
    return MessageKind::kText;
  }
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    const std::size_t index = (turn_ + i) % topics_.size();
    State& state = topics_[index];
    if (!state.subscribed) {
      continue;
    }
    const FoxgloveChannels::Newest newest = all_.newest(static_cast<bridge::Topic>(index));
    if (newest.message != nullptr && newest.number > state.sent) {
      state.sent = newest.number;
      turn_ = index + 1;
      append_message_data(state.id, newest.time_ns, *newest.message, bytes);
      return MessageKind::kBinary;
    }
  }
  return std::nullopt;
}

FoxgloveChannels::FoxgloveChannels(std::string name, Clock::duration most_age,
                                   std::function<void()> wake)
    : server_info_(server_info_message(name, random_token())),
      advertise_(advertise_message()),
      most_age_(most_age),
      wake_(std::move(wake)) {}

bool FoxgloveChannels::wanted(bridge::Topic topic) {
  return subscribers_[static_cast<std::size_t>(topic)] > 0;
}

bool FoxgloveChannels::publish(bridge::Topic topic, recording::Buffer&& message) {
  auto shared = std::make_shared<const recording::Buffer>(std::move(message));
  const auto time_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  {
    const std::scoped_lock lock(mutex_);
    Newest& newest = newest_[static_cast<std::size_t>(topic)];
    newest = {.number = newest.number + 1,
              .message = std::move(shared),
              .time_ns = static_cast<std::uint64_t>(time_ns.count()),
              .published = Clock::now()};
  }
  if (wanted(topic)) {
    wake_();
  }
  return true;
}

FoxgloveChannels::Newest FoxgloveChannels::newest(bridge::Topic topic) const {
  const std::scoped_lock lock(mutex_);
  Newest newest = newest_[static_cast<std::size_t>(topic)];
  if (ages(topic) && Clock::now() - newest.published > most_age_) {
    newest.message.reset();
  }
  return newest;
}

std::unique_ptr<Conversation> FoxgloveChannels::open_conversation() {
  return std::make_unique<FoxgloveConversation>(*this);
}

}  // namespace stof::viewer
