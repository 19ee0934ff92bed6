#pragma once

#include <cstdint>
#include <functional>

#include <ros/callback_queue_interface.h>

namespace frugal_nav {

/// Lets a nodelet speak once more when its process is told to end, by SIGINT, SIGTERM or `rosnode kill`:
/// roscpp's own handlers close the connections before any destructor could. The process ends as it would
/// have, a moment later.
class LastWord {
 public:
  /// `say` is called once, by the queue that calls the nodelet's callbacks.
  LastWord(ros::CallbackQueueInterface& queue, std::function<void()> say);
  ~LastWord();
  LastWord(const LastWord&) = delete;  // the handler knows it
  LastWord& operator=(const LastWord&) = delete;

 private:
  std::uint64_t id_;
};

}  // namespace frugal_nav
