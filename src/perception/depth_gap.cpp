#include "detector_support.hpp"
#include "metric_cues.hpp"
#include "standing_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/depth_gap.hpp>
#include <frugal_nav/perception/image_fault.hpp>

namespace frugal_nav {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr float kLeastInverse_pm = 0.01F;
// What stands is no farther than its points, but for their scatter.
constexpr double kScatter = 0.8;

std::string faultOf(const DepthView& view) {
  const std::string fault = viewFault(view.bgr, view.camera, view.odom_from_base);
  if (!fault.empty()) return fault;
  if (!view.base_from_optical.matrix().allFinite()) return "the camera's pose is not finite";
  if (view.base_from_optical.translation().z() < 0.02) return "the camera lies below the floor";
  return {};
}

}  // namespace

struct DepthGap::Impl {
  Impl(std::unique_ptr<DepthNetwork> depth_network, const DepthGapParams& p)
      : params(validated(p, "depth_gap")),
        network(std::move(depth_network)),
        floor(p.floor),
        memory(p.memory),
        filter(p.fit),
        motion(p.obstacle) {}

  void reset() {
    floor.reset();
    memory.reset();
    filter.reset();
    motion.reset();
    last_stamp.reset();
  }

  void useRays(const DepthView& view) {
    const Pinhole camera = view.camera.scaled(view.bgr.cols, view.bgr.rows);
    const int rows = static_cast<int>(
        std::lround(static_cast<double>(params.grid_width_px) * view.bgr.rows / view.bgr.cols));
    const cv::Size grid(params.grid_width_px, rows);
    if (!rays || !rays->fits(camera, view.base_from_optical, grid))
      rays = std::make_unique<ViewRays>(camera, view.base_from_optical, grid);
  }

  DepthFrame refuse(const DepthView& view, const std::string& fault) const {
    DepthFrame frame;
    frame.stamp = frame.gap.stamp = frame.obstacle.stamp = view.stamp;
    frame.fault = frame.gap.reason = frame.obstacle.reason = fault;
    frame.scan = unknownScan(rays.get(), view.stamp, params.scan);
    return frame;
  }

