#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <frugal_nav/driver/pose_record.hpp>

namespace frugal_nav {
namespace {

constexpr std::size_t kLongestRecord = 1024;  // some thirty markers
constexpr std::size_t kLongestNumber = 24;
constexpr double kFarthest_m = 1000.0;       // farther is a lost decimal point
constexpr double kLargestAngle_rad = 100.0;  // a heading may count turns
constexpr double kLargestId = 100000.0;

/// Takes fields off the front of a text.
class Fields {
 public:
  explicit Fields(std::string_view text) : text_(text) {}

  bool isEmpty() const { return text_.empty(); }
  void skipBlanks() {
    while (!text_.empty() &&
           (text_.front() == ' ' || text_.front() == '\r' || text_.front() == '\n' || text_.front() == '\t'))
      text_.remove_prefix(1);
  }
  /// Drops all before the next pose may begin; the number of bytes dropped.
  std::size_t skipToPose() {
    const std::size_t skipped = std::min(text_.find('x'), text_.size());
    text_.remove_prefix(skipped);
    return skipped;
  }
  /// The number behind a field's letter, when both stand here.
  std::optional<double> take(char letter) {
    skipBlanks();
    if (text_.empty() || text_.front() != letter) return std::nullopt;
    text_.remove_prefix(1);
    const std::size_t length = std::min(text_.find_first_not_of("0123456789.+-eE"), text_.size());
    const std::string digits(text_.substr(0, std::min(length, kLongestNumber)));
    text_.remove_prefix(length);
    char* end = nullptr;
    const double value = std::strtod(digits.c_str(), &end);
    const bool is_whole = !digits.empty() && end == digits.c_str() + digits.size();
    return is_whole && length <= kLongestNumber ? std::optional<double>(value) : std::nullopt;
  }

 private:
  std::string_view text_;
};

std::optional<RecordedPose> takePose(Fields& fields) {
  std::array<double, 4> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::optional<double> value = fields.take("xyti"[i]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  const auto [x_m, y_m, yaw_rad, id] = values;
  const bool is_near = std::abs(x_m) <= kFarthest_m && std::abs(y_m) <= kFarthest_m;
  const bool is_id = id >= 0.0 && id <= kLargestId && id == std::floor(id);
  if (!is_near || !(std::abs(yaw_rad) <= kLargestAngle_rad) || !is_id) return std::nullopt;
  return RecordedPose{{x_m, y_m, wrapAngle(yaw_rad)}, static_cast<int>(id)};
}

}  // namespace

std::vector<std::vector<RecordedPose>> PoseRecordReader::read(std::string_view bytes) {
  std::vector<std::vector<RecordedPose>> records;
  for (const char byte : bytes) {
    if (byte != '#') {
      if (record_.size() < kLongestRecord) {
        record_ += byte;
      } else {
        is_too_long_ = true;
        ++counts_.skipped_bytes;
      }
      continue;
    }
    std::vector<RecordedPose> poses;
    if (is_too_long_) {
      counts_.skipped_bytes += record_.size();
    } else {
      poses = parse(record_);
    }
    record_.clear();
    is_too_long_ = false;
    ++(poses.empty() ? counts_.bad_records : counts_.records);
    counts_.poses += poses.size();
    if (!poses.empty()) records.push_back(std::move(poses));
  }
  return records;
}

std::vector<RecordedPose> PoseRecordReader::parse(std::string_view record) {
  std::vector<RecordedPose> poses;
  Fields fields(record);
  for (fields.skipBlanks(); !fields.isEmpty(); fields.skipBlanks()) {
    const std::size_t skipped = fields.skipToPose();
    counts_.skipped_bytes += skipped;
    if (fields.isEmpty()) break;
    if (const auto pose = takePose(fields)) {
      poses.push_back(*pose);
    } else {
      ++counts_.bad_poses;
    }
  }
  return poses;
}

}  // namespace frugal_nav
