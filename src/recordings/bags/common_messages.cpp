#include "recordings/bags/common_messages.hpp"

#include <map>

namespace veridyn::bags {

const char* common_message(const std::string& type, bool ros2) {
  if (type == "std_msgs/Header")
    return ros2 ? "time stamp\nstring frame_id\n" : "uint32 seq\ntime stamp\nstring frame_id\n";
  static const std::map<std::string, const char*> kTypes = {
      {"sensor_msgs/JointState",
       "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
       "float64[] effort\n"},
      {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
      {"geometry_msgs/Wrench", "Vector3 force\nVector3 torque\n"},
      {"geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n"},
      {"geometry_msgs/Pose", "Point position\nQuaternion orientation\n"},
      {"geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n"},
      {"geometry_msgs/WrenchStamped", "std_msgs/Header header\nWrench wrench\n"},
      {"geometry_msgs/TwistStamped", "std_msgs/Header header\nTwist twist\n"},
      {"geometry_msgs/PoseStamped", "std_msgs/Header header\nPose pose\n"},
      {"geometry_msgs/TransformStamped",
       "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"},
      {"std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n"},
      {"std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset\n"},
      {"std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data\n"},
      {"std_msgs/Float32MultiArray", "MultiArrayLayout layout\nfloat32[] data\n"},
      {"std_msgs/Float64", "float64 data\n"},
      {"std_msgs/Float32", "float32 data\n"},
      {"std_msgs/Bool", "bool data\n"},
      {"std_msgs/String", "string data\n"},
      {"std_msgs/Empty", ""},
      {"sensor_msgs/Joy", "std_msgs/Header header\nfloat32[] axes\nint32[] buttons\n"}};
  const auto found = kTypes.find(type);
  return found == kTypes.end() ? nullptr : found->second;
}

}  // namespace veridyn::bags
