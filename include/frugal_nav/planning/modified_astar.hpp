#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {

struct ModifiedAStarParams {
  std::string mode = "default";
  double cell_m = 0.2;
  double kappa = 2.0;
  double eta = 0.25;
  double detour_m = 2.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "mode", mode,
        Field{"",
              "default: through the gap node where that is no detour; literal: the cost is erased at the gap "
              "node, as the paper prints it",
              -HUGE_VAL, HUGE_VAL, "default|literal"});
    visit("cell_m", cell_m,
          Field{"m",
                "side of a cell; 0.2 [paper] resolves passages wider than the robot's inflated width by that "
                "much, 0.05 those of 1.5 robot widths",
                0.02, 1.0});
    visit(
        "kappa", kappa,
        Field{"", "how much dearer a step aside is at the start than at the goal, where it costs its length",
              0.0, 20.0});
    visit("eta", eta,
          Field{"", "the way through the gap may be this part longer than the direct one", 0.0, 5.0});
    visit("detour_m", detour_m,
          Field{"m", "how far around robot, gap and goal the instantaneous grid reaches", 0.2, 20.0});
  }
};

/// The A* of paper 000 on a grid made for one search: it starts in the robot, its vertical axis points from
/// the mission's start to its goal.
///
/// A vertical step costs the cell's side, a horizontal one m_h times that with m_h = 1 + kappa h(n) / h_0, a
/// diagonal one sqrt(1 + m_h^2) times; h(n) is the straight distance from the node left to the goal, h_0 that
/// at the start of the mission. All of it times the cost of the place entered. 8-connected, without cutting
/// corners.
class ModifiedAStar {
 public:
  /// Cost of a metre at a place of the odom frame, 1 or more; infinite where the robot cannot be.
  using Cost = std::function<double(const Eigen::Vector2d& p_odom)>;

  /// What one search is about, in odom.
  struct Query {
    Eigen::Vector2d robot;
    Eigen::Vector2d goal;
    std::optional<Eigen::Vector2d> gap;
    double goal_tolerance_m = 0.0;  ///< a goal that cannot be reached is replaced by a place within this
  };

  struct Result {
    enum class Status {
      kFound,
      kGoalBlocked,  ///< nowhere within the tolerance around the goal can the robot be
      kNoPath,       ///< everything reachable was searched
      kBadInput,     ///< no mission, or a place that is not finite or too far away
    };
    Status status = Status::kNoPath;
    std::vector<Eigen::Vector2d> points;  ///< in odom, cell by cell, the robot's place first
    double cost = 0.0;                    ///< sum of the steps' costs [m]
    double length_m = 0.0;
    bool through_gap = false;
    bool reaches_goal = false;  ///< the last point is the goal itself
  };

  /// Throws ConfigError on parameters out of range.
  explicit ModifiedAStar(const ModifiedAStarParams& params);
  /// Other parameters from the next plan on; the mission stays. Throws ConfigError.
  void setParams(const ModifiedAStarParams& params);

  /// A new mission: where it started and where it leads, in odom.
  void startMission(const Eigen::Vector2d& start, const Eigen::Vector2d& goal);
  /// The same mission's goal has moved: the axis follows, h_0 stays that of the start.
  void moveGoal(const Eigen::Vector2d& goal);
  /// No mission any more.
  void endMission() { start_.reset(); }

  /// Searches from the robot to the goal.
  Result plan(const Query& query, const Cost& cost);

  /// Replaces runs of points by straight lines wherever the line costs no more under the same measure; the
  /// corners that remain.
  std::vector<Eigen::Vector2d> straighten(const std::vector<Eigen::Vector2d>& points, const Cost& cost) const;

  /// m_h at a place of the odom frame.
  double horizontalFactor(const Eigen::Vector2d& p_odom) const;
  /// The vertical axis of the planning grid, in odom.
  Eigen::Vector2d vertical() const { return vertical_; }
  const ModifiedAStarParams& params() const { return params_; }
  /// Nodes taken from the open list by the last plan().
  int expanded() const { return expanded_; }

 private:
  struct Node {
    double cost = 0.0;
    std::int32_t parent = -1;
    bool open = false;
    bool closed = false;
  };

  void layGrid(const Query& query);
  Cell cellOf(const Eigen::Vector2d& p_odom) const;
  Eigen::Vector2d placeOf(Cell cell) const;
  bool contains(Cell cell) const;
  std::size_t indexOf(Cell cell) const;
  double costAt(Cell cell, const Cost& cost);
  std::optional<Cell> freeCellNear(Cell cell, double tolerance_m, const Cost& cost);
  std::optional<Cell> closedCellNear(Cell cell, double tolerance_m) const;
  bool search(Cell start, Cell goal, const std::optional<Cell>& costless, const Cost& cost);
  std::vector<Cell> trace(Cell end) const;
  Result route(Cell start, Cell target, Cell goal, const Query& query, const Cost& cost);
  Result resultOf(const std::vector<Cell>& cells, double cost) const;
  double lineCost(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Cost& cost) const;
  double anisotropicLength(const Eigen::Vector2d& step, double m_h) const;

  ModifiedAStarParams params_;
  std::optional<Eigen::Vector2d> start_;
  Eigen::Vector2d goal_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d vertical_ = Eigen::Vector2d::UnitY();
  double h0_m_ = 1.0;

  Eigen::Vector2d robot_ = Eigen::Vector2d::Zero();  ///< cell (0, 0) is centred on it
  Cell lowest_;
  int width_ = 0;
  int height_ = 0;
  std::vector<double> costs_;  ///< of places, as far as asked for; negative: not yet
  std::vector<Node> nodes_;
  int expanded_ = 0;
};

}  // namespace frugal_nav
