#include "veridyn/calibration/capture.hpp"

#include <gtest/gtest.h>

#include "cli/tool.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// One marker of each of two bodies at two times, in every layout; the second is hidden at the end.
class Layouts : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Layouts, EveryFileLayoutGivesTheSameMarkers) {
  const TemporaryFolder folder;
  const std::string path = folder.write("capture.csv", GetParam().second);
  const MarkerCapture found = read_markers(path);
  ASSERT_EQ(found.markers.size(), 2U);
  EXPECT_EQ(found.bodies(), (std::vector<std::string>{"base", "link"}));
  EXPECT_EQ(found.markers[1].name, "m2");
  ASSERT_EQ(found.time.size(), 2);
  EXPECT_NEAR(found.time[1] - found.time[0], 0.01, 1e-12);
  const MatrixXd& base = found.markers[0].position;
  EXPECT_NEAR(base(0, 1), 0.101, 1e-12);
  EXPECT_NEAR(base(1, 1), 0.2, 1e-12);
  EXPECT_NEAR(base(2, 1), -0.3, 1e-12);
  EXPECT_NEAR(found.markers[1].position(2, 0), 0.6, 1e-12);
  EXPECT_FALSE(found.markers[1].position.col(1).allFinite());
}

INSTANTIATE_TEST_SUITE_P(
    All, Layouts,
    testing::Values(
        std::make_pair("wide",
                       "t,base/m1/x,base/m1/y,base/m1/z,link/m2/x,link/m2/y,link/m2/z\n"
                       "0,0.1,0.2,-0.3,0.4,0.5,0.6\n0.01,0.101,0.2,-0.3,,,\n"),
        std::make_pair("millimetres",
                       "# unit: mm\nTime;base:m1_X;base:m1_Y;base:m1_Z;link:m2_X;link:m2_Y;link:m2_Z\n"
                       "0;100;200;-300;400;500;600\n0.01;101;200;-300;nan;nan;nan\n"),
        std::make_pair("units_in_names",
                       "t [s],base/m1/x [mm],base/m1/y [mm],base/m1/z [mm],link/m2/x [m],link/m2/y "
                       "[m],link/m2/z [m]\n0,100,200,-300,0.4,0.5,0.6\n0.01,101,200,-300,,,\n"),
        std::make_pair("long_layout",
                       "t,body,marker,x,y,z\n0,base,m1,0.1,0.2,-0.3\n0,link,m2,0.4,0.5,0.6\n"
                       "0.01,base,m1,0.101,0.2,-0.3\n"),
        std::make_pair("long_one_name",
                       "t\tmarker\tx\ty\tz\n0\tbase:m1\t0.1\t0.2\t-0.3\n0\tlink:m2\t0.4\t0.5\t0.6\n"
                       "0.01\tbase:m1\t0.101\t0.2\t-0.3\n"),
        std::make_pair("motive",
                       "Format Version,1.23,Take Name,a,Export Frame Rate,100.0,Length Units,"
                       "Millimeters\n\n,Type,Marker,Marker,Marker,Marker,Marker,Marker\n"
                       ",Name,base:m1,base:m1,base:m1,link:m2,link:m2,link:m2\n"
                       ",ID,1,1,1,2,2,2\n,,Position,Position,Position,Position,Position,Position\n"
                       "Frame,Time (Seconds),X,Y,Z,X,Y,Z\n0,0.0,100,200,-300,400,500,600\n"
                       "1,0.01,101,200,-300,,,\n"),
        std::make_pair("nexus",
                       "Trajectories\n100\n,,base:m1,,,link:m2,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n"
                       ",,mm,mm,mm,mm,mm,mm\n1,0,100,200,-300,400,500,600\n2,0,101,200,-300,,,\n"),
        std::make_pair("track_manager",
                       "NO_OF_FRAMES\t2\nFREQUENCY\t100\nMARKER_NAMES\tbase.m1\tlink.m2\n"
                       "100\t200\t-300\t400\t500\t600\n101\t200\t-300\t\t\t\n")),
    [](const auto& one) { return std::string(one.param.first); });

// A fault is named with its file, line and column.
TEST(Capture, AnInvalidFileIsRefusedWithItsLineAndColumn) {
  const TemporaryFolder folder;
  const auto fault = [&](const std::string& content) -> std::string {
    try {
      read_poses(folder.write("poses.csv", content));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(fault("t,x,y,z\n0,1,zwei,3\n").find("poses.csv:2:3: found 'zwei'"), std::string::npos);
  EXPECT_NE(fault("t,x,y,z\n0,1,2\n").find("poses.csv:2: found 3 fields, expected 4"),
            std::string::npos);
  EXPECT_NE(fault("t,x,y,z,qw,qx,qy,qz\n0,1,2,3,1,1,0,0\n").find("norm"), std::string::npos);
  EXPECT_NE(fault("t,x,y,z\n0,812,200,3\n").find("--unit mm"), std::string::npos);
  EXPECT_NE(fault("t,x [in],y [in],z [in]\n0,1,2,3\n").find("poses.csv:1: found 'in' as the unit of 'x [in]'"), std::string::npos);
  EXPECT_NE(fault("# unit: feet\nt,x,y,z\n0,1,2,3\n").find("found 'feet' as the unit of 'x', expected m, cm or mm"), std::string::npos);
  EXPECT_EQ(fault("# units of this file are kept\nt,x,y,z\n0,1,2,3\n"), "");
  EXPECT_EQ(fault("# all units are millimetres\nt,x,y,z\n0,812,200,3\n"), "");
  EXPECT_NE(fault("t,a,b\n0,1,2\n").find("no column of a position"), std::string::npos);
  EXPECT_NE(fault("t,q1,q3,x,y,z\n0,1,2,3,4,5\n").find("q3 but no q2"), std::string::npos);
  EXPECT_NE(fault("t,A/x,A/y,A/z,B/x,B/y,B/z\n0,1,2,3,4,5,6\n").find("--body"), std::string::npos);
}

// A body's pose from its markers turns as the markers do.
TEST(Capture, PoseOfABodyIsFoundFromItsMarkers) {
  const TemporaryFolder folder;
  const std::string path = folder.write(
      "markers.csv",
      "t,b/1/x,b/1/y,b/1/z,b/2/x,b/2/y,b/2/z,b/3/x,b/3/y,b/3/z\n"
      "0,0,0,0,0.1,0,0,0,0.05,0\n1,0,0,0,0,0.1,0,-0.05,0,0\n2,0,0,0,0,0.1,0,-0.05,0,0\n");
  const PoseCapture poses = read_poses(path);
  ASSERT_EQ(poses.frames(), 3);
  const Eigen::Isometry3d turn = poses.poses[1] * poses.poses[0].inverse();
  EXPECT_NEAR(turn.linear()(1, 0), 1.0, 1e-6);
  EXPECT_LT(turn.translation().norm(), 1e-6);
}

}  // namespace
}  // namespace veridyn