  cv::Mat toGrid(const cv::Mat& map) const {
    if (map.empty()) return {};
    cv::Mat on_grid;
    const bool shrinks = map.cols > rays->grid().width;
    cv::resize(map, on_grid, rays->grid(), 0.0, 0.0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
    return on_grid;
  }

  cv::Mat fittedInverse(const cv::Mat& inverse, const MetricFit& fit) const {
    if (!fit.known) return {};
    return cv::max(cv::Mat(fit.a * inverse + fit.b), kLeastInverse_pm);
  }

  /// A fitted inverse depth mended by known ones; empty while there is no fit.
  cv::Mat mendedBy(const std::vector<DepthAnchor>& anchors, const cv::Mat& fitted) const {
    return fitted.empty() || anchors.empty() ? fitted : correctDepth(fitted, anchors, params.correction);
  }

  void fitMetres(const DepthView& view, bool with_points, const cv::Mat& floor_mask, DepthFrame& frame) {
    if (params.method == "unscaled") {
      frame.fit.known = true;
      frame.fit.a = params.unscaled_factor_pm;
      return;
    }
    std::vector<MetricSample> samples;
    if (with_points) samples = voSamples(view, *rays, frame.inverse, params.vo_scale_sigma);
    if (params.method == "fused") {
      append(floorSamples(floor_mask, *rays, frame.inverse, params.contact.pitch_sigma_rad), samples);
      append(goalSamples(view, *rays, frame.inverse, params.min_goal_sigma), samples);
    }
    frame.fit = filter.update(view.stamp, samples);
  }

  /// What the looks say of the floor: by the network where it tells, else by colour.
  cv::Mat lookForFloor(const cv::Mat& small, const cv::Mat& probability, const cv::Mat& expected) {
    if (!probability.empty() && params.use_network_floor) return floorEvidence(probability, params.contact);
    return floorEvidence(floor.find(small, *rays, likelyFloor(expected)), params.contact);
  }

  /// Where the floor is by the last scale alone; empty while there is none.
  cv::Mat likelyFloor(const cv::Mat& expected) const {
    if (expected.empty()) return {};
    return floorOf(findFloorContacts({}, expected, *rays, params.contact), *rays);
  }

  /// What looks like floor, without what stands on it by the last scale.
  cv::Mat floorBefore(const cv::Mat& evidence, const cv::Mat& expected) const {
    const cv::Mat looks = evidence > 0.0;
    if (expected.empty()) return looks;
    return looks & floorOf(findFloorContacts(evidence, expected, *rays, params.contact), *rays);
  }

  /// Mends the fitted depth by all that is known in metres, and says how sure it then is.
  cv::Mat mend(const std::vector<DepthAnchor>& anchors, const cv::Mat& fitted, cv::Mat& sigma) const {
    const double network_sigma = params.correction.network_sigma;
    sigma = cv::Mat(fitted.size(), CV_32FC1, cv::Scalar(network_sigma));
    if (fitted.empty() || params.method == "unscaled") return fitted;
    cv::Mat weight;
    cv::Mat mended = correctDepth(fitted, anchors, params.correction, &weight);
    cv::Mat share;
    cv::sqrt(1.0 - weight, share);
    sigma = network_sigma * share + 0.01;
    return mended;
  }

  /// Depths of the grid; the floor's own where it is floor.
  cv::Mat depthOf(const cv::Mat& inverse_pm, const DepthFrame& frame) const {
    cv::Mat depth = 1.0 / inverse_pm;
    if (params.method != "fused") return depth;
    for (int row = 0; row < depth.rows; ++row) {
      for (int column = 0; column < depth.cols; ++column) {
        const float floor_pm = rays->inverseFloorDepth(row, column);
        if (frame.floor.at<uchar>(row, column) != 0 && floor_pm > kLeastInverse_pm)
          depth.at<float>(row, column) = 1.0F / floor_pm;
      }
    }
    return depth;
  }

  NearestObstacle nearest(const DepthView& view, const DepthFrame& frame) {
    NearestObstacle obstacle;
    obstacle.stamp = view.stamp;
    std::optional<Eigen::Vector2d> p_base_goal;
    if (view.goal) p_base_goal = view.odom_from_base.inverse() * view.goal->p_odom;
    std::vector<SeenObstacle> seen = joinColumns(frame.surfaces, p_base_goal, params.obstacle);
    const std::vector<Eigen::Vector2d> velocities = motion.update(view.stamp, view.odom_from_base, seen);
    if (seen.empty() || seen.front().distance_m > params.scan.max_range_m) {
      if (frame.depth_m.empty() && seen.empty()) obstacle.reason = "no metric scale is known yet";
      return obstacle;
    }
    const SeenObstacle& first = seen.front();
    const ColumnSurface& surface = frame.surfaces[static_cast<std::size_t>(first.nearest_column)];
    obstacle.found = true;
    obstacle.p_odom = view.odom_from_base * first.p_base;
    obstacle.distance_m = first.distance_m;
    obstacle.bearing_rad = std::atan2(first.p_base.y(), first.p_base.x());
    obstacle.sigma_m = static_cast<double>(surface.relative_sigma) * first.distance_m;
    obstacle.velocity_mps = velocities.front();
    setRegion(first, frame, view.bgr.size(), obstacle);
    obstacle.source = mainCue(first, obstacle, view, frame.contacts, params.method == "fused");
    return obstacle;
  }

  void setRegion(const SeenObstacle& seen, const DepthFrame& frame, const cv::Size& image,
                 NearestObstacle& obstacle) const {
    int top = rays->grid().height;
    int bottom = 0;
    for (int column = seen.first_column; column <= seen.last_column; ++column) {
      const auto k = static_cast<std::size_t>(column);
      top = std::min(top, frame.surfaces[k].top_row);
      const FloorContact& contact = frame.contacts[k];
      const bool is_open = contact.state == FloorContact::State::kOpen;
      bottom = std::max(bottom, is_open ? frame.surfaces[k].row : contact.row);
    }
    const Eigen::Vector2d low = rays->toImage({seen.first_column - 0.5, top - 0.5});
    const Eigen::Vector2d high = rays->toImage({seen.last_column + 0.5, bottom + 0.5});
    const cv::Rect box = cv::Rect(cv::Point(cvRound(low.x()), cvRound(low.y())),
                                  cv::Point(cvRound(high.x()) + 1, cvRound(high.y()) + 1)) &
                         cv::Rect(cv::Point(), image);
    obstacle.left_px = box.x;
    obstacle.top_px = box.y;
    obstacle.width_px = box.width;
    obstacle.height_px = box.height;
  }

  DepthFrame look(const DepthView& view) {
    if (last_stamp && view.stamp < *last_stamp) reset();
    last_stamp = view.stamp;
    const std::string fault = faultOf(view);
    if (!fault.empty()) return refuse(view, fault);
    useRays(view);
    DepthFrame frame;
    frame.stamp = view.stamp;
    const DepthPrediction prediction = network->infer(view.bgr);
    frame.inverse = toGrid(prediction.inverse);
    const cv::Mat probability = toGrid(prediction.floor);
    if (!cv::checkRange(frame.inverse) || !cv::checkRange(probability))
      return refuse(view, "the depth network gave numbers that are not finite");
    return understand(view, probability, std::move(frame));
  }

  DepthFrame understand(const DepthView& view, const cv::Mat& probability, DepthFrame frame) {
    cv::Mat small;
    cv::resize(view.bgr, small, rays->grid(), 0.0, 0.0, cv::INTER_AREA);
    const bool use_geometry = params.method == "fused";
    const std::vector<DepthAnchor> remembered =
        use_geometry ? memory.recall(view.stamp, view.odom_from_base, *rays) : std::vector<DepthAnchor>();
    const cv::Mat expected =
        use_geometry ? mendedBy(remembered, fittedInverse(frame.inverse, filter.fit())) : cv::Mat();
    std::vector<DepthAnchor> anchors = voAnchors(view, *rays, params.vo_scale_sigma);
    const bool agree = !use_geometry || agrees(anchors, expected);
    // Against what was known a moment ago they are a map of the wrong scale, or of wrong matches.
    const bool are_refused = !agree && !expected.empty();
    if (are_refused) anchors.clear();
    if (!agree) distrust(anchors);
    const std::vector<DepthAnchor> points = use_geometry ? agreedOn(anchors) : std::vector<DepthAnchor>();
    cv::Mat evidence = lookForFloor(small, probability, expected);
    const cv::Mat standing = findStanding(points, *rays, params.scan.max_height_m);
    confirmFloor(points, *rays, evidence);
    denyFloor(standing, evidence);
    append(standingAnchors(standing), anchors);
    fitMetres(view, !are_refused, floorBefore(evidence, expected), frame);
    const cv::Mat fitted = fittedInverse(frame.inverse, frame.fit);
    frame.contacts = findFloorContacts(evidence, use_geometry ? mendedBy(anchors, fitted) : cv::Mat(), *rays,
                                       params.contact);
    refineContacts(view.bgr, *rays, params.contact, frame.contacts);
    frame.floor = floorOf(frame.contacts, *rays);
    if (use_geometry && !fitted.empty()) {
      append(contactAnchors(frame.contacts, *rays, small, points, fitted), anchors);
      append(remembered, anchors);
    }
    cv::Mat sigma;
    cv::Mat mended = mend(anchors, fitted, sigma);
    if (!mended.empty()) mended = cv::max(mended, kScatter * standing);
    if (!mended.empty()) frame.depth_m = depthOf(mended, frame);
    if (use_geometry) memory.update(view.stamp, view.odom_from_base, *rays, frame.contacts);
    frame.surfaces = findSurfaces(mended, sigma, frame.contacts, *rays, params.scan);
    frame.scan = scanOf(frame.surfaces, *rays, view.stamp, params.scan);
    frame.profile = profileColumns(frame.inverse, frame.floor, *rays, params.floor.horizon_margin_rad);
    frame.near = openColumns(frame.profile, frame.surfaces, params.gap);
    frame.gap = findGap(frame.near, frame.surfaces, *rays, view.odom_from_base, params.gap);
    frame.gap.stamp = view.stamp;
    frame.obstacle = nearest(view, frame);
    return frame;
  }

  DepthGapParams params;
  std::unique_ptr<DepthNetwork> network;
  FloorMask floor;
  ContactMemory memory;
  MetricFilter filter;
  ObstacleMotion motion;
  std::unique_ptr<ViewRays> rays;
  std::optional<Stamp> last_stamp;
};

DepthGap::DepthGap(std::unique_ptr<DepthNetwork> network, const DepthGapParams& params)
    : impl_(std::make_unique<Impl>(std::move(network), params)) {}
DepthGap::~DepthGap() = default;
DepthGap::DepthGap(DepthGap&&) noexcept = default;
DepthGap& DepthGap::operator=(DepthGap&&) noexcept = default;

DepthFrame DepthGap::look(const DepthView& view) { return impl_->look(view); }
void DepthGap::setParams(const DepthGapParams& params) {
  impl_ = std::make_unique<Impl>(std::move(impl_->network), params);
}
void DepthGap::reset() { impl_->reset(); }

}  // namespace frugal_nav
