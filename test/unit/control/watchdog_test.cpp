#include <gtest/gtest.h>

#include <frugal_nav/control/watchdog.hpp>

namespace frugal_nav {
namespace {

TEST(Watchdog, SaysWhatIsWrong) {
  Watchdog watchdog;
  watchdog.watch("scan", 0.5);
  EXPECT_EQ(watchdog.fault("scan", stampFromSeconds(1.0)), "no scan yet");
  watchdog.feed("scan", stampFromSeconds(1.0));
  EXPECT_EQ(watchdog.fault("scan", stampFromSeconds(1.5)), std::nullopt) << "the time-out itself is in time";
  EXPECT_EQ(watchdog.fault("scan", stampFromSeconds(1.61)), "scan is 0.61 s old, more than 0.50 s");
}

TEST(Watchdog, AnInputNobodyWatchesIsAFault) {
  const Watchdog watchdog;
  EXPECT_TRUE(watchdog.fault("path", stampFromSeconds(1.0)));
}

TEST(Watchdog, NoticesTimeRunningBackward) {
  Watchdog watchdog;
  watchdog.watch("odom", 0.25);
  EXPECT_TRUE(watchdog.feed("odom", stampFromSeconds(2.0)));
  EXPECT_TRUE(watchdog.feed("odom", stampFromSeconds(2.0)));
  EXPECT_FALSE(watchdog.feed("odom", stampFromSeconds(1.9)));
}

TEST(Watchdog, ANewTimeOutKeepsTheStamp) {
  Watchdog watchdog;
  watchdog.watch("odom", 0.25);
  watchdog.feed("odom", stampFromSeconds(2.0));
  watchdog.watch("odom", 1.0);
  EXPECT_FALSE(watchdog.fault("odom", stampFromSeconds(2.9)));
}

}  // namespace
}  // namespace frugal_nav
