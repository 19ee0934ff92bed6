#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

struct RollingGridParams {
  double window_m = 10.0;
  double cell_m = 0.05;
  int hit_gain = 4;
  int miss_loss = 1;
  int max_certainty = 12;
  double memory_s = 20.0;
  double max_range_m = 12.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("window_m", window_m,
          Field{"m", "side of the square window around the robot; a room, or half the range each way", 1.0,
                50.0});
    visit("cell_m", cell_m, Field{"m", "side of a cell; a fifth of the robot's width", 0.01, 0.5});
    visit(
        "hit_gain", hit_gain,
        Field{"", "certainty a cell gains in a scan that hits it; the first hit already makes it an obstacle",
              1, 100});
    visit(
        "miss_loss", miss_loss,
        Field{"",
              "certainty a cell loses in a scan that looks through it; a quarter of hit_gain keeps thin legs "
              "that every fourth scan hits",
              1, 100});
    visit(
        "max_certainty", max_certainty,
        Field{"",
              "certainty saturates here: so many times miss_loss, and the longest seen obstacle is forgotten",
              1, 120});
    visit("memory_s", memory_s,
          Field{"s", "a cell that leaves the view is remembered this long; short, since odometry drifts", 0.1,
                3600.0});
    visit("max_range_m", max_range_m,
          Field{"m", "rays longer than this neither mark nor clear beyond it", 0.5, 100.0});
  }
  /// Names fields that contradict each other; empty when sound.
  std::string check() const;
};

/// Index of a grid cell: floor(coordinate / cell size), the same for a place wherever the window stands.
struct Cell {
  int x = 0;
  int y = 0;
};

inline bool operator==(const Cell& a, const Cell& b) { return a.x == b.x && a.y == b.y; }
inline bool operator!=(const Cell& a, const Cell& b) { return !(a == b); }

/// A window of cells that follows the robot through the odom frame and remembers for a short time what scans
/// saw.
///
/// Each cell holds a certainty (the histogrammic grid of Borenstein and Koren, 1991, with free space told
/// from unknown) and the time of its last observation. The cells lie in a ring buffer in both directions:
/// moving the window forgets the rows and columns that leave it and copies nothing.
class RollingGrid {
 public:
  enum class State : std::uint8_t { kUnknown, kFree, kOccupied };

  explicit RollingGrid(const RollingGridParams& params);

  /// Other parameters from now on; another window or cell size forgets everything. Throws ConfigError.
  void setParams(const RollingGridParams& params);

  /// Centres the window on a point of the odom frame, by whole cells.
  void moveTo(const Eigen::Vector2d& p_odom);

  /// Takes a scan in: rays clear, hits mark. +inf clears up to max_range_m, NaN does nothing, -inf marks at
  /// range_min (REP-117). The scan's stamp becomes the present for the memory.
  void insert(const LaserScan& scan, const Pose2& odom_from_laser);

  // The parts of insert(), for sensors that say more of their rays than a scan holds.
  /// A new sight: its stamp becomes the present for the memory.
  void begin(Stamp stamp);
  /// An obstacle, once a sight. To be called before clear(): what this sight marks it does not clear.
  void mark(const Eigen::Vector2d& p_odom);
  /// Free space along a ray, with or without the cell it ends in.
  void clear(const Eigen::Vector2d& from_odom, const Eigen::Vector2d& to_odom, bool include_end);
  /// The same without the cell it ends in; obstacles more certain than this stay.
  void clearDoubtful(const Eigen::Vector2d& from_odom, const Eigen::Vector2d& to_odom, int most_certain);
  /// Obstacles within a radius that are no more certain than this are gone, as if seen free now.
  void erase(const Eigen::Vector2d& p_odom, double radius_m, int most_certain);

  /// Forgets everything.
  void reset();

  /// Whether a pose is finite and near enough for cells to be counted.
  static bool holds(const Pose2& pose);

  /// What is known of a cell now; outside the window nothing is.
  State state(Cell cell) const;
  /// Certainty that a cell is an obstacle, 0 .. max_certainty.
  int certainty(Cell cell) const;

  /// Where a cell of the window is kept in a ring of size() * size() entries, row by row: it stays there as
  /// the window moves.
  int ringIndex(Cell cell) const;
  /// The states of the window's row `y` (cell index), from origin().x on, size() of them.
  void copyRow(int y, State* row) const;

  int size() const { return size_; }                ///< cells along a side
  double cell_m() const { return params_.cell_m; }  ///< side of a cell
  Cell origin() const { return origin_; }           ///< the window's cell with the lowest indices
  bool contains(Cell cell) const;
  Cell cellOf(const Eigen::Vector2d& p_odom) const;
  Eigen::Vector2d centerOf(Cell cell) const;

 private:
  struct Entry {
    std::int8_t certainty = 0;
    bool seen = false;
    std::uint16_t scan = 0;          ///< number of the scan that touched it last
    std::uint32_t last_seen_ms = 0;  ///< since epoch_
  };

  /// Calls `visit` for each cell of a ray that this sight has not touched yet.
  template <class Visit>
  void visitRay(const Eigen::Vector2d& from_odom, const Eigen::Vector2d& to_odom, bool include_end,
                const Visit& visit);
  Entry& entry(Cell cell) { return entries_[static_cast<std::size_t>(ringIndex(cell))]; }
  const Entry& entry(Cell cell) const { return entries_[static_cast<std::size_t>(ringIndex(cell))]; }
  State stateOf(const Entry& entry) const;
  bool isForgotten(const Entry& entry) const;
  void forgetColumns(int first_x, int count);
  void forgetRows(int first_y, int count);
  void touch(Entry& entry);

  RollingGridParams params_;
  int size_;
  Cell origin_;
  std::vector<Entry> entries_;
  bool started_ = false;
  Stamp epoch_{};
  std::uint32_t now_ms_ = 0;
  std::uint32_t memory_ms_;
  std::uint16_t scan_number_ = 0;
};

}  // namespace frugal_nav
