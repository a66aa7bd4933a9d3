#include <bit>
#include <cmath>
#include <fstream>

#include "host/evaluate/ifm/frame.h"
#include "host/evaluate/ifm/frame_file.h"
#include "host/evaluate/pmd/phase.h"
#include "host/evaluate/pmd/rank_correlation.h"
#include "tests/dataset/scratch.h"
#include "tests/host/evaluate/pmd_recordings.h"

namespace stof::host {
namespace {

void put_u32(std::string& bytes, std::uint32_t value) {
  for (unsigned i = 0; i < 4; ++i) {
    bytes += static_cast<char>(value >> (8 * i) & 255U);
  }
}

std::string chunk(std::uint32_t type, int width, int height, std::uint32_t format,
                  const std::string& pixels) {
  std::string bytes;
  for (const std::size_t field :
       {std::size_t{type}, 48 + pixels.size(), std::size_t{48}, std::size_t{2},
        static_cast<std::size_t>(width), static_cast<std::size_t>(height), std::size_t{format}}) {
    put_u32(bytes, static_cast<std::uint32_t>(field));
  }
  bytes.resize(48);
  return bytes + pixels;
}

TEST(PcicChunks, AreFoundInTheirOrder) {
  const std::string buffer =
      "0000star" + chunk(100, 2, 1, 2, "abcd") + chunk(300, 2, 1, 0, "xy") + "stop\r\n";
  const dataset::Loaded<std::vector<PcicChunk>> found = pcic_chunks(buffer, "file");
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->size(), 2U);
  EXPECT_EQ((*found)[0].type, 100U);
  EXPECT_EQ((*found)[0].size, 52U);
  EXPECT_EQ((*found)[1].type, 300U);
  EXPECT_EQ((*found)[1].at, 8U + 52U);
}

TEST(PcicChunks, ThatEndEarlyOrContradictThemselvesAreRefused) {
  const std::string whole = "0000star" + chunk(100, 2, 1, 2, "abcd");
  for (std::size_t size = 9; size < whole.size(); ++size) {
    EXPECT_FALSE(pcic_chunks(whole.substr(0, size), "file")) << size;
  }
  EXPECT_TRUE(pcic_chunks(whole, "file"));
  EXPECT_FALSE(pcic_chunks("nothing", "file"));
  EXPECT_FALSE(pcic_chunks("0000starstop", "file"));
  std::string endless = whole;
  endless[12] = 0;  // a chunk of size 0 would never end
  EXPECT_FALSE(pcic_chunks(endless, "file"));
}

TEST(RankCorrelation, IsSpearmans) {
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3, 4}, {10, 20, 40, 30}), 0.8);
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3}, {9, 5, 1}), -1);
  EXPECT_DOUBLE_EQ(rank_correlation({1, 1, 2, 2}, {5, 5, 7, 7}), 1);
  EXPECT_TRUE(std::isnan(rank_correlation({1}, {1})));
  EXPECT_TRUE(std::isnan(rank_correlation({1, 1}, {1, 2})));
}

TEST(PhaseScore, IsBelowOneLsbAndTheKernelsAreEqual) {
  const PhaseScore score = score_phase(100'000);
  EXPECT_EQ(score.pixels, 100'000);
  EXPECT_TRUE(score.kernels_equal);
  EXPECT_LE(score.largest_lsb, 0.7);
  EXPECT_GT(score.largest_lsb, 0.5);  // rounding alone makes half an LSB
  EXPECT_EQ(score_phase(1000).largest_lsb, score_phase(1000).largest_lsb);
}

class CameraFrames : public test::Scratch {};

TEST_F(CameraFrames, BecomeACloudWithinAMillimetreOfTheExactOne) {
  test::write_frame(folder());
  const dataset::Loaded<FrameStudy> found = study_frame(folder());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->valid, 24 * 16 - 1);
  EXPECT_EQ(found->exact.pixels, found->valid);
  EXPECT_LE(found->exact.largest_m, 0.0004);
  EXPECT_GT(found->exact.largest_m, 0.00005);  // quarter millimetres do not vanish
  EXPECT_FALSE(found->camera);
  EXPECT_GT(found->rank_correlation, 0.99);
}

TEST_F(CameraFrames, NoiseThatGrowsWithTheAmplitudeIsNotCalledAlike) {
  test::write_frame(folder(), true);
  const dataset::Loaded<FrameStudy> found = study_frame(folder());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(found->rank_correlation, -0.99);
}

// The camera's own cloud is a chunk of floats here, off by 3 cm in one coordinate of one pixel.
TEST_F(CameraFrames, AreComparedWithTheCamerasOwnCloud) {
  test::write_frame(folder());
  const dsp::Pinhole lens = test::frame_lens();
  std::string buffer = "0000star";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::string pixels;
    for (int i = 0; i < lens.width * lens.height; ++i) {
      const double radial = 0.0002 * (5000 + 7 * i);
      const double off = axis == 1 && i == 100 ? 0.03 : 0;
      const int u = i % lens.width;
      const int v = i / lens.width;
      const std::array<double, 3> ray = dsp::unit_ray(lens, u, v);
      put_u32(pixels, std::bit_cast<std::uint32_t>(static_cast<float>(radial * ray[axis] + off)));
    }
    buffer += chunk(static_cast<std::uint32_t>(200 + axis), lens.width, lens.height, 6, pixels);
  }
  put("O3RBuffer.data", buffer + "stop");
  const dataset::Loaded<FrameStudy> found = study_frame(folder());
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_TRUE(found->camera);
  EXPECT_TRUE(found->has_cartesian);
  EXPECT_NEAR(found->camera->largest_m, 0.03, 0.0005);
  EXPECT_LE(found->camera->median_m, 0.0004);
  EXPECT_FALSE(found->same_distances);  // the buffer has no radial distances
}

TEST_F(CameraFrames, ThatAreBadAreRefusedInOneLine) {
  test::write_frame(folder());
  put("O3RBuffer.data", "nothing");
  test::expect_one_line_about(study_frame(folder()).error().message, folder() / "O3RBuffer.data",
                              "star");
  std::filesystem::remove(folder() / "O3RBuffer.data");
  put("info.json", "{}");
  test::expect_one_line_about(study_frame(folder()).error().message, folder() / "info.json",
                              "intrinsics");
}

}  // namespace
}  // namespace stof::host
