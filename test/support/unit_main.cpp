#include <gmock/gmock.h>

// catkin links GoogleTest without its main().
int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
