#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using test::Datagram;
using test::ExpectedImages;

constexpr int kFrames = 12;
constexpr std::size_t kPackets = 13;          // of a frame
constexpr std::uint32_t kFirst = 0xFFFFFFFA;  // numbers wrap on the way
constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();

// One datagram on its way: frame (from 0), index, and whether a bit was turned.
struct Travel {
  int frame;
  std::size_t index;
  bool damaged;
};

struct Weather {
  int loss_percent;
  int duplicate_percent;
  int damage_percent;
  int reach;  // how many places a packet may fall behind
};

// Packets of all frames in sending order, then lost, doubled, damaged and shaken.
std::vector<Travel> journey(const Weather& weather, test::Random& random) {
  struct Keyed {
    int key;
    int order;  // of equal keys: as sent
    Travel travel;
  };
  std::vector<Keyed> out;
  int sent = 0;
  const auto happens = [&random](int percent) { return random.between(0, 99) < percent; };
  for (int frame = 0; frame < kFrames; ++frame) {
    for (std::size_t index = 0; index < kPackets; ++index, ++sent) {
      const bool lost = happens(weather.loss_percent);
      const int arrivals = happens(weather.duplicate_percent) ? 2 : 1;
      const int copies = lost ? 0 : arrivals;
      for (int copy = 0; copy < copies; ++copy) {
        out.push_back({sent + random.between(0, weather.reach),
                       static_cast<int>(out.size()),
                       {frame, index, happens(weather.damage_percent)}});
      }
    }
  }
  std::ranges::sort(out, {}, [](const Keyed& keyed) { return std::pair(keyed.key, keyed.order); });
  std::vector<Travel> travels;
  for (const Keyed& keyed : out) {
    travels.push_back(keyed.travel);
  }
  return travels;
}

// What has to happen, from the rules alone: no slots, no state, the whole journey at once.
class Oracle {
 public:
  explicit Oracle(const std::vector<Travel>& travels) : travels_(travels) {
    std::size_t later_complete = kNever;  // first place at which a frame above is complete
    for (int frame = kFrames - 1; frame >= 0; --frame) {
      const std::size_t bound = std::min(later_complete, first_of_or_after(frame + 2));
      const std::size_t all = all_there(frame);
      close_[frame] = std::min(bound, all);
      if (all < bound) {
        later_complete = std::min(later_complete, all);
      }
    }
  }

  // After which datagram the frame is closed; kNever: only the timeout does it.
  std::size_t close(int frame) const { return close_.at(frame); }

  // Indexes of the packets that are in time. Those at the place of closing are its own last one.
  std::set<std::size_t> packets(int frame) const {
    std::set<std::size_t> indexes;
    for (std::size_t i = 0; i < travels_.size() && i <= close(frame); ++i) {
      if (travels_[i].frame == frame && !travels_[i].damaged) {
        indexes.insert(travels_[i].index);
      }
    }
    return indexes;
  }

 private:
  std::size_t first_of_or_after(int frame) const {
    for (std::size_t i = 0; i < travels_.size(); ++i) {
      if (travels_[i].frame >= frame && !travels_[i].damaged) {
        return i;
      }
    }
    return kNever;
  }
  std::size_t all_there(int frame) const {
    std::set<std::size_t> indexes;
    for (std::size_t i = 0; i < travels_.size(); ++i) {
      if (travels_[i].frame == frame && !travels_[i].damaged) {
        indexes.insert(travels_[i].index);
        if (indexes.size() == kPackets) {
          return i;
        }
      }
    }
    return kNever;
  }

  const std::vector<Travel>& travels_;
  std::map<int, std::size_t> close_;
};

class Comparison {
 public:
  explicit Comparison(const std::vector<std::vector<Datagram>>& sent) : sent_(sent) {}

