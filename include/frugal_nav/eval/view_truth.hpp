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

/// Boxes of everybody of whom a pixel is seen. A head reaches from the skull's crown down to the chin; hair
/// counts between these heights only, since what stands or hangs out would belie the distance that the
/// box's height tells.
std::vector<PersonBox> findPeople(const ViewTruth& truth, const sim::Scene& scene,
                                  const std::vector<sim::PersonBody>& people, const Viewpoint& view);

}  // namespace frugal_nav::eval
