#pragma once

#include <string>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// What all nodes share that need the robot's pose at a sensor reading's stamp. This header needs no ROS.
struct IntakeParams {
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  double odom_wait_s = 0.25;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("odom_frame", odom_frame, atStart(Field{"", "frame of odometry and of all that is given in it"}));
    visit("base_frame", base_frame,
          atStart(Field{"", "frame of the body, in which tf gives the sensor's pose"}));
    visit("odom_wait_s", odom_wait_s,
          atStart(Field{"s", "ROS time a reading waits for odometry of its stamp before it is given up", 0.01,
                        5.0}));
  }
};

/// What the nodes share that take images.
struct ImageIntakeParams {
  IntakeParams base;
  std::string image_transport = "raw";
  double silent_after_s = 2.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    base.fields(visit);
    visit("image_transport", image_transport,
          atStart(Field{
              "", "how images come: raw, or a transport whose plugin is installed (compressed, theora)"}));
    visit("silent_after_s", silent_after_s,
          atStart(Field{"s", "ROS time without an image after which the camera is reported as silent", 0.1,
                        60.0}));
  }
};

}  // namespace frugal_nav
