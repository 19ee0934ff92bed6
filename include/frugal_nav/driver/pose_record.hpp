#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <frugal_nav/common/geometry.hpp>

namespace frugal_nav {

/// One pose of a record: where the robot is by one marker.
struct RecordedPose {
  Pose2 map_from_base;
  int marker_id = 0;
};

/// What was met on the line.
struct PoseRecordCounts {
  std::uint64_t records = 0;        ///< that held a pose
  std::uint64_t poses = 0;          ///< in them
  std::uint64_t bad_poses = 0;      ///< with a field that is missing, no number or out of range
  std::uint64_t bad_records = 0;    ///< without a single sound pose, or too long
  std::uint64_t skipped_bytes = 0;  ///< that belong to no pose
};

/// Reads the record by which the robot of paper 001 passes its poses from the camera's computer to the
/// motors' (there by USB serial):
///
///     x0.52y1.34t0.98i7x0.50y1.31t0.97i9 #
///
/// Metres, radians and the marker's id, once for each marker, and a # at the end. Blanks between the fields
/// and before the # do not matter. A line is no safe channel: bytes may be lost, doubled or wrong, and a
/// reader may start in the middle of a record; what is no pose is counted and left out.
class PoseRecordReader {
 public:
  /// Takes the next bytes, however they are cut, and gives the poses of each record that ends in them.
  std::vector<std::vector<RecordedPose>> read(std::string_view bytes);

  const PoseRecordCounts& counts() const { return counts_; }

 private:
  std::vector<RecordedPose> parse(std::string_view record);

  std::string record_;        ///< what has come of the present one
  bool is_too_long_ = false;  ///< its end is awaited
  PoseRecordCounts counts_;
};

}  // namespace frugal_nav
