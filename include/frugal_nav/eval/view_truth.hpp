#pragma once

#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <frugal_nav/sim/people.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::eval {

/// A camera that looks somewhere: what a picture's truth is computed for.
struct Viewpoint {
  cv::Size size_px;
  cv::Matx33d camera_matrix;        ///< pixel centres have integer coordinates, as in OpenCV
  cv::Vec<double, 5> distortion{};  ///< plumb-bob k1, k2, p1, p2, k3
  Eigen::Isometry3d world_from_optical = Eigen::Isometry3d::Identity();
};

/// What each pixel truly shows, without noise.
struct ViewTruth {
  cv::Mat depth_m;  ///< CV_32FC1, metres along the optical axis, infinite where a ray meets nothing
  cv::Mat model;    ///< CV_32SC1, index into Scene::models, -1 for nothing
  cv::Mat mesh;     ///< CV_32SC1, index into Scene::meshes, -1 for nothing
};

/// Traces one ray a pixel.
ViewTruth traceTruth(const sim::RayTracer& tracer, const Viewpoint& view);

/// The box around what is seen of a head or a whole person.
struct PersonBox {
  bool is_head = false;
  int person = -1;          ///< index into Scene::people
  cv::Rect2d box_px;        ///< pixel edges: the image spans (0, 0) to (width, height)
  double visible = 0.0;     ///< share of its outline that is seen, 0..1; occluded and outside count alike
  double distance_m = 0.0;  ///< of the head's middle, on the ground, from the camera
};

/// Share of its hull from which a head counts as seen whole: heads fill 0.83 of it and more.
constexpr double kWholeHead = 0.85;

/// Boxes of everybody of whom a pixel is seen. A head's box is as wide as what is seen of it between chin and
/// crown, and as high as its skull, an ellipsoid about the head's middle: each way across the line of sight
/// sqrt(0.118^2 cos^2 e + 0.10^2 sin^2 e) metres at elevation e, times the root of the person's height over
/// 1.75 m. So HeadRange tells the distance from it; hair and neck would belie it. A head less visible than
/// kWholeHead has the part of that height that is seen.
std::vector<PersonBox> findPeople(const ViewTruth& truth, const sim::Scene& scene,
                                  const std::vector<sim::PersonBody>& people, const Viewpoint& view);

}  // namespace frugal_nav::eval
