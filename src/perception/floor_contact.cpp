#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/floor_contact.hpp>

namespace frugal_nav {
namespace {

/// The rows of one column from the bottom up to the horizon: index 0 is the bottom row.
struct Column {
  std::vector<float> floor;            // inverse depth of the floor [1/m]
  std::vector<float> fitted;           // that of the network, fitted; empty when unknown
  std::vector<float> evidence;         // for floor, by its looks; empty when unknown
  std::vector<float> height_by_depth;  // of a point at depth one, over the camera
  float camera_height_m = 0.0F;

  std::size_t size() const { return floor.size(); }
  /// Height over the floor of what is seen in a row at an inverse depth.
  float heightAt(std::size_t i, float inverse_depth) const {
    return camera_height_m + height_by_depth[i] / inverse_depth;
  }
};

Column columnOf(int column, const cv::Mat& evidence, const cv::Mat& inverse, const ViewRays& rays,
                const FloorContactParams& params) {
  Column c;
  c.camera_height_m = static_cast<float>(rays.cameraHeight_m());
  const int first = rays.firstRowBelowHorizon(column, params.horizon_margin_rad);
  for (int row = rays.grid().height - 1; row >= first; --row) {
    c.floor.push_back(rays.inverseFloorDepth(row, column));
    if (!evidence.empty()) c.evidence.push_back(evidence.at<float>(row, column));
    c.height_by_depth.push_back(rays.ray(row, column).z());
    if (!inverse.empty()) c.fitted.push_back(inverse.at<float>(row, column));
  }
  return c;
}

class Line {
 public:
  Line(const Column& column, const FloorContactParams& params) : c_(column), params_(params) {
    const double cap = params.truncation * params.truncation;
    neutral_ = c_.fitted.empty() ? 0.0 : 0.5 * cap;
  }

  /// Cost of a row as floor.
  double asFloor(std::size_t i) const { return geometry(i, c_.floor[i]) + looks(i, true); }
  /// Cost of a row as part of a thing at an inverse depth.
  double asThing(std::size_t i, float inverse_depth) const {
    return geometry(i, inverse_depth) + looks(i, false);
  }

  /// Cost of the rows from `line` up as a thing that stands there; above its height nothing is said. What the
  /// depth errs by is much the same all over one thing, so that it does not count row by row.
  double above(std::size_t line, float inverse_depth) const {
    const float scale = scaleAt(line, inverse_depth);
    constexpr double kRows = 5.0;  // that it counts as
    double cost = kRows * geometryOf(std::log(scale), params_.geometry_sigma);
    inverse_depth *= scale;
    for (std::size_t i = line; i < c_.size(); ++i) {
      // At least three rows, else a far thing would need none.
      const bool within =
          i < line + 3 || c_.heightAt(i, inverse_depth) < static_cast<float>(params_.stand_height_m);
      cost += within ? asThing(i, inverse_depth) : neutral_ + 0.5 * strength(i);
    }
    return cost;
  }

  double edgeBonus(std::size_t line) const {
    const bool is_edge =
        !c_.evidence.empty() && line > 0 && c_.evidence[line - 1] > 0.0F && c_.evidence[line] <= 0.0F;
    return is_edge ? params_.edge_bonus : 0.0;
  }

 private:
  /// How much nearer the lowest rows of a thing are by the fitted depth than it stands.
  float scaleAt(std::size_t line, float inverse_depth) const {
    constexpr std::size_t kRows = 7;
    constexpr float kMost = 1.5F;
    const std::size_t end = std::min(line + kRows, c_.fitted.size());
    if (line >= end) return 1.0F;
    std::vector<float> low(c_.fitted.begin() + static_cast<std::ptrdiff_t>(line),
                           c_.fitted.begin() + static_cast<std::ptrdiff_t>(end));
    const auto middle = low.begin() + static_cast<std::ptrdiff_t>(low.size() / 2);
    std::nth_element(low.begin(), middle, low.end());
    return std::clamp(*middle / inverse_depth, 1.0F / kMost, kMost);
  }
  double geometryOf(float error, double sigma) const {
    const double r = static_cast<double>(error) / sigma;
    return std::min(r * r, params_.truncation * params_.truncation);
  }
  /// How much the looks say in a row, whatever they say.
  double strength(std::size_t i) const {
    return c_.evidence.empty() ? 0.0 : static_cast<double>(std::abs(c_.evidence[i]));
  }
  double looks(std::size_t i, bool expects_floor) const {
    if (c_.evidence.empty()) return 0.0;
    return (c_.evidence[i] > 0.0F) == expects_floor ? 0.0 : strength(i);
  }
  double geometry(std::size_t i, float expected) const {
    if (c_.fitted.empty()) return 0.0;
    return geometryOf(c_.fitted[i] - expected, params_.geometry_sigma * static_cast<double>(expected) + 0.02);
  }