  void run(const std::vector<Travel>& travels) {
    const Oracle oracle(travels);
    Reassembler reassembler;
    for (std::size_t i = 0; i < travels.size(); ++i) {
      Datagram datagram = sent_[static_cast<std::size_t>(travels[i].frame)][travels[i].index];
      if (travels[i].damaged) {
        datagram[60] ^= std::byte{4};
      }
      reassembler.push(datagram, Time{});
      take_all(reassembler, oracle, i);
    }
    reassembler.expire(Time{} + std::chrono::hours(1));
    take_all(reassembler, oracle, kNever);
    compare_sums(travels, oracle, reassembler.statistics());
  }

 private:
  void take_all(Reassembler& reassembler, const Oracle& oracle, std::size_t place) {
    while (const std::optional<Frame> frame = reassembler.take()) {
      const int which = static_cast<int>(frame->stamp.number - kFirst);
      ASSERT_GE(which, 0);
      ASSERT_LT(which, kFrames);
      ASSERT_GT(which, last_) << "order";
      last_ = which;
      ASSERT_EQ(oracle.close(which), place) << "frame " << which;
      std::vector<Datagram> in_time;
      for (const std::size_t index : oracle.packets(which)) {
        in_time.push_back(sent_[static_cast<std::size_t>(which)][index]);
      }
      ASSERT_EQ(frame->missing_packets, kPackets - in_time.size()) << "frame " << which;
      ASSERT_TRUE(ExpectedImages(in_time, 300, 5).equal(*frame)) << "frame " << which;
      delivered_.insert(which);
    }
  }

  void compare_sums(const std::vector<Travel>& travels, const Oracle& oracle,
                    const Statistics& statistics) {
    std::uint64_t in_time = 0;
    std::uint64_t missing = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
      const std::size_t packets = oracle.packets(frame).size();
      ASSERT_EQ(delivered_.contains(frame), packets > 0) << "frame " << frame;
      in_time += packets;
      missing += packets > 0 ? kPackets - packets : 0;
    }
    const auto damaged = static_cast<std::uint64_t>(
        std::ranges::count_if(travels, [](const Travel& travel) { return travel.damaged; }));
    ASSERT_EQ(statistics.packets_ok, in_time);
    ASSERT_EQ(statistics.packets_missing, missing);
    ASSERT_EQ(statistics.bad_crc, damaged);
    ASSERT_EQ(statistics.duplicate + statistics.late, travels.size() - damaged - in_time);
    ASSERT_EQ(statistics.packets(), travels.size());
    ASSERT_EQ(statistics.frames_complete + statistics.frames_incomplete, delivered_.size());
    ASSERT_EQ(statistics.frames_lost,
              delivered_.empty()
                  ? 0U
                  : static_cast<std::size_t>(*delivered_.rbegin() - *delivered_.begin() + 1) -
                        delivered_.size());
  }

  const std::vector<std::vector<Datagram>>& sent_;
  std::set<int> delivered_;
  int last_ = -1;
};

TEST(RandomWeather, FramesAreExactlyWhatTheRulesSay) {
  std::vector<std::vector<Datagram>> sent;
  for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
    sent.push_back(
        test::datagrams({.number = kFirst + frame, .freshness = 1 + frame, .seed = frame}));
    ASSERT_EQ(sent.back().size(), kPackets);
  }
  const std::vector<Weather> weathers{{0, 0, 0, 0},    {0, 0, 0, 3},   {0, 10, 0, 13},
                                      {1, 1, 1, 6},    {5, 5, 2, 13},  {10, 10, 5, 20},
                                      {0, 0, 0, 26},   {2, 20, 0, 40}, {50, 5, 5, 13},
                                      {90, 10, 5, 30}, {3, 3, 3, 100}, {0, 50, 0, 200}};
  std::uint64_t seed = 0;
  for (const Weather& weather : weathers) {
    for (int round = 0; round < 60; ++round) {
      test::Random random(++seed);
      SCOPED_TRACE("seed " + std::to_string(seed));
      Comparison(sent).run(journey(weather, random));
      if (HasFatalFailure()) {
        return;
      }
    }
  }
}

}  // namespace
}  // namespace stof::client
