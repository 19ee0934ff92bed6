#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/driver/pose_record.hpp>

namespace frugal_nav {
namespace {

using Records = std::vector<std::vector<RecordedPose>>;

TEST(PoseRecord, ReadsThePapersRecord) {
  PoseRecordReader reader;
  const Records records = reader.read("x0.52y1.34t0.98i7x-0.50y1.3t-0.97i12 #");
  ASSERT_EQ(records.size(), 1U);
  ASSERT_EQ(records[0].size(), 2U);
  EXPECT_DOUBLE_EQ(records[0][0].map_from_base.x_m, 0.52);
  EXPECT_DOUBLE_EQ(records[0][0].map_from_base.y_m, 1.34);
  EXPECT_DOUBLE_EQ(records[0][0].map_from_base.yaw_rad, 0.98);
  EXPECT_EQ(records[0][0].marker_id, 7);
  EXPECT_DOUBLE_EQ(records[0][1].map_from_base.x_m, -0.50);
  EXPECT_EQ(records[0][1].marker_id, 12);
  EXPECT_EQ(reader.counts().skipped_bytes, 0U);
  EXPECT_EQ(reader.counts().poses, 2U);
}

TEST(PoseRecord, BytesMayComeInAnyPieces) {
  PoseRecordReader reader;
  const std::string text = "x1.0y2.0t0.1i1 #\r\nx1.1y2.1t0.2i2 #\n";
  Records records;
  for (const char byte : text) {
    for (const auto& record : reader.read(std::string_view(&byte, 1))) records.push_back(record);
  }
  ASSERT_EQ(records.size(), 2U);
  EXPECT_DOUBLE_EQ(records[1][0].map_from_base.y_m, 2.1);
}

TEST(PoseRecord, AHeadingIsWrapped) {
  PoseRecordReader reader;
  const Records records = reader.read("x0y0t6.2831853i0#");
  ASSERT_EQ(records.size(), 1U);
  EXPECT_NEAR(records[0][0].map_from_base.yaw_rad, 0.0, 1e-6);
}

TEST(PoseRecord, GarbageIsCountedAndLeftOut) {
  PoseRecordReader reader;
  // The end of a record, a boot message, a sound one, one with a lost letter, one that is only garbage.
  const Records records = reader.read(
      "4t0.9i3 #Ready.\n#x0.5y1.0t0.2i4 #x0.5 1.0t0.2i4x0.6y1.0t0.2i5 #"
      "\xff\xfe??#");
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(records[0][0].marker_id, 4);
  ASSERT_EQ(records[1].size(), 1U);
  EXPECT_EQ(records[1][0].marker_id, 5);
  EXPECT_EQ(reader.counts().bad_records, 3U);
  EXPECT_EQ(reader.counts().bad_poses, 1U);
  EXPECT_GT(reader.counts().skipped_bytes, 10U);
}

TEST(PoseRecord, NumbersThatAreNoneAreNoPose) {
  PoseRecordReader reader;
  for (const char* bad :
       {"x0.5.2y1t0i1#", "xy1t0i1#", "xnany1t0i1#", "x1e9y1t0i1#", "x1y1t1e5i1#", "x1y1t0i-1#", "x1y1t0i1.5#",
        "x1y1t0#", "x1y1i1t0#", "x--1y1t0i1#", "xinfy0t0i1#", "x0.0000000000000000000000000001y1t0i1#"}) {
    EXPECT_TRUE(reader.read(bad).empty()) << bad;
  }
  EXPECT_EQ(reader.counts().bad_records, 12U);
  EXPECT_EQ(reader.read("x1y1t0i1#").size(), 1U);
}

TEST(PoseRecord, ARecordWithoutAnEndTakesNoMemory) {
  PoseRecordReader reader;
  EXPECT_TRUE(reader.read(std::string(100000, 'x')).empty());
  EXPECT_TRUE(reader.read("x1y1t0i1#").empty()) << "its end";
  EXPECT_EQ(reader.counts().bad_records, 1U);
  EXPECT_EQ(reader.read("x1y1t0i1#").size(), 1U);
}

TEST(PoseRecord, ALineThatFlipsBitsIsSurvived) {
  Random random(500004);
  const std::string record = "x0.52y1.34t0.98i7x0.50y1.31t0.97i9 #\n";
  PoseRecordReader reader;
  std::size_t sound = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = record;
    if (i % 2 == 0) {
      const auto place = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(text.size() - 1)));
      text[place] = static_cast<char>(random.uniform(0.0, 255.0));
    }
    for (const auto& poses : reader.read(text)) {
      sound += poses.size() == 2 ? 1U : 0U;
      for (const RecordedPose& pose : poses) ASSERT_TRUE(pose.map_from_base.isFinite());
    }
  }
  // A record that lost its # takes the next one with it, as poses of its own: the others come through whole.
  EXPECT_GT(sound, 900U);
}

}  // namespace
}  // namespace frugal_nav
