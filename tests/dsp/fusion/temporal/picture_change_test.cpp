#include "dsp/fusion/temporal/picture_change.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

class Picture {
 public:
  Picture(int width, int height)
      : grey_(width, height, width + 3, 100),
        change_([&](Arena& arena) { return PictureChange(width, height, arena); }) {}
  ImageView<std::uint8_t> grey() { return grey_.view(); }
  PictureChange& change() { return *change_; }
  void fill(int x0, int y0, int x1, int y1, int level) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        grey().at(x, y) = static_cast<std::uint8_t>(level);
      }
    }
  }
  // Which marks count; at first those of cells.
  void ask_for(PictureChange::Mark mark) { mark_ = mark; }
  bool look() { return change_->look(grey()); }
  std::vector<std::uint8_t> row(int y) {
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(grey().width()));
    change_->mark(y, pixels);
    for (std::uint8_t& pixel : pixels) {
      pixel &= mark_;
    }
    return pixels;
  }
  int changed_pixels() {
    int count = 0;
    for (int y = 0; y < grey().height(); ++y) {
      for (const std::uint8_t pixel : row(y)) {
        count += pixel != 0 ? 1 : 0;
      }
    }
    return count;
  }

 private:
  test::GuardedImage<std::uint8_t> grey_;
  test::GuardedPart<PictureChange> change_;
  std::uint8_t mark_ = PictureChange::kCell;
};

TEST(PictureChange, IsFeltTwoCellsAround) {
  Picture picture(80, 60);
  EXPECT_FALSE(picture.look());  // the first
  EXPECT_EQ(picture.changed_pixels(), 0);
  picture.fill(40, 32, 44, 36, 110);
  EXPECT_TRUE(picture.look());
  for (int y = 0; y < 60; ++y) {
    const std::vector<std::uint8_t> row = picture.row(y);
    for (int x = 0; x < 80; ++x) {
      const bool near = x >= 32 && x < 52 && y >= 24 && y < 44;
      ASSERT_EQ(row[static_cast<std::size_t>(x)] != 0, near) << x << " " << y;
    }
  }
  EXPECT_TRUE(picture.look());  // it stays as it is now
  EXPECT_EQ(picture.changed_pixels(), 0);
}

TEST(PictureChange, OfOnePixelIsFeltBesideIt) {
  Picture picture(80, 60);
  picture.ask_for(PictureChange::kPixel);
  picture.look();
  for (const int level : {113, 126, 113}) {
    picture.grey().at(79, 32) = static_cast<std::uint8_t>(level);
    picture.grey().at(40, 0) = static_cast<std::uint8_t>(level);
    EXPECT_TRUE(picture.look());
    EXPECT_EQ(picture.changed_pixels(), 3 * 2 + 3 * 2);
    EXPECT_NE(picture.row(31)[78], 0);
    EXPECT_NE(picture.row(1)[41], 0);
    EXPECT_TRUE(picture.look());
    EXPECT_EQ(picture.changed_pixels(), 0);
  }
}

TEST(PictureChange, SlowChangesAddUp) {
  Picture picture(80, 60);
  picture.look();
  int felt = 0;
  for (int level = 101; level <= 120; ++level) {
    picture.fill(40, 32, 44, 36, level);
    EXPECT_TRUE(picture.look());
    felt += picture.changed_pixels() > 0 ? 1 : 0;
  }
  EXPECT_EQ(felt, 4);  // every five levels
}

TEST(PictureChange, OfAQuarterOfThePictureIsTheCameras) {
  Picture picture(80, 64);
  picture.look();
  picture.fill(0, 0, 80, 16, 120);
  EXPECT_TRUE(picture.look());
  picture.fill(0, 0, 80, 16, 140);
  picture.fill(0, 32, 4, 36, 140);
  EXPECT_FALSE(picture.look());
  EXPECT_EQ(picture.changed_pixels(), 0);
  EXPECT_TRUE(picture.look());
  picture.change().forget();
  EXPECT_FALSE(picture.look());
}

TEST(PictureChange, NoiseIsNone) {
  Picture picture(160, 120);
  test::Random random(1);
  int felt = 0;
  for (int frame = 0; frame < 30; ++frame) {
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        // A variance of 4.7, that of a well lit pixel.
        int noise = 0;
        for (int k = 0; k < 7; ++k) {
          noise += random.between(-1, 1);
        }
        picture.grey().at(x, y) = static_cast<std::uint8_t>(100 + noise);
      }
    }
    EXPECT_EQ(picture.look(), frame > 0);
    felt += picture.changed_pixels();
  }
  EXPECT_LT(felt, 30 * 160 * 120 / 500);
}

TEST(PictureChange, TakesAnySize) {
  for (const int width : {1, 3, 4, 5, 7, 8, 33}) {
    for (const int height : {1, 3, 4, 5, 9}) {
      Picture picture(width, height);
      picture.look();
      EXPECT_EQ(picture.look(), width >= 4) << width << "x" << height;
      picture.fill(0, 0, width, height, 200);
      EXPECT_FALSE(picture.look());
      EXPECT_EQ(picture.changed_pixels(), 0);
    }
  }
}

}  // namespace
}  // namespace stof::dsp
