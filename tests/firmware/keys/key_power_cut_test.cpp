#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "firmware/keys/keyring.h"
#include "hal/linux/system/file_store.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/support/power_cut.h"

namespace stof::keys {
namespace {

using hal::linux::FileStore;
using test::numbered_key;
using test::power;

// A sensor's key file on a disk.
class Life {
 public:
  explicit Life(std::string name)
      : name_(std::move(name)),
        store_(name_, FileStore::Readers::kOwner),
        aside_(name_ + ".bad", FileStore::Readers::kOwner) {}

  Keyring start() {
    Keyring ring(&store_, &aside_);
    std::array<char, 320> space;
    settings::PagedWriter line(space);
    ring.load(name_, line);
    told = line.text();
    return ring;
  }
  void damage() const { std::ofstream(name_, std::ios::trunc) << "damaged"; }
  // What was renamed before it was flushed is lost.
  static void power_comes_back() {
    if (!power.unflushed.empty()) {
      std::ofstream(power.unflushed, std::ios::trunc).close();
    }
    power = {};
  }
  // No file beside it that others may read, whatever became of it.
  void expect_private() const {
    for (const char* const ending : {"", ".new", ".bad", ".bad.new"}) {
      struct stat found{};
      if (::lstat((name_ + ending).c_str(), &found) == 0) {
        EXPECT_EQ(found.st_mode & 0777U, 0600U) << ending;
      }
    }
  }

  std::string told;

 private:
  std::string name_;
  FileStore store_;
  FileStore aside_;
};

class KeyPowerCut : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "stof_keys_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder_.data()), nullptr);
    old_mask_ = ::umask(0);  // nothing helps
    power = {};
  }
  void TearDown() override {
    ::umask(old_mask_);
    std::filesystem::remove_all(folder_);
  }

  std::string folder_;
  mode_t old_mask_ = 0;
};

bool same(const wire::KeyTable& a, const wire::KeyTable& b) {
  return std::ranges::equal(a.all(), b.all());
}

TEST_F(KeyPowerCut, AtEveryWriteLeavesOldOrNewAndNothingToTell) {
  Life life(folder_ + "/keys");
  int points = 0;
  int old = 0;
  for (std::uint32_t change = 1; points < 600; change += 10) {
    for (int cut = 0;; ++cut) {
      Keyring ring = life.start();
      while (ring.keys().count() > 0) {
        ASSERT_EQ(ring.remove(ring.keys().all()[0].id), Status::kOk);
      }
      ASSERT_EQ(ring.add(numbered_key(change)), Status::kOk);
      ASSERT_EQ(ring.add(numbered_key(change + 1)), Status::kOk);
      const wire::KeyTable before = ring.keys();
      wire::KeyTable after = before;
      power = {.calls_left = cut};
      Status done{};
      switch (cut % 3) {
        case 0:
          static_cast<void>(after.add(numbered_key(change + 2)));
          done = ring.add(numbered_key(change + 2));
          break;
        case 1:
          after.remove(change);
          done = ring.remove(change);
          break;
        default: {
          wire::Key key = numbered_key(change + 1);
          after.remove(key.id);
          key.former = key.secret;
          key.secret = numbered_key(7).secret;
          static_cast<void>(after.add(key));
          done = ring.replace(key.id, key.secret, Shown::kFormer);
        }
      }
      const bool was_cut = power.cut;
      EXPECT_EQ(done == Status::kOk, !was_cut);
      EXPECT_TRUE(same(ring.keys(), was_cut ? before : after));
      Life::power_comes_back();
      const Keyring started = life.start();
      ASSERT_EQ(life.told, "");
      ASSERT_TRUE(same(started.keys(), before) || same(started.keys(), after)) << cut;
      life.expect_private();
      if (!was_cut) {
        break;
      }
      ++points;
      old += same(started.keys(), before) ? 1 : 0;
    }
  }
  EXPECT_GT(old, 100);
  EXPECT_LT(old, points);
  std::printf("%d cuts, %d of them left what was before\n", points, old);
}

TEST_F(KeyPowerCut, OfADamagedFileLeavesItOrTheNewKeyAndNeverASensorForEverybody) {
  Life life(folder_ + "/keys");
  int lost = 0;
  for (int cut = 0;; ++cut) {
    life.damage();
    Keyring ring = life.start();
    ASSERT_EQ(ring.pairing(), Pairing::kLost);
    power = {.calls_left = cut};
    const Status done = ring.add(numbered_key(1));
    const bool was_cut = power.cut;
    Life::power_comes_back();
    const Pairing pairing = life.start().pairing();
    ASSERT_NE(pairing, Pairing::kUnpaired) << cut;
    life.expect_private();
    lost += pairing == Pairing::kLost ? 1 : 0;
    if (!was_cut) {
      EXPECT_EQ(done, Status::kOk);
      EXPECT_EQ(pairing, Pairing::kPaired);
      break;
    }
  }
  EXPECT_GT(lost, 4);
  std::ifstream kept(folder_ + "/keys.bad");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(kept), {}), "damaged");
}

}  // namespace
}  // namespace stof::keys