  const Column& c_;
  const FloorContactParams& params_;
  double neutral_ = 0.0;
};

/// Inverse depth of what fills the bottom rows, nearer than the floor there; 0 when the floor does. What does
/// not look like floor there stands nearer than the floor that it hides, whatever the depth says.
float hiddenDepth(const Column& c) {
  const std::size_t count = std::min<std::size_t>(c.size(), 8);
  const auto end = static_cast<std::ptrdiff_t>(count);
  const auto speaks_against = [](float evidence) { return evidence <= 0.0F; };
  const bool is_other = !c.evidence.empty() &&
                        2 * std::count_if(c.evidence.begin(), c.evidence.begin() + end, speaks_against) > end;
  const float least = 1.05F * c.floor.front();
  if (c.fitted.empty()) return is_other ? least : 0.0F;
  std::vector<float> bottom(c.fitted.begin(), c.fitted.begin() + end);
  std::nth_element(bottom.begin(), bottom.begin() + end / 2, bottom.end());
  const float median = bottom[count / 2];
  if (is_other) return std::max(median, least);
  return median > c.floor.front() ? median : 0.0F;
}

FloorContact contactOf(const Column& c, int bottom_row, const FloorContactParams& params) {
  FloorContact contact;
  if (c.size() == 0) return contact;
  const Line line(c, params);
  double below = 0.0;  // cost of the rows under the line, as floor
  double best = std::numeric_limits<double>::infinity();
  const float hidden = hiddenDepth(c);
  if (hidden > 0.0F) best = line.above(0, hidden);
  contact.row = bottom_row + 1;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const bool is_far = c.floor[i] * static_cast<float>(params.max_depth_m) < 1.0F;
    if (i > 0 && !is_far) {
      const double cost = below + line.above(i, c.floor[i]) - line.edgeBonus(i);
      if (cost < best) {
        best = cost;
        contact.state = FloorContact::State::kContact;
        contact.row = bottom_row - static_cast<int>(i);
      }
    }
    below += line.asFloor(i);
  }
  if (below <= best) {
    contact.state = FloorContact::State::kOpen;
    contact.row = bottom_row + 1 - static_cast<int>(c.size());
  }
  return contact;
}

/// A line that leaves the median of its neighbours' by far is taken as theirs.
void smooth(int reach, std::vector<FloorContact>& contacts) {
  if (reach == 0) return;
  constexpr int kMostOff_cells = 3;
  const std::vector<FloorContact> raw = contacts;
  const int count = static_cast<int>(raw.size());
  for (int i = 0; i < count; ++i) {
    std::vector<const FloorContact*> window;
    for (int k = std::max(0, i - reach); k <= std::min(count - 1, i + reach); ++k)
      window.push_back(&raw[static_cast<std::size_t>(k)]);
    const auto middle = window.begin() + static_cast<std::ptrdiff_t>(window.size() / 2);
    std::nth_element(window.begin(), middle, window.end(),
                     [](const FloorContact* a, const FloorContact* b) { return a->row < b->row; });
    FloorContact& own = contacts[static_cast<std::size_t>(i)];
    if (std::abs(own.row - (*middle)->row) > kMostOff_cells) own = **middle;
  }
}

float colourStep(const cv::Vec3f& a, const cv::Vec3f& b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

struct Edge {
  double row = 0.0;  // the line between two rows [px]
  double strength = 0.0;
};

/// Sums of the colours of a strip of the image from its first row on: element i is that of the first i rows.
std::vector<cv::Vec3f> sumsOf(const cv::Mat& strip) {
  std::vector<cv::Vec3f> sums{cv::Vec3f()};
  const float share = 1.0F / static_cast<float>(strip.cols);
  for (int row = 0; row < strip.rows; ++row) {
    const auto* pixels = strip.ptr<cv::Vec3b>(row);
    cv::Vec3f sum;
    for (int column = 0; column < strip.cols; ++column) sum += cv::Vec3f(pixels[column]);
    sums.push_back(sums.back() + share * sum);
  }
  return sums;
}

/// Change of the mean colour from `reach` rows to the next ones, which begin at `row`.
float stepAt(const std::vector<cv::Vec3f>& sums, int row, int reach) {
  const auto i = static_cast<std::size_t>(row);
  const auto n = static_cast<std::size_t>(reach);
  return colourStep(sums[i] - sums[i - n], sums[i + n] - sums[i]) / static_cast<float>(reach);
}

constexpr int kCoarseRows = 6;
constexpr int kFineRows = 2;

/// The strongest change within a strip of the image, the more likely the nearer to the row where it is
/// expected. Means over some rows look past the pattern of thing and floor; those over fewer tell the row.
Edge strongestEdge(const cv::Mat& bgr, const cv::Rect& strip, double expected_row, double sigma_px) {
  const std::vector<cv::Vec3f> sums = sumsOf(bgr(strip));
  Edge edge{expected_row, 0.0};
  const int reach = std::clamp(strip.height / 6, kFineRows, kCoarseRows);
  int best = 0;
  double most = 0.0;
  for (int row = reach; row + reach <= strip.height; ++row) {
    const double off = (strip.y + row - 0.5 - expected_row) / sigma_px;
    const double likely = static_cast<double>(stepAt(sums, row, reach)) * std::exp(-0.5 * off * off);
    if (likely <= most) continue;
    most = likely;
    best = row;
  }
  if (best == 0) return edge;
  const int first = std::max(kFineRows, best - kFineRows);
  const int last = std::min(strip.height - kFineRows, best + kFineRows);
  for (int row = first; row <= last; ++row) {
    const auto step = static_cast<double>(stepAt(sums, row, kFineRows));
    if (step > edge.strength) edge = {strip.y + row - 0.5, step};
  }
  return edge;
}

}  // namespace

cv::Mat floorEvidence(const cv::Mat& mask_or_probability, const FloorContactParams& params) {
  cv::Mat evidence;
  if (mask_or_probability.type() == CV_8UC1) {
    mask_or_probability.convertTo(evidence, CV_32F, 2.0 * params.colour_cost / 255.0, -params.colour_cost);
    return evidence;
  }
  constexpr double kLeast = 1e-6;
  const cv::Mat probability = cv::min(cv::max(mask_or_probability, kLeast), 1.0 - kLeast);
  cv::Mat odds = probability / (1.0 - probability);
  cv::log(odds, evidence);
  return params.network_cost * cv::min(cv::max(evidence, -params.network_cap), params.network_cap);
}

std::vector<FloorContact> findFloorContacts(const cv::Mat& evidence, const cv::Mat& inverse_depth_pm,
                                            const ViewRays& rays, const FloorContactParams& params) {
  std::vector<FloorContact> contacts;
  for (int column = 0; column < rays.grid().width; ++column) {
    contacts.push_back(contactOf(columnOf(column, evidence, inverse_depth_pm, rays, params),
                                 rays.grid().height - 1, params));
  }
  smooth(params.smooth_columns, contacts);
  return contacts;
}

void refineContacts(const cv::Mat& bgr, const ViewRays& rays, const FloorContactParams& params,
                    std::vector<FloorContact>& contacts) {
  const cv::Size& grid = rays.grid();
  const double cell_px = static_cast<double>(bgr.rows) / grid.height;
  const cv::Rect image(0, 0, bgr.cols, bgr.rows);
  for (int column = 0; column < grid.width; ++column) {
    FloorContact& contact = contacts[static_cast<std::size_t>(column)];
    if (contact.state != FloorContact::State::kContact) continue;
    const double coarse = rays.toImage({column, contact.row + 0.5}).y();
    const double middle = rays.toImage({column, contact.row}).x();
    const double line_sigma = params.blurred_sigma_cells * cell_px;
    // Cut off on one side only, the strip would draw the line to the other.
    const int reach = std::min(cvCeil(2.5 * line_sigma) + kCoarseRows, bgr.rows - cvRound(coarse));
    const int half_width = std::max(1, cvRound(0.5 * cell_px));
    const cv::Rect strip =
        cv::Rect(cvRound(middle) - half_width, cvRound(coarse) - reach, 2 * half_width + 1, 2 * reach + 2) &
        image;
    const Edge edge = strongestEdge(bgr, strip, coarse, line_sigma);
    const bool is_sharp = edge.strength >= 3.0 * params.min_edge;
    contact.image_row = is_sharp ? edge.row : coarse;
    const double row_sigma = is_sharp ? params.sharp_sigma_px : line_sigma;
    const Eigen::Vector3d ray = rays.rayThrough({middle, contact.image_row});
    const double inverse = -ray.z() / rays.cameraHeight_m();
    if (!(inverse * params.max_depth_m > 1.0)) {
      contact.state = FloorContact::State::kOpen;
      continue;
    }
    contact.depth_m = 1.0 / inverse;
    const double angle = std::hypot(row_sigma / rays.camera().fy, params.pitch_sigma_rad);
    contact.sigma_m = contact.depth_m * contact.depth_m / rays.cameraHeight_m() * angle;
  }
}

cv::Mat floorOf(const std::vector<FloorContact>& contacts, const ViewRays& rays) {
  cv::Mat floor = cv::Mat::zeros(rays.grid(), CV_8UC1);
  for (int column = 0; column < rays.grid().width; ++column) {
    const FloorContact& contact = contacts[static_cast<std::size_t>(column)];
    const int first = contact.state == FloorContact::State::kContact ? contact.row + 1
                      : contact.state == FloorContact::State::kOpen  ? contact.row
                                                                     : rays.grid().height;
    for (int row = first; row < rays.grid().height; ++row) floor.at<uchar>(row, column) = 255;
  }
  return floor;
}

}  // namespace frugal_nav
