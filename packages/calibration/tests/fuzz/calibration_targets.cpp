#include "fuzz/probe.hpp"

#include "veridyn/calibration/capture.hpp"

namespace veridyn {
namespace {

std::string probe_capture(std::string_view bytes) {
  const FileInMemory file(bytes);
  const std::string wrong = refusal_or([&] {
    const MarkerCapture read = read_markers(file.path());
    read.bodies();
    return std::string();
  });
  if (!wrong.empty()) return wrong;
  return refusal_or([&] {
    const PoseCapture read = read_poses(file.path());
    return std::string(read.time.size() == read.frames() ? "" : "times and poses differ in number");
  });
}

const AddFuzzTargets kTargets({
    {"capture", probe_capture,
     [] {
       return Seeds{
           "t,a/1/x,a/1/y,a/1/z,a/2/x,a/2/y,a/2/z,a/3/x,a/3/y,a/3/z\n0,0,0,0,1,0,0,0,1,0\n0.1,0,0,0.1,1,0,0.1,0,1,0.1\n",
           "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n0.1,1,2,3,0.7,0.7,0,0\n",
           "t,q1,q2,x,y,z\n0,0.1,0.2,1,2,3\n0.1,0.2,0.3,1,2,3\n",
           "t,body,marker,x [mm],y [mm],z [mm]\n0,a,1,0,0,0\n0,a,2,1,0,0\n0,a,3,0,1,0\n",
           "t,a/x,a/y,a/z,a/qw,a/qx,a/qy,a/qz\n0,0,0,0,1,0,0,0\n",
           "Format Version,1.23,Take Name,t\n\n,,Rigid Body,Rigid Body\n,,a,a\n,,1,1\n,,Position,Position\nFrame,Time (Seconds),X,Y\n0,0,1,2\n",
           "Trajectories\n100\n,,a:1,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n2,0,1,2,3\n",
           "NO_OF_FRAMES\t2\nNO_OF_MARKERS\t1\nFREQUENCY\t100\nMARKER_NAMES\ta1\n1\t2\t3\n1\t2\t3\n"};
     }},
});

}  // namespace
}  // namespace veridyn
