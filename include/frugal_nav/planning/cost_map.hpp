#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/astar.hpp>
#include <frugal_nav/planning/body_extent.hpp>
#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {

struct CostMapParams {
  double lethal_margin_m = 0.08;
  double inflation_m = 0.60;
  double clearance_weight = 4.0;
  double unknown_weight = 2.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("lethal_margin_m", lethal_margin_m,
          Field{"m",
                "room beside the body's half width below which the path never passes an obstacle; brings the "
                "sum near the circumradius, so that the robot can turn anywhere on its path",
                0.0, 1.0});
    visit("inflation_m", inflation_m,
          Field{"m",
                "distance from an obstacle at which nearness stops to cost; about twice the half of a door",
                0.1, 3.0});
    visit(
        "clearance_weight", clearance_weight,
        Field{
            "",
            "extra cost of a metre at the lethal distance, falling with the square to zero at inflation_m; 4 "
            "makes a detour of a metre worth it around a tight place",
            0.0, 14.0});
    visit(
        "unknown_weight", unknown_weight,
        Field{"",
              "cost of a metre through cells never seen, relative to free ones: passable, but not preferred",
              1.0, 16.0});
  }
};

/// The traversal weights of a rolling grid for one body: lethal near obstacles, falling cost beyond.
class CostMap {
 public:
  /// Between `tight_margin_m` and lethal_margin_m cells are passable at the highest weight; without it
  /// lethal.
  CostMap(const CostMapParams& params, const BodyExtent& body, const RollingGrid& grid,
          double tight_margin_m = HUGE_VAL);

  /// Reads the grid anew. Where the start itself is lethally near an obstacle, the cells around it that are
  /// no nearer to one become passable at the highest weight, so that the robot can leave.
  /// Cells never seen count as part of an obstacle that is nearer than `assumed_depth_m`: it has a far side.
  void update(const RollingGrid& grid, Cell start, double assumed_depth_m = 0.0);
  /// The same, but obstacles no more certain than this, nor beside one that is, and farther than a distance
  /// from the start count as never seen.
  void updateCertain(const RollingGrid& grid, Cell start, int most_doubtful, double from_m);

  /// Makes everything but the surroundings of a path dearer by `surcharge` (0.1: a tenth), so that another
  /// way must be that much shorter to be taken.
  void prefer(const Path2& path, double surroundings_m, double surcharge);

  /// In window cells: a cell minus origin().
  const WeightGrid& weights() const { return weights_; }
  /// The grid's window at the last update: its lowest cell.
  Cell origin() const { return origin_; }
  Cell toWindow(Cell cell) const { return {cell.x - origin_.x, cell.y - origin_.y}; }
  /// Makes cells within a distance of a window cell lethal, until the next update.
  void block(Cell window_cell, double radius_m);
  /// The same for the tight cells within a distance only.
  void blockTight(Cell window_cell, double radius_m);
  /// Distance below which a cell is lethal, or tight [m].
  double lethal_m() const { return lethal_m_; }
  /// Distance from a window cell to the nearest obstacle, at most about inflation_m [m].
  double clearance_m(Cell window_cell) const;

 private:
  void read(const RollingGrid& grid);
  void measureClearance();
  void fillShadows(double assumed_depth_m);
  void makeTable();
  void weigh(Cell start);
  void blockNearer(Cell window_cell, double radius_m, double clearance_m);
  void relaxAround(Cell window_start);

  CostMapParams params_;
  double cell_m_;
  double lethal_m_;
  double tight_m_;  ///< below it nothing is passable
  int reach_;       ///< cells up to which clearance is measured
  Cell origin_;
  std::vector<RollingGrid::State> states_;
  std::vector<std::uint16_t> column_;      ///< distance along y to the nearest obstacle [cells]
  std::vector<std::uint16_t> squared_;     ///< squared distance to the nearest obstacle [cells^2]
  std::vector<std::uint16_t> known_;       ///< weight of a seen cell by its squared distance
  std::vector<std::uint16_t> unknown_;     ///< likewise of one never seen
  std::vector<std::uint8_t> surrounding_;  ///< scratch of prefer()
  WeightGrid weights_;
};

}  // namespace frugal_nav
