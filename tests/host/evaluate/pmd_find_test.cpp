#include <algorithm>

#include "host/calibrate/calibration_store.h"
#include "host/evaluate/pmd/figures.h"
#include "host/evaluate/pmd/recordings/find.h"
#include "tests/dataset/scratch.h"
#include "tests/host/evaluate/pmd_recordings.h"

namespace stof::host {
namespace {

using test::Board;
using test::record;
using test::SimulatedCamera;

class PmdFind : public test::Scratch {
 protected:
  std::filesystem::path in(const char* name) const {
    std::filesystem::path made = folder() / name;
    std::filesystem::create_directories(made);
    return made;
  }
  const PmdSet* set_of(const PmdFolders& found, PmdKind kind) const {
    const auto set = std::ranges::find(found.sets, kind, &PmdSet::kind);
    return set == found.sets.end() ? nullptr : &*set;
  }
  SimulatedCamera camera_;
};

TEST_F(PmdFind, TellsKindsFromFilesAndFields) {
  test::put_wall(in("walls"), record(camera_, 1, 1, 1), ", \"camera_seed\": 3");
  test::put_wall(in("side"), record(camera_, 1, 1, 1), ", \"emitters\": [[0.1, 0, 0]]");
  test::put_wall(in("both"), record(camera_, 1, 1, 1),
                 ", \"emitters\": [[0.1, 0, 0], [-0.1, 0, 0]]");
  test::write_edge(in("edge"), "edge", camera_, Board{});
  host::WallRecording frequency = record(camera_, 3, 1, 1);
  frequency.name = "b";
  test::put_wall(in("tones"), frequency, ", \"pair\": [25e6, 30e6]");
  camera_.f_mod_hz = 25'000'000;
  frequency = record(camera_, 3, 1, 1);
  frequency.name = "c";
  test::put_wall(in("tones"), frequency, ", \"pair\": [25e6, 30e6]");
  test::write_frame(in("frame"));
  put("walls/32x24_fppn.pgm", "P5\n");
  const dataset::Loaded<PmdFolders> found = find_pmd(folder());
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->sets.size(), 6U);
  EXPECT_EQ(set_of(*found, PmdKind::kLights)->folder, folder() / "side");
  EXPECT_EQ(set_of(*found, PmdKind::kEdge)->prefixes, std::vector{folder() / "edge" / "edge"});
  // The first frequency of "pair" first.
  EXPECT_EQ(set_of(*found, PmdKind::kFrequencies)->prefixes,
            (std::vector{folder() / "tones" / "c", folder() / "tones" / "b"}));
  EXPECT_NE(set_of(*found, PmdKind::kFrame), nullptr);
  EXPECT_EQ(std::ranges::count(found->sets, PmdKind::kWalls, &PmdSet::kind), 2);
  EXPECT_EQ(found->sources.patterns.at({"32x24", 3}), folder() / "walls" / "32x24_fppn.pgm");
  EXPECT_TRUE(found->notes.empty());
}

TEST_F(PmdFind, NamesWhatACalibrationIsNotUsedWith) {
  test::put_wall(in("walls"), record(camera_, 1, 1, 1));
  dsp::Calibration rig;
  rig.pmd = record(camera_, 1, 1, 1).recording.calibration.pmd;
  const auto notes = [this, &rig] {
    EXPECT_TRUE(write_calibration(folder() / "some.cal", rig));
    const auto found = evaluate_pmd(
        {.folder = folder(), .calibration = folder() / "some.cal", .phase_samples = 1000});
    std::string all = found ? "" : found.error().message;
    for (const std::string& note : found ? found->notes : std::vector<std::string>()) {
      all += note + "\n";
    }
    return all;
  };
  EXPECT_EQ(notes().find("the calibration is not used"), std::string::npos) << notes();
  rig.pmd.lens.width = 64;
  EXPECT_NE(notes().find("walls: the calibration is not used with 1 of"), std::string::npos)
      << notes();
  rig.pmd.lens.width = 0;
  rig.pmd.lens.height = 0;
  EXPECT_NE(notes().find("some.cal: holds no PMD camera"), std::string::npos) << notes();
}

TEST_F(PmdFind, NamesWhatHasNoSceneOrNoSecondFrequency) {
  test::put_wall(in("walls"), record(camera_, 1, 1, 1));
  host::WallRecording one = record(camera_, 3, 1, 1);
  one.name = "alone";
  test::put_wall(in("tones"), one, ", \"pair\": [30e6, 25e6]");
  put("odd/blank.json", "{\"width\": 4}");
  put("odd/blank_raw.pgm", "");
  const dataset::Loaded<PmdFolders> found = find_pmd(folder());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->sets.size(), 1U);
  ASSERT_EQ(found->notes.size(), 2U);
  EXPECT_NE(found->notes[0].find("blank"), std::string::npos);
  EXPECT_NE(found->notes[1].find("alone: its second frequency is absent"), std::string::npos);
}

TEST_F(PmdFind, RefusesWhatIsNoFolderOfRecordings) {
  test::expect_one_line_about(find_pmd(folder() / "absent").error().message, folder() / "absent",
                              "is not a folder");
  test::expect_one_line_about(find_pmd(folder()).error().message, folder(), "no PMD recording");
  put("bad.json", "[");
  put("bad_raw.pgm", "");
  test::expect_one_line_about(find_pmd(folder()).error().message, folder() / "bad.json",
                              "not a JSON object");
}

TEST(MixedPixels, AreThoseInWhichTwoSurfacesMeet) {
  RangeMaps maps{.nearest = dataset::Image<float>(9, 7), .middle = {}, .farthest = {}};
  maps.farthest = maps.nearest;
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 9; ++x) {
      // A slope of 4 cm a pixel; column 3 reaches 50 cm further.
      maps.nearest.view().at(x, y) = 1 + 0.04F * static_cast<float>(x);
      maps.farthest.view().at(x, y) =
          1.04F + 0.04F * static_cast<float>(x) + (x == 3 ? 0.5F : 0.0F);
    }
  }
  const dataset::Image<std::uint8_t> mixed = mixed_pixels(maps);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 9; ++x) {
      EXPECT_EQ(mixed.view().at(x, y), x == 3 ? 1 : 0) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace stof::host
